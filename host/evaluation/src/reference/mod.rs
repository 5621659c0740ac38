//! An independent f64 evaluation of the mechanics, from positions and potential energy alone.
//!
//! The library works with closed forms in f32. What it is compared with here knows only where the links are, what
//! energy the springs hold, and numerical differentiation (docs/MECHANICS.md#conventions and
//! docs/MECHANICS.md#transmission); no equation of the paper after (4) is used.

mod finger;
mod held;
mod held_twice;
mod measured;
mod opened;
mod posterior;
mod rolling;
mod stiffness;
#[cfg(test)]
mod support;

pub use finger::{Finger, Stage};
pub use held::{Held, Press};
pub use held_twice::{HeldTwice, Rubs, Stand, Touching};
pub use measured::{BESIDE, Curve, Noise, Place, Priors, Sample, predicted};
pub use opened::{Drive, Opened, ReturnCable, State, Weight};
pub use posterior::{OFFSET_M, Posterior};
pub use rolling::{Rolled, Rolling, Touch};
pub use stiffness::{ClosurePoint, contact_curve, free_posture, tangent_compliance};

/// The paper's Table I: three phalanges, tendon. Lengths in units of the proximal phalanx, torque in units of K.
#[must_use]
pub fn table_1() -> Finger {
    Finger {
        lengths: vec![1.0, 0.75, 0.5],
        springs: vec![1.0; 3],
        rest_rad: vec![std::f64::consts::FRAC_PI_6; 3],
        stages: vec![
            Stage::Tendon { ratio: 0.08 / 0.10 },
            Stage::Tendon { ratio: 0.04 / 0.06 },
        ],
    }
}

/// The two-phalanx tendon finger of the paper's Fig 5: the first two phalanges of Table I.
#[must_use]
pub fn table_1_two_phalanges() -> Finger {
    let mut finger = table_1();
    finger.lengths.truncate(2);
    finger.springs.truncate(2);
    finger.rest_rad.truncate(2);
    finger.stages.truncate(1);
    finger
}

/// The oversized finger of the paper's Fig 7: l_1 halved, l_2 three times and l_3 six times as long.
#[must_use]
pub fn oversized() -> Finger {
    let mut finger = table_1();
    finger.lengths = vec![0.5, 2.25, 3.0];
    finger
}

/// The prototype P70 (docs/MECHANICS.md#prototype), lengths in metre, with the given distal spring in newton metre per
/// radian.
#[must_use]
pub fn p70(spring_nm_per_rad: f64) -> Finger {
    Finger {
        lengths: vec![0.090, 0.070],
        springs: vec![0.0, spring_nm_per_rad],
        rest_rad: vec![std::f64::consts::FRAC_PI_4, 0.0],
        stages: vec![Stage::Linkage {
            drive: 0.060,
            coupler: 0.104,
            driven: 0.030,
            offset_rad: 120.0_f64.to_radians(),
            mode: -1.0,
        }],
    }
}
