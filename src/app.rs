//! The application between library and chip, shared by the firmware and the host simulations: commands in, motion sequence
//! and sensing put together, what is kept over a power cut, and what the log says.

pub mod console;
pub mod grasp;
pub mod identify;
pub mod log;
pub mod selftest;
pub mod storage;
