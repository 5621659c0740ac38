//! The slow loop: sensing and motion sequence put together, shared by the firmware and the host simulations.

pub mod command;
pub mod conduct;
pub mod decimal;
pub mod hint;
pub mod input;
pub mod kept;
pub mod line;
pub mod record;
pub mod sense;
pub mod settings;
pub mod store;

pub use conduct::Conduct;
pub use sense::Sense;
