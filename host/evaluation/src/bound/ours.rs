//! What the library makes of the very curves that the exact posterior by sampling is given ([`super::sampled`]): the same angles, torques,
//! noise and knowledge. With pins it learns from their curves as the firmware does (src/sensing/sensor): one pin after the other, then a
//! contact with the doubt about the leverage that pins leave.

use std::marker::PhantomData;

use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate::sensing::curve::Point;
use palpate::sensing::locator::{
    Data, Estimate, Locator, LocatorResult, Noise, Place, Prior, free_behind_cable,
};
use palpate::sensing::settings::{ONSET_SIGMA_RAD, PIN_SIGMA_M};
use palpate::sensing::{Calibration, SeriesElement};

use super::drawn::NOISE;
use super::felt::{Felt, Pin};
use super::information::LEAD;
use super::known::{BEND, CABLE, Chosen, FRICTION, JOINT, K, Known, TURNS};

/// All rounds of the locator on a curve, as at the end of a closing.
pub(super) fn fitted<F: Mechanics, X: SeriesElement>(
    finger: &F,
    data: &Data,
    prior: &Prior<X>,
) -> Locator<F, X> {
    let near = finger.rest();
    let mut locator = Locator::default();
    while locator.begin(finger, data, prior, &near, true) {
        while !locator.step(finger, data, prior, &near, ()) {}
        let is_over = match prior.place {
            Place::Anywhere => locator.stands(data, false),
            _ => locator.teaches(data),
        };
        if is_over {
            break;
        }
    }
    locator
}

/// The library on a scene's finger.
pub(super) struct Ours<'a, S: Scene> {
    known: &'a Known,
    scene: PhantomData<S>,
}

impl<'a, S: Scene> Ours<'a, S> {
    pub(super) fn of(known: &'a Known) -> Self {
        Self {
            known,
            scene: PhantomData,
        }
    }

    /// What a press on the stop leaves of the data sheets' doubt.
    pub(super) fn pressed(&self) -> Calibration {
        let known = self.known;
        let deviations = known.deviations(known.lengths_m[0]);
        let told = known.pressed(&deviations, super::information::Pulleys::Off);
        let sigma = |unknown: usize| (deviations[unknown] * told[(unknown, unknown)].sqrt()) as f32;
        Calibration {
            cable_sigma_rad_per_nm: sigma(CABLE),
            stiffening_sigma_per_nm: sigma(BEND),
            correlation: 0.0,
            joint_nm: 0.0,
            joint_sigma_nm: 0.0,
            joint_correlation: 0.0,
            worm_rad: [0.0; 2],
            presses: 1,
            contacts: 0,
            ..known.sheet
        }
    }

    /// What is assumed of a contact (src/sensing/sensor/state.rs).
    fn prior(&self, felt: &Felt, place: Place, before: &Calibration) -> Prior<S::Series> {
        let (known, settings) = (self.known, &self.known.settings);
        let mut calibration = *before;
        let deviations = known.deviations(known.lengths_m[0]);
        let means = known.means(&Chosen::SOME);
        let joint_nm = calibration.joint([means[JOINT] as f32, deviations[JOINT] as f32]);
        let mut leverage_sigma = 0.0;
        if S::Finger::UNEVEN && matches!(place, Place::Anywhere) {
            let [without, with_pins] = known.leverage;
            leverage_sigma = (if before.contacts > 0 {
                with_pins
            } else {
                without
            }) as f32;
            calibration.widen(leverage_sigma);
        }
        Prior {
            place,
            half_thickness_m: settings.half_thickness_m,
            friction: [means[FRICTION] as f32, deviations[FRICTION] as f32],
            joint_nm,
            onset_rad: [felt.detected_rad as f32, ONSET_SIGMA_RAD],
            weight: [0.0; 2],
            held_nm: 0.0,
            preload_nm: settings.preload_nm[0],
            give_m_per_n: settings.object_give_m_per_n,
            force_scale: None,
            calibration,
            leverage_sigma,
            noise: Noise {
                speed_rad_per_s: settings.speed_rad_per_s,
                ..NOISE
            },
            series: PhantomData,
        }
    }

    /// Fits the curve of a contact or of a pin.
    fn fitted(
        &self,
        felt: &Felt,
        prior: &Prior<S::Series>,
    ) -> Option<Locator<S::Finger, S::Series>> {
        let finger = S::MECHANISM;
        let mut drivetrain = S::drivetrain(&finger);
        drivetrain.creep = 0.0;
        let near = finger.rest();
        let first_rad = *felt.observed.angles.first()?;
        let rad_per_count = f64::from(drivetrain.rad_per_count);
        let point = |(index, (&angle_rad, &excess_nm)): (usize, (&f64, &f64))| {
            let turns = TURNS * (index as f64 - LEAD as f64);
            let sample = self.known.sample(angle_rad, turns, excess_nm);
            let free = free_behind_cable::<S::Finger, S::Series>(
                &finger,
                angle_rad as f32,
                &prior.calibration,
                &near,
            );
            Some(Point {
                counts: ((angle_rad - first_rad) / rad_per_count) as f32,
                time_s: sample.time_s as f32,
                excess_nm: excess_nm as f32,
                free_nm: free?.torque_nm,
                late_nm: 0.0,
                variance_nm2: sample.variance_nm2 as f32,
                width_counts: (sample.width_rad / rad_per_count) as f32,
                blocks: sample.blocks as u16,
            })
        };
        let measured = felt.observed.angles.iter().zip(&felt.measured);
        let points: Vec<Point> = measured.enumerate().map(point).collect::<Option<_>>()?;
        let data = Data {
            points: &points,
            origin_rad: first_rad as f32,
            drivetrain: &drivetrain,
        };
        Some(fitted(&finger, &data, prior))
    }

    /// A calibration with what pins have told beside; one that the firmware refuses tells nothing.
    pub(super) fn taught(&self, before: &Calibration, pins: &[Pin]) -> Calibration {
        let settings = &self.known.settings;
        let mut calibration = *before;
        for Pin { k_m, felt } in pins {
            let place = Place::Known {
                phalanx: felt.observed.phalanx as u8,
                k_m: *k_m as f32,
                sigma_m: PIN_SIGMA_M,
                radius_m: settings.pin_radius_m + settings.half_thickness_m,
            };
            let prior = self.prior(felt, place, &calibration);
            let learned = (self.fitted(felt, &prior)).and_then(|mut of| of.learned(&prior));
            let taken = learned
                .map(|told| calibration.with_contact(&told.calibration, told.misfit, told.strain));
            if let Some(Ok(taken)) = taken {
                calibration = taken;
            }
        }
        calibration
    }

    /// Error and deviation of the place, as shares of the phalanx; none where nothing is told or another phalanx.
    pub(super) fn located(&self, felt: &Felt, calibration: &Calibration) -> Option<[f64; 2]> {
        let prior = self.prior(felt, Place::Anywhere, calibration);
        let observed = &felt.observed;
        let length_m = self.known.lengths_m[observed.phalanx - 1];
        let told = |estimate: &Estimate| {
            (usize::from(estimate.phalanx) == observed.phalanx).then(|| {
                let off_m = f64::from(estimate.k_m) - observed.values[K];
                [off_m, f64::from(estimate.k_sigma_m)].map(|m| m / length_m)
            })
        };
        match self.fitted(felt, &prior)?.verdict(&prior) {
            LocatorResult::At(estimate) => told(&estimate),
            LocatorResult::Either([one, other]) => told(&one).or_else(|| told(&other)),
            LocatorResult::Undecided | LocatorResult::Nowhere(_) => None,
        }
    }
}
