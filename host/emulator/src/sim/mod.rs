// SPDX-License-Identifier: GPL-2.0-only
//! Simulated grasps: the object, the commands to the firmware, and its log.

mod calibration;
pub mod campaign;
mod fault;
mod grasp;
mod in_force;
mod judge;
mod script;
mod session;
mod summary;
mod trace;

pub use calibration::{Calibration, Found};
pub use fault::{FAULTS, Fault, Injected};
pub use grasp::Object;
pub use judge::{CONTROL_INSTRUCTIONS, Judgement, judge};
pub use script::{Script, Step};
pub use session::{Session, Settings, end_of};
pub use summary::{Stiffness, Summary, Told, event_json};
pub use trace::Trace;
