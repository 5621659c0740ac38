//! The contact path and the estimator of one step: every number that comes out is finite, every place on its phalanx.

use super::{Numbers, Task, posture};
use palpate::finger::{Contact, Mechanics};
use palpate::sensing::Side;
use palpate::sensing::location::Cable;
use palpate::sensing::step::{Measured, places};

/// The target.
pub struct FiniteStep;

impl Task for FiniteStep {
    fn on<M: Mechanics>(&mut self, finger: &M, numbers: &mut Numbers<'_>) {
        let (at, torque) = posture(finger, numbers);
        let phalanx = numbers.byte() % 5;
        let length = finger.phalanx_length_m(phalanx).unwrap_or(1.0);
        let contact = Contact {
            phalanx,
            k_m: length * numbers.plain(),
            radius_m: numbers.plain() * length,
        };
        let mut measured = Measured {
            rise_nm: numbers.any(),
            rotation_rad: numbers.any(),
            radius_m: contact.radius_m,
        };
        if let Some(mut path) = finger.path(&at, torque, contact) {
            for rise in [numbers.any(), numbers.plain(), measured.rise_nm] {
                let Some(p) = finger.follow(&mut path, rise) else {
                    continue;
                };
                let all = [
                    p.rotation_rad,
                    p.compliance_rad_per_nm,
                    p.k_now_m,
                    p.force_n,
                ];
                assert!(
                    all.iter().chain(&p.joints_rad).all(|x| x.is_finite()),
                    "{p:?}"
                );
                assert!(p.k_now_m > 0.0 && p.k_now_m <= length, "{p:?}");
                measured.rotation_rad = p.rotation_rad;
            }
        }
        let Ok(cable) = Cable::new(numbers.plain() * 100.0 + 0.1) else {
            return;
        };
        let side = Some(Side::of(numbers.any(), numbers.any()));
        for c in places(finger, &at, torque, &measured, &cable, side) {
            let length = finger
                .phalanx_length_m(c.phalanx)
                .expect("a phalanx that the finger has");
            assert!(c.k_m > 0.0 && c.k_m <= length, "{c:?}");
        }
    }
}
