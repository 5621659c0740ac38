//! From samples to events: friction, stiffness, contact, location, force, uncertainty.
//!
//! Passive: the same samples give the same events, live or replayed, whatever made the finger move.

pub mod event;

pub use crate::sample::{self, Drive, Sample};
pub use event::{Event, NotLocated};
