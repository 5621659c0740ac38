//! From samples to events: friction, stiffness, contact, location, force, uncertainty.
//!
//! Passive: the same samples give the same events, live or replayed, whatever made the finger move.

pub mod calibration;
pub mod drivetrain;
pub mod event;
pub mod settings;

pub use crate::sample::{self, Drive, Sample};
pub use calibration::{Calibration, Refusal};
pub use drivetrain::Drivetrain;
pub use event::{Event, NotLocated};
pub use settings::{Directive, Settings};
