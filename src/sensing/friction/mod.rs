//! Friction of the unloaded drivetrain over the angle of the input link, how well it repeats, and how it wanders.
//!
//! All torques here are motor torques at the input link without losses: what the motor needs for a free motion, including the
//! finger's springs if joint 1 has one.
//!
//! A free motion fills a [`Pass`]; an [`Assessment`] estimates the wander from it ([`Evidence`]) and improves the
//! record ([`Friction`]).

mod alignment;
mod assessment;
mod bins;
mod harmonics;
mod pass;
mod record;
mod regression;
mod wander;

pub use alignment::{Aligned, Alignment};
pub use assessment::{Assessment, LEAST_BINS};
pub use bins::{BINS, Bins};
pub use harmonics::HARMONICS;
pub use pass::Pass;
pub use record::{Estimate, Friction};
pub use wander::{Evidence, Hypothesis, RATES, TIMES, Wander};
