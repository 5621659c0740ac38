//! The slow loop: sensing and motion sequence put together, shared by the firmware and the host simulations.

pub mod command;
pub mod decimal;
pub mod record;
pub mod settings;
