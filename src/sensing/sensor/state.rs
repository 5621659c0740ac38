//! State that every stage of the sensor shares: finger, drivetrain, friction record, calibration, and the events to report.

use super::collector::CurveCollector;
use super::weight;
use crate::finger::{Free, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::curve::{Curve, Point};
use crate::sensing::location::SeriesElement;
use crate::sensing::locator::{self, Data, Place, Prior};
use crate::sensing::settings::PIN_SIGMA_M;
use crate::sensing::torque_constant::TorqueConstant;
use crate::sensing::{Calibration, Directive, Drivetrain, Event, Friction, Object, Settings};
use core::marker::PhantomData;
use heapless::Deque;

/// Amplitude of an error of the worm's angle that nobody states, radian: a poor wheel's (R, docs/SENSING.md#transmission-error).
const UNSTATED_RAD: f32 = 1.5e-3;

/// See the module documentation.
// Fields in this order because a load with an immediate offset reaches only the first bytes: what every block needs comes
// first, tables last.
#[derive(Clone, Debug)]
#[repr(C)]
pub(super) struct SensorState<F: Mechanics, H: JointSensor, X: SeriesElement> {
    pub(super) finger: F,
    pub(super) drivetrain: Drivetrain,
    pub(super) settings: Settings,
    pub(super) calibration: Calibration,
    pub(super) directive: Directive,
    /// Whether this closing has already reported that the friction record no longer fits.
    pub(super) stale_told: bool,
    /// The free finger's posture at the last block: start value of the next solution.
    pub(super) posture: F::Configuration,
    pub(super) reading: H::Reading,
    /// The same at the end of the last block.
    pub(super) before: H::Reading,
    /// Encoder position of the last sample.
    pub(super) position_counts: i32,
    /// Change of theta_2 since the curve's origin, at the last verdict.
    pub(super) joint_change: H::Reading,
    /// See [`Sensor::object`](super::Sensor::object).
    pub(super) object: Option<Object>,
    /// Measured angle of the input link at which the contact that was located last began, by the fit, radian.
    pub(super) onset_rad: f32,
    pub(super) events: Deque<Event, 4>,
    pub(super) friction: Option<Friction>,
    /// Add this to an encoder position to get the record's, counts; `None` while a record from before a restart is not aligned.
    pub(super) shift_counts: Option<i32>,
    /// Its standard deviation, counts.
    pub(super) shift_sigma_counts: f32,
    /// Angle of the input link at the last block of a closing, radian, and the residual torque there, newton metre.
    pub(super) last_residual: Option<(f32, f32)>,
    /// What steady motion has told of the torque constant.
    pub(super) torque_constant: TorqueConstant,
    series: PhantomData<X>,
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    pub(super) fn new(
        finger: F,
        drivetrain: Drivetrain,
        settings: Settings,
        calibration: Calibration,
    ) -> Self {
        let posture = finger.rest();
        let mut state = Self {
            finger,
            drivetrain,
            settings,
            calibration,
            directive: Directive::Rest,
            friction: None,
            shift_counts: Some(0),
            shift_sigma_counts: 0.0,
            last_residual: None,
            stale_told: false,
            posture,
            reading: H::Reading::default(),
            before: H::Reading::default(),
            position_counts: 0,
            joint_change: H::Reading::default(),
            object: None,
            onset_rad: 0.0,
            torque_constant: TorqueConstant::default(),
            events: Deque::new(),
            series: PhantomData,
        };
        state.hang();
        state
    }

    /// Whether the finger is driven against the closing stop, to calibrate the cable.
    pub(super) fn presses_stop(&self) -> bool {
        matches!(self.directive, Directive::CalibrateCable)
    }

    pub(super) fn travel_counts(&self) -> i32 {
        // The cast saturates if a setting is absurd.
        (self.settings.travel_rad / self.drivetrain.rad_per_count) as i32
    }

    pub(super) fn emit(&mut self, event: Event) {
        // At most four are queued: a touch, a location, staleness and a calibration. A fifth would repeat one of them.
        let _ = self.events.push_back(event);
    }

    /// Posture and torque of the free finger at a measured angle.
    pub(super) fn free(&self, measured_rad: f32) -> Option<Free<F::Configuration>> {
        locator::free_behind_cable::<F, X>(
            &self.finger,
            measured_rad,
            &self.calibration,
            &self.posture,
        )
    }

    /// What the locator assumes of a contact before it fits the curve.
    pub(super) fn prior(&self, collector: &CurveCollector<H>) -> Prior<X> {
        let settings = &self.settings;
        let [joint_nm, joint_sigma_nm] = settings.joint_friction_nm;
        let [held_nm, held_sigma_nm] = weight::held(collector.stop_nm, settings.preload_nm);
        let place = match self.directive {
            Directive::Calibrate { phalanx, k_m } => Place::Known {
                phalanx,
                k_m,
                sigma_m: PIN_SIGMA_M,
                radius_m: settings.pin_contact_radius_m(),
            },
            Directive::CalibrateCable => Place::Stop,
            _ => Place::Anywhere,
        };
        let mut calibration = self.calibration;
        let mut noise = collector.noise;
        if let Place::Anywhere = place {
            calibration.correct_constant(&collector.constant);
        } else if noise.worm_error_rad <= 0.0 && self.drivetrain.counts_per_worm_turn > 0 {
            // An error at a pin biases every place located after it: assume a poor wheel where nobody states the error.
            noise.worm_error_rad = UNSTATED_RAD;
        }
        #[cfg(not(weightless))]
        if let Some(told) = collector.closing_factor
            && !matches!(place, Place::Stop)
        {
            calibration.correct_factor(told);
        }
        let weight_held_nm = (collector.stop_nm - settings.preload_nm[0]).at_least(0.0);
        let joint_nm = calibration.joint([
            // The path has what a design preloads, and what a weight presses joint 2 on its stop with.
            joint_nm + held_nm - self.finger.preload_nm() - weight_held_nm,
            sqrt(joint_sigma_nm * joint_sigma_nm + held_sigma_nm * held_sigma_nm),
        ]);
        let leverage_sigma = match place {
            Place::Anywhere if F::UNEVEN && calibration.contacts > 0 => {
                F::PINS_LEAVE * settings.leverage_sigma
            }
            Place::Anywhere if F::UNEVEN => settings.leverage_sigma,
            _ => 0.0,
        };
        if F::UNEVEN {
            calibration.widen(leverage_sigma);
        }
        Prior {
            place,
            half_thickness_m: settings.half_thickness_m,
            friction: settings.contact_friction,
            joint_nm,
            preload_nm: settings.preload_nm[0],
            give_m_per_n: settings.object_give_m_per_n,
            force_scale: settings.force_scale,
            weight: collector.weight,
            held_nm: weight_held_nm,
            onset_rad: collector.onset_rad,
            calibration,
            leverage_sigma,
            noise,
            series: PhantomData,
        }
    }

    /// The curve in the form that the locator needs.
    pub(super) fn data<'a>(&'a self, curve: &Curve, points: &'a [Point]) -> Data<'a> {
        Data {
            points,
            origin_rad: self.drivetrain.closing_rad(curve.origin_counts()),
            drivetrain: &self.drivetrain,
        }
    }
}
