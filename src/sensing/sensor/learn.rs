//! Calibration: what a contact at a known place or a press on the closing stop teaches.

use super::UNSURE_BEYOND;
use super::known::Known;
use super::touch::Touching;
use crate::finger::Mechanics;
use crate::numeric::sqrt;
use crate::sensing::curve;
use crate::sensing::fit::LEAST_POINTS;
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;
use crate::sensing::{Calibration, Directive, Event, Refusal};

/// Systematic error of the cable's twist that a press does not show (how much it creeps), as a share.
const PRESS_SHARE: f32 = 0.005;
/// How much the closing stop may yield, radian per newton metre (R, chosen): it counts as cable.
const STOP_YIELD_RAD_PER_NM: f32 = 4e-3;

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    pub(super) fn learn_from_contact(
        &self,
        touching: &Touching<H::Reading>,
    ) -> Result<Calibration, Refusal> {
        let Directive::Calibrate { phalanx, k_m } = self.directive else {
            return Err(Refusal::NoSuchPlace);
        };
        let length = self
            .finger
            .phalanx_length_m(phalanx)
            .ok_or(Refusal::NoSuchPlace)?;
        if !(phalanx > 1 && k_m > 0.0 && k_m <= length) {
            return Err(Refusal::NoSuchPlace);
        }
        let hypothesis = touching
            .locator
            .hypotheses()
            .first()
            .ok_or(Refusal::TooFewSamples)?;
        let estimate = hypothesis.estimate().ok_or(Refusal::Misfit)?;
        if estimate.reached < LEAST_POINTS {
            return Err(Refusal::TooFewSamples);
        }
        let misfit = estimate.misfit();
        let found = hypothesis
            .learned(&self.prior(touching))
            .ok_or(Refusal::Misfit)?;
        self.calibration.with_contact(&found, misfit)
    }

    // A symbol of its own: its absence shows that a scene without a cable does not carry this.
    #[inline(never)]
    pub(super) fn learn_from_press(
        &self,
        touching: &Touching<H::Reading>,
    ) -> Result<Calibration, Refusal> {
        let top_nm = touching
            .touch
            .curve
            .last()
            .ok_or(Refusal::TooFewSamples)?
            .torque_nm;
        // The foot of the curve is where gears and cable settle.
        let slope = curve::slope(
            touching.touch.curve.bins(),
            0.2 * top_nm,
            self.drivetrain.creep[0],
        )
        .filter(|slope| slope.points >= LEAST_POINTS as u16)
        .ok_or(Refusal::TooFewSamples)?;
        let rad_per_nm = slope.counts_per_nm * self.drivetrain.rad_per_count;
        // Friction beyond the record, where the stop is, is continued; its error may tilt the line.
        let unevenness_nm =
            UNSURE_BEYOND * self.drivetrain.efficiency * touching.touch.unevenness_nm;
        let share = unevenness_nm / top_nm;
        let noise = slope.sigma_counts_per_nm * self.drivetrain.rad_per_count;
        let sigma = sqrt(
            noise * noise
                + rad_per_nm * rad_per_nm * (share * share + PRESS_SHARE * PRESS_SHARE)
                + STOP_YIELD_RAD_PER_NM * STOP_YIELD_RAD_PER_NM,
        );
        self.calibration.with_press(rad_per_nm, sigma)
    }

    pub(super) fn tell_calibration(&mut self, learned: Result<Calibration, Refusal>) {
        match learned {
            Ok(calibration) => {
                self.calibration = calibration;
                self.tell(Event::Calibrated { calibration });
            }
            Err(why) => self.tell(Event::CalibrationRefused { why }),
        }
    }
}
