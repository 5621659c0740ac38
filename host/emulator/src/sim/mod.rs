// SPDX-License-Identifier: GPL-2.0-only
//! Simulated grasps: what is in the finger's way, what the firmware is told to do, and what it says about it.

mod calibration;
mod fault;
mod grasp;
mod script;
mod session;
mod summary;
mod trace;

pub use calibration::{Calibration, Found};
pub use fault::{CONTROL_INSTRUCTIONS, FAULTS, Fault, Injected, Judgement, judge};
pub use grasp::Object;
pub use script::{Script, Step};
pub use session::{Session, Settings, end_of};
pub use summary::{Summary, Verdict, event_json};
pub use trace::Trace;
