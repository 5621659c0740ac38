//! The slow loop, once a millisecond: sensing and motion sequence, joined by a few requests and notices.

pub mod coordinator;
pub mod guide;
pub mod hold;
pub mod sensing;
pub mod values;

pub use coordinator::Coordinator;
pub use sensing::ContactSensing;
