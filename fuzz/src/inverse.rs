//! The inverse: whatever the finger, posture and compliance, candidates lie on their phalanx and press, and what is asked
//! forward at a candidate is finite.

use super::{Numbers, Task, posture};
use palpate::finger::{Contact, Mechanics};

/// The target.
pub struct Inverse;

impl Task for Inverse {
    fn on<M: Mechanics>(&mut self, finger: &M, numbers: &mut Numbers<'_>) {
        let (at, torque) = posture(finger, numbers);
        assert!(finger.input_angle_rad(&at).is_finite());
        let phalanx = numbers.byte() % 5;
        let k_m = numbers.any();
        let forward = finger.contact_compliance(&at, torque, phalanx, k_m);
        assert!(forward.is_none_or(f32::is_finite));
        assert!(
            finger
                .stiffest_m(&at, torque, phalanx)
                .is_none_or(f32::is_finite)
        );
        let asked = if numbers.byte() & 1 == 0 {
            numbers.any()
        } else {
            forward.unwrap_or(0.0)
        };
        for answer in [
            finger.locate(&at, torque, asked),
            finger.locate_closed(&at, torque, asked),
        ] {
            for c in answer.candidates() {
                let length = finger
                    .phalanx_length_m(c.phalanx)
                    .expect("a phalanx that the finger has");
                assert!(c.k_m > 0.0 && c.k_m <= length, "{c:?}");
                let back = finger.contact_compliance(&at, torque, c.phalanx, c.k_m);
                assert!(
                    back.is_none_or(|c| c.is_finite() && c >= 0.0),
                    "{c:?} {back:?}"
                );
                let contact = Contact {
                    phalanx: c.phalanx,
                    k_m: c.k_m,
                    radius_m: 0.0,
                };
                // May be refused where rounding decides whether it presses; must not go wrong.
                let _ = finger.path(&at, torque, contact);
            }
        }
    }
}
