//! Free motion, recorded: what becomes of it in the end.

use super::known::Known;
use crate::finger::Mechanics;
use crate::sensing::Event;
use crate::sensing::friction::Recorder;
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;

/// Share of the record's bins that a recording must fill.
const COVERAGE: f32 = 0.6;

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    /// Keeps what was recorded, if that is enough, and says so or not.
    pub(super) fn end_recording(&mut self, recorder: &mut Recorder) {
        recorder.end_run();
        let coverage = recorder.coverage();
        if coverage >= COVERAGE
            && let Some(friction) = recorder.finish()
            && let Some(closing_nm) = friction.closing.mean_nm()
            && let Some(opening_nm) = friction.opening.mean_nm()
        {
            self.friction = Some(friction.clone());
            self.shift_counts = Some(0);
            self.tell(Event::FrictionRecorded {
                closing_nm,
                opening_nm,
                residual_nm: friction.residual_nm(),
                coverage,
            });
        } else {
            self.tell(Event::FrictionNotRecorded { coverage });
        }
    }
}
