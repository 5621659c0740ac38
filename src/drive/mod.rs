//! Motor and drivetrain: codes and units, current loop, motion sequence, protection.

pub mod config;
pub mod controller;
pub mod convert;
pub mod demand;
pub mod fault;
pub mod io;
pub mod sequence;

pub use controller::Controller;
pub use demand::{Demand, Limited, Offset, Setpoint, Status};
pub use fault::Fault;
