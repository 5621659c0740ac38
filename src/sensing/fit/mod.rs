//! Where is the contact, and how round the object: the whole torque-angle curve against the finger's exact path
//! (docs/MECHANICS.md#finite-torque-step).
//!
//! For a hypothesis (a phalanx) eight numbers are fitted, each with a prior: the location k, the effective contact radius
//! R, an offset q of the torque (misfit of the friction record), the onset angle o, and what calibration has left open of
//! the torque factor f, the cable's twist c, the share g of it that creeps and the rotor's inertia j, which counts while a
//! stiff contact slows the motor down. With the nominal torque T of each point, corrected by j, the model is
//!
//! angle = o + rotation(f (T - q); k, R) + c (T - q - T_c / f + g L),
//!
//! L being the torque delayed by the creep's time constant, and rotation the contact path from the torque T_c of the free
//! finger at the onset. The residual is taken in angle, which stays bounded where the finger is rigid (e_2); its variance
//! is that of the torque times the slope squared. Everything unknown is a parameter with a prior, so the deviation of k
//! that comes out holds noise, friction misfit, radius and calibration together. A drivetrain without a cable
//! ([`Rigid`](crate::sensing::location::Rigid)) leaves six: c and g are not there.

mod estimate;
mod model;
mod onset;
mod prior;
mod refine;
mod rows;
mod unknowns;

pub use estimate::Estimate;
pub use model::Data;
pub use onset::free_behind_cable;
pub use prior::{Place, Prior};
pub use unknowns::UNKNOWNS;

use crate::sensing::location::Series;
use estimate::Best;
use unknowns::{K, LEAST_SHARE};

/// Fewest points that make a fit.
pub const LEAST_POINTS: usize = 5;

/// One explanation of the curve, refined step by step.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    phalanx: u8,
    length_m: f32,
    /// Unknowns, whitened by the prior (location: in phalanx lengths).
    x: [f32; UNKNOWNS],
    damping: f32,
    steps: u16,
    settled_steps: u8,
    best: Option<Best>,
}

impl Hypothesis {
    /// A contact on a phalanx, starting at a location. On phalanx 1 location and radius mean nothing and stay.
    pub fn new<X: Series>(phalanx: u8, k_m: f32, length_m: f32, prior: &Prior<X>) -> Self {
        let mut x = [0.0; UNKNOWNS];
        x[K] = match prior.place {
            Place::Anywhere => (k_m / length_m).clamp(LEAST_SHARE, 1.0),
            Place::Known { .. } => 0.0,
        };
        Self {
            phalanx,
            length_m,
            x,
            damping: 0.0,
            steps: 0,
            settled_steps: 0,
            best: None,
        }
    }

    /// The phalanx.
    pub fn phalanx(&self) -> u8 {
        self.phalanx
    }

    /// Result so far; None before the first step, or where no path fits the curve at all.
    pub fn estimate(&self) -> Option<&Estimate> {
        self.best.as_ref().map(|best| &best.estimate)
    }

    /// Where on its phalanx it stands, in lengths of that, when the place is to be found.
    pub fn stands_at(&self) -> f32 {
        self.x[K]
    }

    /// Steps made.
    pub fn steps(&self) -> u16 {
        self.steps
    }

    /// Whether the last steps changed nothing that matters.
    pub fn has_converged(&self) -> bool {
        self.settled_steps >= 2
    }

    /// New points have come.
    pub fn refresh(&mut self) {
        self.settled_steps = 0;
    }

    /// Whether it is that of a contact on the proximal phalanx, which has no place.
    pub fn is_proximal(&self) -> bool {
        self.phalanx <= 1
    }

    /// Nothing explains the curve from here.
    fn fail(&mut self) {
        self.best = None;
        self.settled_steps = self.settled_steps.saturating_add(1);
    }

    /// The path ends before the curve: try nearer to the middle of the phalanx.
    fn retreat<X: Series>(&mut self, prior: &Prior<X>) {
        self.fail();
        if matches!(prior.place, Place::Anywhere) {
            self.x[K] += 0.25 * (0.5 - self.x[K]);
        }
    }
}
