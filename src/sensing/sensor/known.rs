//! What every stage works with: the finger, what is known of its drivetrain, and the events to report.

use crate::finger::{Free, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::sensing::location::Series;
use crate::sensing::locator;
use crate::sensing::{Calibration, Directive, Drivetrain, Event, Friction, Settings};
use core::marker::PhantomData;
use heapless::Deque;

/// See the module documentation.
// In this order: what every block needs lies within the reach of an instruction, the tables come last.
#[derive(Clone, Debug)]
#[repr(C)]
pub(super) struct Known<F: Mechanics, H: JointSensor, X: Series> {
    pub(super) finger: F,
    pub(super) drivetrain: Drivetrain,
    pub(super) settings: Settings,
    pub(super) calibration: Calibration,
    pub(super) directive: Directive,
    /// That the friction record no longer fits has been said.
    pub(super) stale_told: bool,
    /// The free finger's posture at the last block, where the next search for one starts.
    pub(super) posture: F::Configuration,
    pub(super) reading: H::Reading,
    /// Encoder position of the last sample.
    pub(super) position_counts: i32,
    /// Change of theta_2 since contact, as the last verdict took it into account.
    pub(super) joint_change: H::Reading,
    pub(super) events: Deque<Event, 4>,
    pub(super) friction: Option<Friction>,
    /// What makes a position one of the record's, counts; `None` while a record of before a restart is not aligned.
    pub(super) shift_counts: Option<i32>,
    /// Standard deviation of it.
    pub(super) shift_sigma_counts: f32,
    /// Angle of the input link at the last block of a closing, radian, and what the record leaves of its torque, newton metre.
    pub(super) last_residual: Option<(f32, f32)>,
    series: PhantomData<X>,
}

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    pub(super) fn new(
        finger: F,
        drivetrain: Drivetrain,
        settings: Settings,
        calibration: Calibration,
    ) -> Self {
        let posture = finger.rest();
        Self {
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
            position_counts: 0,
            joint_change: H::Reading::default(),
            events: Deque::new(),
            series: PhantomData,
        }
    }

    /// Whether the finger is driven against the closing stop, to calibrate the cable.
    pub(super) fn presses_stop(&self) -> bool {
        matches!(self.directive, Directive::CalibrateCable)
    }

    pub(super) fn travel_counts(&self) -> i32 {
        // Saturates where nonsense was set.
        (self.settings.travel_rad / self.drivetrain.rad_per_count) as i32
    }

    pub(super) fn tell(&mut self, event: Event) {
        // Four wait at most: a touch, a location, staleness and a calibration. A fifth would repeat one of them.
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
}
