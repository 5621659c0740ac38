//! The motion is over: the fits to their minimum, then the last word.

use super::touch::Touching;
use super::{Sensor, Work};
use crate::finger::Mechanics;
use crate::sensing::Directive;
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;

/// Steps that each hypothesis gets when the motion is over.
const LAST_STEPS: u8 = 40;
/// Samples between two of them: a step takes several milliseconds on the target, and samples must not pile up meanwhile.
const SAMPLES_PER_LAST_STEP: u8 = 12;

impl<R> Touching<R> {
    /// No more is to come; the last word is due.
    pub(super) fn end(&mut self) {
        if self.last_steps.is_none() {
            self.locator.refresh();
            self.last_steps = Some(LAST_STEPS);
        }
    }
}

impl<F: Mechanics, H: JointSensor, X: Series> Sensor<F, H, X> {
    /// After the motion: the fits to their minimum, then the last word.
    pub(super) fn conclude(&mut self) {
        let known = &mut self.known;
        let Work::Contact(touching) = &mut self.work else {
            return;
        };
        let Some(steps) = touching.last_steps else {
            return;
        };
        let fits = !known.presses_stop() && !touching.settled;
        let converged = steps < LAST_STEPS && touching.locator.has_converged();
        if fits && steps > 0 && !converged {
            if touching.pause > 0 {
                touching.pause -= 1;
                return;
            }
            touching.pause = SAMPLES_PER_LAST_STEP - 1;
            touching.last_steps = Some(steps - 1);
            known.refine(touching);
            return;
        }
        self.done = true;
        match known.directive {
            Directive::CalibrateCable if X::FLEXIBLE => {
                let learned = known.learn_from_press(touching);
                known.tell_calibration(learned);
            }
            Directive::Calibrate { .. } => {
                let learned = known.learn_from_contact(touching);
                known.tell_calibration(learned);
            }
            _ if touching.settled => {}
            _ => known.report(touching, true),
        }
        self.work = Work::Nothing;
    }
}
