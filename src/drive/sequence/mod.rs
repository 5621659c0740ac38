//! The motion sequence: what the motor is asked for, and when.

mod state;

use super::demand::{Demand, Status};
use super::fault::Fault;
pub use state::State;

/// What the user asks of the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Request {
    /// Everything: offset, home, friction if there is no record, close, probe, hold, open.
    Run,
    /// Close until contact, probe and hold.
    Close,
    /// Open to the rest position.
    Open,
    /// Motor off, whatever goes on.
    Stop,
    /// Clear a latched fault.
    Clear,
    /// Measure the offset and find the opening stop.
    Home,
    /// Record friction anew.
    RecordFriction,
}

/// What sensing and the board tell the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Notice {
    /// A contact began.
    Touched,
    /// The contact is judged: no further torque will improve it.
    Settled,
    /// A friction record is there (recorded now, or loaded at start).
    FrictionRecorded,
    /// A fault that the board or a task found.
    Fault(Fault),
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Refused {
    /// A fault is latched: clear it first.
    Faulted(Fault),
    /// Something else is going on: stop it first.
    Busy(State),
    /// Nothing to clear.
    NoFault,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Outcome {
    /// A contact was felt.
    Contact,
    /// The whole travel without contact.
    NoContact,
    /// The motion asked for (homing, opening, recording) is complete.
    Complete,
    /// Ended by stop.
    Stopped,
}

/// What one step of the sequence decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// For the control interrupt.
    pub demand: Demand,
    /// A change of state: from, to.
    pub changed: Option<(State, State)>,
    /// The sequence ended in this step.
    pub done: Option<Outcome>,
    /// The fault that was entered in this step.
    pub fault: Option<Fault>,
}

/// What the sequence must know: speeds, currents and times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Speed of the input link while recording friction, closing and probing, radian per second. One speed for all three:
    /// the worm's friction depends on speed.
    pub closing_rad_per_s: f32,
    /// Speed of the input link while opening, radian per second.
    pub opening_rad_per_s: f32,
    /// Current limit while closing and opening free, ampere.
    pub free_current_a: f32,
    /// Current limit while homing against the stop, ampere.
    pub homing_current_a: f32,
    /// Current that ends probing, ampere.
    pub probing_current_a: f32,
    /// How far probing may close on after the contact, radian.
    pub probing_rad: f32,
    /// Current while holding, ampere.
    pub holding_current_a: f32,
    /// How long a run holds, second.
    pub holding_s: f32,
    /// Where opening ends, radian from the opening stop.
    pub rest_rad: f32,
    /// Where closing ends, radian from the opening stop.
    pub travel_rad: f32,
}

/// State of a sequence.
#[derive(Clone, Debug)]
pub struct Sequence {
    state: State,
}

impl Sequence {
    /// Where the sequence is.
    pub fn state(&self) -> State {
        self.state
    }

    /// One step, about once a millisecond.
    pub fn advance(&mut self, _now_us: u64, _status: &Status, _notice: Option<Notice>) -> Advance {
        Advance {
            demand: Demand::default(),
            changed: None,
            done: None,
            fault: None,
        }
    }
}
