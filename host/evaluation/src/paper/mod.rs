//! The paper's own algorithm (its section VI, Fig 8, and VII) at its best, to compare with ours on the same samples.
//!
//! A constant friction threshold from a free closing, a secant of the stiffness between two torques, the cable's stiffness
//! taken off, and the tangent model (18) turned round. In f64, with the independent mechanics of [`crate::reference`]:
//! nothing here comes from the library but the samples' type.
//!
//! The text leaves open K_2, the step of torque, how the torque was smoothed, how far above friction the threshold lay and
//! what was done when several places fit. Chosen here, in its favour: means over whole turns of the motor, which average
//! the commutator's ripple out; only turns at the steady speed of closing and probing, so that neither the start nor the
//! hold enters; a threshold a tenth above the largest torque of the free closing; the solution nearest to the base; a place
//! nearer to a joint than the paper's mean error counts as a contact of the phalanx before it. With a spring at the base, the
//! torque that the free finger takes at each angle (6) is taken off before the threshold (the comparison with K_a' in Fig 8).
//! Experiments try every step of [`STEPS_NM`] on all contacts and report the one with the least mean error, in hindsight.
//!
//! A finger whose joint 2 is held at its stop by a return cable or a preload has no K_c at contact. The authors' earlier work, on fingers
//! with return cables, takes the torque with which motion resumes; that is done here, again at its best: friction from the turns just
//! before the contact.
//!
//! | module | what it does |
//! |---|---|
//! | `turns` | means over turns of the motor |
//! | `secant` | threshold, two torques, their secant |
//! | `place` | the place that makes the finger that stiff |
//! | `break_away` | the place that keeps motion from resuming so long |

mod break_away;
mod place;
mod secant;
mod turns;

pub use break_away::Stopped;
pub use secant::{Rule, STEPS_NM, friction_threshold, locate};

use nalgebra::DVector;

use crate::reference::{Finger, free_posture};

/// Points of the table of the free finger's torque.
const FREE_POINTS: u32 = 60;

/// What the algorithm takes for granted.
#[derive(Clone, Debug)]
pub struct Model {
    /// The finger.
    pub finger: Finger,
    /// Phalanx 1 lies within the palm and touches nothing.
    pub hidden_base: bool,
    /// Torque at the input link for a motor current, newton metre per ampere.
    pub torque_nm_per_a: f64,
    /// Encoder counts in a radian of the input link.
    pub counts_per_rad: f64,
    /// Encoder counts in a turn of the motor.
    pub counts_per_turn: f64,
    /// Compliance of the cable, radian per newton metre.
    pub cable_rad_per_nm: f64,
    /// What holds joint 2 at its stop.
    pub stopped: Option<Stopped>,
    /// Angle of the input link from rest and torque of the free finger there, rising; empty without a spring at the base.
    pub free: Vec<(f64, f64)>,
}

impl Model {
    /// Torque of the free finger at an angle of the input link from rest, newton metre (6).
    fn free_torque(&self, angle_rad: f64) -> f64 {
        let after = self.free.partition_point(|(angle, _)| *angle < angle_rad);
        let (Some(b), Some(a)) = (
            self.free.get(after.clamp(1, self.free.len().max(2) - 1)),
            self.free
                .get(after.clamp(1, self.free.len().max(2) - 1) - 1),
        ) else {
            return 0.0;
        };
        (a.1 + (b.1 - a.1) * (angle_rad - a.0) / (b.0 - a.0)).max(0.0)
    }
}

/// The table for [`Model::free`], up to an angle of the input link.
#[must_use]
pub fn free_table(finger: &Finger, travel_rad: f64) -> Vec<(f64, f64)> {
    if finger.springs[0] == 0.0 {
        return Vec::new();
    }
    let rest = finger.theta_a(&DVector::from_vec(finger.rest_rad.clone()));
    // No finger is stiffer while free than its stiffest spring is on its own.
    let stiffest = finger.springs.iter().copied().fold(0.0, f64::max);
    let mut table = Vec::new();
    for point in 0..=FREE_POINTS {
        let torque = stiffest * travel_rad * f64::from(point) / f64::from(FREE_POINTS);
        let Some(posture) = free_posture(finger, torque) else {
            break;
        };
        let angle = finger.theta_a(&posture) - rest;
        table.push((angle, torque));
        if angle > travel_rad {
            break;
        }
    }
    table
}

/// What the algorithm says of one closing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PaperResult {
    /// The torque stayed below the threshold.
    NoContact,
    /// A contact, but the torque did not rise far enough to measure a stiffness.
    Touched {
        /// When, microseconds.
        time_us: u64,
    },
    /// A contact on the proximal phalanx.
    Proximal {
        /// When, microseconds.
        time_us: u64,
    },
    /// A located contact.
    Located {
        /// When, microseconds.
        time_us: u64,
        /// Phalanx, 2 or 3.
        phalanx: u8,
        /// Place from the phalanx's joint, in the finger's unit of length.
        k: f64,
    },
}

impl PaperResult {
    /// When the contact was decided.
    #[must_use]
    pub fn touched_us(&self) -> Option<u64> {
        match *self {
            Self::NoContact => None,
            Self::Touched { time_us }
            | Self::Proximal { time_us }
            | Self::Located { time_us, .. } => Some(time_us),
        }
    }
}

#[cfg(test)]
mod tests;
