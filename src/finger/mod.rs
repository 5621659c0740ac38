//! Finger mechanics: geometry, springs, transmission; nothing of motors, time or noise.
//!
//! Equations in brackets are the source paper's; "MATH n" is a section of the derivation notes they were checked in.
//! Lengths and torques may be in any consistent set of units; the names say metre and newton metre.

mod error;
mod mechanics;

pub use error::{ConfigError, Parameter};
pub use mechanics::{
    Candidate, Class, Contact, Free, Inverse, MAX_PHALANGES, Mechanics, PathPoint,
};
