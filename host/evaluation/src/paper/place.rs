//! The tangent model (18) turned round: from a compliance to a place.

use nalgebra::DVector;

use super::{Model, PaperResult};
use crate::reference::{Finger, free_posture, tangent_compliance};

/// The paper's mean error as a share of the phalanx: nearer to the joint it cannot tell the phalanges apart.
pub(super) const JOINT_SHARE: f64 = 0.073;
/// Places tried on a phalanx before the root is refined.
const SCAN: u32 = 140;

/// Which place makes the finger that compliant (18)?
pub(super) fn invert(model: &Model, torque: f64, compliance: f64, time_us: u64) -> PaperResult {
    let finger = &model.finger;
    let posture = free_posture(
        finger,
        if finger.springs[0] == 0.0 {
            0.0
        } else {
            torque
        },
    )
    .unwrap_or_else(|| DVector::from_vec(finger.rest_rad.clone()));
    let torque = if finger.springs[0] == 0.0 {
        0.0
    } else {
        torque
    };
    for phalanx in 2..=finger.phalanges() {
        let length = finger.lengths[phalanx - 1];
        let excess = |k: f64| {
            tangent_compliance(finger, &posture, torque, phalanx, k).map(|value| value - compliance)
        };
        let Some(k) = first_root(length, excess) else {
            continue;
        };
        let first = phalanx == 2 && model.hidden_base;
        if k < JOINT_SHARE * length && !first {
            return on_phalanx_before(finger, phalanx, time_us);
        }
        return PaperResult::Located {
            time_us,
            phalanx: phalanx as u8,
            k,
        };
    }
    // No place is that stiff or that soft: beyond the tip it saturates, otherwise it is the proximal phalanx.
    let last = finger.phalanges();
    let tip = tangent_compliance(finger, &posture, torque, last, finger.lengths[last - 1]);
    if tip.is_some_and(|tip| compliance < tip) {
        return PaperResult::Located {
            time_us,
            phalanx: last as u8,
            k: finger.lengths[last - 1],
        };
    }
    if model.hidden_base {
        // Softer than a contact anywhere: at the first joint that can touch.
        return PaperResult::Located {
            time_us,
            phalanx: 2,
            k: 0.0,
        };
    }
    PaperResult::Proximal { time_us }
}

fn on_phalanx_before(finger: &Finger, phalanx: usize, time_us: u64) -> PaperResult {
    if phalanx == 2 {
        return PaperResult::Proximal { time_us };
    }
    PaperResult::Located {
        time_us,
        phalanx: (phalanx - 1) as u8,
        k: finger.lengths[phalanx - 2],
    }
}

/// The root nearest to the joint within the phalanx.
fn first_root(length: f64, excess: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let at = |step: u32| length * (f64::from(step) + 1e-3) / f64::from(SCAN);
    let mut last = (at(0), excess(at(0))?);
    for step in 1..=SCAN {
        let k = at(step).min(length);
        let Some(value) = excess(k) else { continue };
        if value.signum() != last.1.signum() {
            let (mut low, mut high) = (last.0, k);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if excess(middle)?.signum() == last.1.signum() {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            return Some(0.5 * (low + high));
        }
        last = (k, value);
    }
    None
}
