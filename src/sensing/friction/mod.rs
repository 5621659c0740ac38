//! Friction of the unloaded drivetrain over the angle of the input link, how well it repeats, and how it wanders.
//!
//! All torques here are motor torques seen from the input link as if nothing were lost: what the motor spends on a free
//! motion, the springs of the finger included where it has one at joint 1.
//!
//! A free motion fills a [`Pass`]; an [`Assessment`] learns from it what the wander is like ([`Evidence`]) and improves the
//! record ([`Friction`]).

mod alignment;
mod assessment;
mod bins;
mod harmonics;
mod pass;
mod record;
mod wander;

pub use alignment::{Aligned, Alignment};
pub use assessment::{Assessment, LEAST_BINS};
pub use bins::{BINS, Bins};
pub use harmonics::HARMONICS;
pub use pass::Pass;
pub use record::{Estimate, Friction};
pub use wander::{Evidence, Hypothesis, RATES, TIMES, Wander};
