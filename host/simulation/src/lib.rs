//! The fast simulation: the library's controller, sequence and sensing against the plant, without the chip between them.
//!
//! [`run`] takes a [`Scenario`] from power-on to an [`Outcome`]; a [`Simulation`] goes on from grasp to grasp. Deterministic: the
//! same parameters and seed give the same events. Simulated: nothing here ran on a real finger.

pub mod between;
mod board;
pub mod changes;
pub mod disturbance;
pub mod joint_sensor;
mod machine;
mod outcome;
pub mod places;
pub mod second_contacts;
mod simulation;
mod slow;
pub mod soft_objects;
mod trace;

pub use board::{Board, PERIOD_S};
pub use machine::{Machine, SampleOf, SlowLoop};
pub use outcome::{Outcome, Verdict};
pub use simulation::{Error, Scenario, Simulated, Simulation, run};
pub use slow::Slow;
pub use trace::{HEADER, Row};
