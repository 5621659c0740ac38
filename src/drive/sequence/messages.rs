//! Requests and notices to the sequence, and its answers.

use super::state::State;
use crate::drive::fault::Fault;
use crate::name_list::nth;

/// What the user asks of the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Everything: offset, home, friction if there is no record, close, probe, hold, open.
    Run,
    /// Close until contact, probe and hold; the worm holds on. Homes and records first where that is missing.
    Close,
    /// Open to the rest position; homes where that is missing.
    Open,
    /// Motor off, in any state.
    Stop,
    /// Clear a latched fault. The finger must be homed again.
    Clear,
    /// Measure the offset, find the opening stop, go to the rest position.
    Home,
    /// Record friction again.
    RecordFriction,
    /// Open, press against the closing stop, open again: what calibrates the cable.
    Press,
}

/// What sensing and the board report to the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A contact began.
    Touched,
    /// The contact is judged: no further torque will improve it.
    Settled,
    /// A friction record is there (recorded now, or loaded at start).
    FrictionKnown,
    /// There is no friction record, or it no longer fits: the next motion records it again.
    FrictionUnknown,
    /// The recording that just ended is unusable: no contact can be detected.
    FrictionNotRecorded,
    /// A fault that the board or a task found.
    Fault(Fault),
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// A fault is latched: clear it first.
    Faulted(Fault),
    /// The cause of this fault is not gone: nothing is cleared.
    StillThere(Fault),
    /// Something else is going on: stop it first.
    Busy(State),
    /// Nothing to clear.
    NoFault,
    /// There is no friction record: record friction first, with nothing in the way.
    NoFriction,
    /// There is no cable to calibrate in this drivetrain.
    NoCable,
    /// This firmware cannot identify its motor.
    NotFitted,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionResult {
    /// A contact was felt.
    Contact,
    /// The whole travel without contact.
    NoContact,
    /// Friction could not be recorded, so nothing could be felt.
    NotRecorded,
    /// The motion asked for (homing, opening, recording, pressing) is complete.
    Complete,
    /// Ended by stop.
    Stopped,
}

impl MotionResult {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        const NAMES: &str = "contact\nno-contact\nnot-recorded\ncomplete\nstopped\n";
        nth(NAMES, self as u8)
    }
}
