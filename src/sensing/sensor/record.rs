//! Free motion, recorded: what becomes of it in the end.

use super::Sensor;
use crate::finger::Mechanics;
use crate::sensing::Event;
use crate::sensing::friction::Recorder;
use crate::sensing::joint::JointSensor;

/// Share of the record's bins that a recording must fill.
const COVERAGE: f32 = 0.6;

impl<F: Mechanics, H: JointSensor> Sensor<F, H> {
    pub(super) fn end_recording(&mut self, recorder: &mut Recorder) {
        let recorded = recorder.finish();
        let coverage = recorder.coverage();
        let told = recorded.as_ref().and_then(|friction| {
            Some(Event::FrictionRecorded {
                closing_nm: friction.closing.mean_nm()?,
                opening_nm: friction.opening.mean_nm()?,
                residual_nm: friction.residual_nm(),
                coverage,
            })
        });
        match (recorded, told) {
            (Some(friction), Some(event)) if coverage >= COVERAGE => {
                self.friction = Some(friction);
                self.tell(event);
            }
            _ => self.tell(Event::FrictionNotRecorded { coverage }),
        }
    }
}
