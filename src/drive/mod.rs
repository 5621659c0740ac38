//! Motor and drivetrain: codes and units, current loop, motion sequence, protection.

mod average;
pub mod config;
pub mod controller;
pub mod convert;
mod current;
pub mod demand;
mod encoder;
pub mod fault;
pub mod identify;
pub mod io;
mod limit;
pub mod offset;
mod protect;
pub mod sequence;
mod sign;
mod speed;
#[cfg(test)]
pub(crate) mod test_motor;
pub mod thermal;

pub use controller::Controller;
pub use demand::{Demand, LimitsReached, OffsetState, Setpoint, Status};
pub use fault::Fault;
