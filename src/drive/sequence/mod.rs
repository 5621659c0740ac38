//! The motion sequence: an explicit state machine that turns requests and notices into demands on the control interrupt.
//! It runs about once a millisecond; every state has its legal successors and its timeout in [`State`].

mod homing;
mod motion;
mod stall;
mod state;
#[cfg(test)]
mod tests;

use super::convert::Scale;
use super::demand::{Demand, Offset, Setpoint, Status};
use super::fault::Fault;
use homing::Onset;
pub use motion::{Motion, WINDUP_RAD};
use stall::Stall;
pub use state::State;

/// What the user asks of the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Request {
    /// Everything: offset, home, friction if there is no record, close, probe, hold, open.
    Run,
    /// Close until contact, probe and hold; the worm holds on. Homes and records first where that is missing.
    Close,
    /// Open to the rest position; homes where that is missing.
    Open,
    /// Motor off, whatever goes on.
    Stop,
    /// Clear a latched fault. The finger must be homed again.
    Clear,
    /// Measure the offset, find the opening stop, go to the rest position.
    Home,
    /// Record friction anew.
    RecordFriction,
    /// Press against the closing stop, then open: what calibrates the cable.
    Press,
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
    FrictionKnown,
    /// There is no friction record, or it no longer fits: the next motion records anew.
    FrictionUnknown,
    /// The recording that just ended is of no use: nothing can be felt.
    FrictionNotRecorded,
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
    /// There is no friction record: record friction first, with nothing in the way.
    NoFriction,
    /// There is no cable to calibrate in this drivetrain.
    NoCable,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Outcome {
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

/// What the current motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    Run,
    Close,
    Open,
    Home,
    RecordFriction,
    Press,
}

/// Where homing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Homing {
    Seek,
    RunUp,
    Zero,
    BackOff,
}

/// Time from a start until the current is that of steady motion, microseconds: the reference takes 30 ms to its speed, the
/// speed loop as long again.
const STARTED_US: u64 = 100_000;
/// Free way before the opening stop that tells free motion from windup, radian: 0.3 s and a backlash.
const RUN_UP_RAD: f32 = 0.12;
/// Two homings on the same stop differ by less, radian: twice what one may be off by.
const SAME_STOP_RAD: f32 = 0.025;
/// So close to the rest position counts as there, radian.
const AT_REST_RAD: f32 = 0.05;

/// State of a sequence.
#[derive(Clone, Debug)]
pub struct Sequence {
    motion: Motion,
    scale: Scale,
    state: State,
    since_us: u64,
    /// When homing last turned to the stop.
    turned_us: u64,
    start_counts: i32,
    goal: Goal,
    outcome: Outcome,
    friction_known: bool,
    /// There has been a homing since the start, cleared faults notwithstanding: positions mean something.
    zeroed: bool,
    latched: Option<Fault>,
    request: Option<Request>,
    demand: Demand,
    homing: Homing,
    /// Run-ups taken in this homing: each goes further, for a cable softer than most needs more to unwind.
    run_ups: u8,
    onset: Onset,
    stall: Stall,
    /// The offset's measurement has begun in this state.
    measuring: bool,
    /// Clearing was asked for and not yet confirmed.
    clearing: bool,
    /// The closing is over: opening now ends the motion.
    returning: bool,
}

impl Sequence {
    /// A sequence at rest. `motion` is assumed valid ([`Motion::validate`]).
    pub fn new(motion: Motion, scale: Scale) -> Self {
        Self {
            motion,
            scale,
            state: State::Idle,
            since_us: 0,
            turned_us: 0,
            start_counts: 0,
            goal: Goal::Run,
            outcome: Outcome::Complete,
            friction_known: false,
            zeroed: false,
            latched: None,
            request: None,
            demand: Demand::default(),
            homing: Homing::Seek,
            run_ups: 0,
            onset: Onset::default(),
            stall: Stall::default(),
            measuring: false,
            clearing: false,
            returning: false,
        }
    }

    /// Where the sequence is.
    pub fn state(&self) -> State {
        self.state
    }

    /// Fault that is latched.
    pub fn fault(&self) -> Option<Fault> {
        self.latched
    }

    /// Speeds, currents and places in force.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Changes speeds, currents and places; `motion` is assumed valid. Takes effect at the next change of state.
    pub fn set_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// There is a friction record.
    pub fn friction_known(&self) -> bool {
        self.friction_known
    }

    /// The next motion that closes records friction first.
    pub fn forget_friction(&mut self) {
        self.friction_known = false;
    }

    /// Asks for a motion. `Stop` is never refused and replaces whatever was asked before.
    ///
    /// # Errors
    /// Why not now, and what to do first.
    pub fn request(&mut self, request: Request) -> Result<(), Refused> {
        let waiting = self.request == Some(Request::Stop) && request != Request::Stop;
        let permitted = match (request, self.state) {
            (Request::Stop, _) => true,
            (Request::Clear, State::Fault) => true,
            (Request::Clear, _) => return Err(Refused::NoFault),
            (_, State::Fault) => false,
            (_, State::Idle) | (Request::Open, State::Close | State::Probe | State::Hold) => {
                !waiting
            }
            _ => false,
        };
        if permitted {
            self.request = Some(request);
            return Ok(());
        }
        match self.latched {
            Some(fault) => Err(Refused::Faulted(fault)),
            None => Err(Refused::Busy(self.state)),
        }
    }

    /// One step, about once a millisecond: the time now, what the control interrupt reports, at most one notice.
    pub fn advance(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> Advance {
        let before = self.state;
        match notice {
            Some(Notice::FrictionKnown) => self.friction_known = true,
            Some(Notice::FrictionUnknown | Notice::FrictionNotRecorded) => {
                self.friction_known = false
            }
            _ => {}
        }
        let next = self.next(now_us, status, notice);
        if let Some(next) = next {
            self.enter(next, now_us, status);
        }
        self.demand.setpoint = self.setpoint();
        let entered = self.state != before;
        Advance {
            demand: self.demand,
            changed: entered.then_some((before, self.state)),
            done: (entered && self.state == State::Idle && before != State::Fault)
                .then_some(self.outcome),
            fault: if entered && self.state == State::Fault {
                self.latched
            } else {
                None
            },
        }
    }

    /// The state to enter now, `None` to stay. Faults come first, then stop, then timeouts, then what the state decides.
    fn next(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> Option<State> {
        let request = self.request.take();
        if self.state == State::Fault {
            return self.leave_fault(status, request);
        }
        let told = if let Some(Notice::Fault(fault)) = notice {
            Some(fault)
        } else {
            None
        };
        if let Some(fault) = status.fault.or(told) {
            return self.fail(fault);
        }
        match (request, self.state) {
            (Some(Request::Stop), State::Idle) => return None,
            (Some(Request::Stop), _) => return self.end(Outcome::Stopped),
            (_, State::Idle) => return self.start(request),
            (Some(Request::Open), State::Close | State::Probe | State::Hold) => {
                self.outcome = Outcome::Complete;
                return Some(State::Open);
            }
            _ => {}
        }
        if self.overdue(now_us) {
            return self.fail(Fault::StateTimeout);
        }
        match self.state {
            State::Idle | State::Fault => None,
            State::CalibrateOffset => self.offset_measured(status),
            State::Home => self.home(now_us, status),
            State::RecordClosing => self.record_closing(now_us, status),
            State::RecordOpening => self.record_opening(now_us, status),
            State::Close => self.close(now_us, status, notice),
            State::Probe => self.probe(now_us, status, notice),
            State::Hold => self.hold(now_us),
            State::Open => self.open(now_us, status),
        }
    }

    /// Latches a fault.
    fn fail(&mut self, fault: Fault) -> Option<State> {
        self.latched = Some(fault);
        Some(State::Fault)
    }

    /// Ends the motion.
    fn end(&mut self, outcome: Outcome) -> Option<State> {
        self.outcome = outcome;
        Some(State::Idle)
    }

    /// Out of `Fault`: the control interrupt must have cleared its own first.
    fn leave_fault(&mut self, status: &Status, request: Option<Request>) -> Option<State> {
        if request == Some(Request::Clear) {
            self.demand.clear = self.demand.clear.wrapping_add(1);
            self.clearing = true;
        }
        if !self.clearing || status.clear != self.demand.clear {
            return None;
        }
        self.clearing = false;
        self.latched = status.fault;
        if self.latched.is_some() {
            None
        } else {
            Some(State::Idle)
        }
    }

    /// Out of `Idle`: every motion begins with the offset.
    fn start(&mut self, request: Option<Request>) -> Option<State> {
        self.goal = match request? {
            Request::Run => Goal::Run,
            Request::Close => Goal::Close,
            Request::Open => Goal::Open,
            Request::Home => Goal::Home,
            Request::RecordFriction => Goal::RecordFriction,
            Request::Press => Goal::Press,
            Request::Stop | Request::Clear => return None,
        };
        self.returning = false;
        Some(State::CalibrateOffset)
    }

    fn offset_measured(&mut self, status: &Status) -> Option<State> {
        // `Known` may be the last motion's until the control interrupt has begun anew.
        self.measuring |= status.offset == Offset::Measuring;
        if !self.measuring || status.offset != Offset::Known {
            return None;
        }
        if !status.homed || matches!(self.goal, Goal::Run | Goal::Home) {
            return Some(State::Home);
        }
        let at_rest = self.angle_rad(status) < self.motion.rest_rad + AT_REST_RAD;
        match self.goal {
            Goal::Open => Some(State::Open),
            _ if self.must_record() && !at_rest => Some(State::Open),
            _ => self.first_motion(),
        }
    }

    /// Whether friction is still to be recorded.
    fn must_record(&self) -> bool {
        match self.goal {
            Goal::RecordFriction => true,
            Goal::Run | Goal::Close | Goal::Press => !self.friction_known,
            Goal::Open | Goal::Home => false,
        }
    }

    /// What the goal wants first of a finger at its rest position.
    fn first_motion(&mut self) -> Option<State> {
        match self.goal {
            Goal::Open | Goal::Home => self.end(Outcome::Complete),
            _ if self.must_record() => Some(State::RecordClosing),
            _ => Some(State::Close),
        }
    }

    /// Opens against the stop, makes the stop's begin the zero, backs off to the rest position.
    fn home(&mut self, now_us: u64, status: &Status) -> Option<State> {
        match self.homing {
            Homing::Seek => {
                if now_us.saturating_sub(self.turned_us) > STARTED_US {
                    self.onset
                        .update(status.current_a.abs(), status.position_counts);
                }
                let travelled_rad = self
                    .scale
                    .angle_rad(self.start_counts.wrapping_sub(status.position_counts));
                if travelled_rad > self.motion.travel_rad + 2.0 * WINDUP_RAD {
                    return self.fail(Fault::TravelLimit);
                }
                if !self.stalled(now_us, status) {
                    return None;
                }
                let stop_counts = self
                    .onset
                    .position_counts()
                    .unwrap_or(status.position_counts);
                let free_rad = self
                    .scale
                    .angle_rad(self.start_counts.wrapping_sub(stop_counts));
                self.stall = Stall::default();
                if free_rad < RUN_UP_RAD {
                    // Too short a way to tell free motion from windup: take a run-up.
                    self.start_counts = status.position_counts;
                    self.homing = Homing::RunUp;
                    self.run_ups = self.run_ups.saturating_add(1);
                } else {
                    self.demand.zero = self.demand.zero.wrapping_add(1);
                    self.demand.zero_at_counts = self.zero_counts(stop_counts);
                    self.zeroed = true;
                    self.homing = Homing::Zero;
                }
                None
            }
            Homing::RunUp => {
                let away_rad = self
                    .scale
                    .angle_rad(status.position_counts.wrapping_sub(self.start_counts));
                if away_rad > RUN_UP_RAD + f32::from(self.run_ups) * WINDUP_RAD {
                    self.homing = Homing::Seek;
                    self.onset = Onset::default();
                    self.stall = Stall::default();
                    self.start_counts = status.position_counts;
                    self.turned_us = now_us;
                }
                self.fail_if_stalled(now_us, status)
            }
            Homing::Zero => {
                if status.zero == self.demand.zero {
                    self.stall = Stall::default();
                    self.homing = Homing::BackOff;
                }
                None
            }
            Homing::BackOff => {
                if self.angle_rad(status) >= self.motion.rest_rad {
                    return self.first_motion();
                }
                self.fail_if_stalled(now_us, status)
            }
        }
    }

    /// Where the zero is to be, for a stop found at a position.
    ///
    /// The friction record goes up and down with the turn of the worm: shifted by the few milliradians by which homings
    /// differ it leaves what the detector takes for a contact, or for less than friction. The zero it was taken with stays,
    /// unless the stop is so far off that counts were lost.
    fn zero_counts(&self, stop_counts: i32) -> i32 {
        let same = self.scale.angle_rad(stop_counts).abs() < SAME_STOP_RAD;
        if self.zeroed && self.friction_known && same {
            0
        } else {
            stop_counts
        }
    }

    fn record_closing(&mut self, now_us: u64, status: &Status) -> Option<State> {
        if self.angle_rad(status) >= self.motion.travel_rad {
            return Some(State::RecordOpening);
        }
        self.fail_if_stalled(now_us, status)
    }

    fn record_opening(&mut self, now_us: u64, status: &Status) -> Option<State> {
        if self.angle_rad(status) > self.motion.rest_rad {
            return self.fail_if_stalled(now_us, status);
        }
        self.friction_known = true;
        if self.goal == Goal::RecordFriction {
            return self.end(Outcome::Complete);
        }
        Some(State::Close)
    }

    fn close(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> Option<State> {
        let stalled = self.stalled(now_us, status);
        if self.goal == Goal::Press {
            // The contact wanted is the stop: it ends where the current ends.
            self.outcome = Outcome::Complete;
            return stalled.then_some(State::Open);
        }
        if notice == Some(Notice::Touched) {
            self.outcome = Outcome::Contact;
            return Some(State::Probe);
        }
        if notice == Some(Notice::FrictionNotRecorded) {
            self.outcome = Outcome::NotRecorded;
            return Some(State::Open);
        }
        if self.angle_rad(status) >= self.motion.travel_rad {
            self.outcome = Outcome::NoContact;
            return Some(State::Open);
        }
        if stalled {
            self.fail(Fault::Stall)
        } else {
            None
        }
    }

    fn probe(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> Option<State> {
        let closed_rad = self
            .scale
            .angle_rad(status.position_counts.wrapping_sub(self.start_counts));
        let ended = notice == Some(Notice::Settled)
            || closed_rad >= self.motion.probing_rad
            || self.angle_rad(status) >= self.motion.travel_rad
            || self.stalled(now_us, status);
        ended.then_some(State::Hold)
    }

    fn hold(&mut self, now_us: u64) -> Option<State> {
        if self.stay_s(now_us) < self.motion.holding_s {
            return None;
        }
        if self.goal == Goal::Run {
            Some(State::Open)
        } else {
            Some(State::Idle)
        }
    }

    fn open(&mut self, now_us: u64, status: &Status) -> Option<State> {
        if self.angle_rad(status) > self.motion.rest_rad {
            return self.fail_if_stalled(now_us, status);
        }
        if !self.returning && self.must_record() {
            Some(State::RecordClosing)
        } else {
            Some(State::Idle)
        }
    }

    fn stalled(&mut self, now_us: u64, status: &Status) -> bool {
        self.stall.update(
            now_us,
            status,
            self.scale.counts_per_s(self.motion.closing_rad_per_s),
        )
    }

    fn fail_if_stalled(&mut self, now_us: u64, status: &Status) -> Option<State> {
        if self.stalled(now_us, status) {
            self.fail(Fault::Stall)
        } else {
            None
        }
    }

    fn angle_rad(&self, status: &Status) -> f32 {
        self.scale.angle_rad(status.position_counts)
    }

    fn stay_s(&self, now_us: u64) -> f32 {
        now_us.saturating_sub(self.since_us) as f32 * 1e-6
    }

    fn overdue(&self, now_us: u64) -> bool {
        self.state
            .timeout_s(&self.motion)
            .is_some_and(|limit_s| self.stay_s(now_us) > limit_s)
    }

    /// Enters a state; a step that is not in the table is a fault of its own.
    fn enter(&mut self, next: State, now_us: u64, status: &Status) {
        let legal = self.state.may_become(next);
        self.state = if legal { next } else { State::Fault };
        if !legal {
            self.latched = Some(Fault::IllegalTransition);
        }
        self.since_us = now_us;
        self.turned_us = now_us;
        self.start_counts = status.position_counts;
        self.stall = Stall::default();
        match next {
            State::CalibrateOffset => {
                self.outcome = Outcome::Complete;
                self.measuring = false;
            }
            State::Home => {
                self.homing = Homing::Seek;
                self.run_ups = 0;
                self.onset = Onset::default();
            }
            State::Close => self.returning = true,
            _ => {}
        }
    }

    /// What the state asks of the motor.
    fn setpoint(&self) -> Setpoint {
        let motion = &self.motion;
        let speed = |rad_per_s: f32, current_limit_a: f32| Setpoint::Speed {
            counts_per_s: self.scale.counts_per_s(rad_per_s),
            current_limit_a,
        };
        match self.state {
            State::Idle | State::Fault => Setpoint::Off,
            State::CalibrateOffset => Setpoint::MeasureOffset,
            State::Home => match self.homing {
                Homing::Seek => speed(-motion.closing_rad_per_s, motion.homing_current_a),
                Homing::Zero => Setpoint::Brake,
                Homing::RunUp | Homing::BackOff => {
                    speed(motion.closing_rad_per_s, motion.free_current_a)
                }
            },
            State::RecordClosing => speed(motion.closing_rad_per_s, motion.free_current_a),
            State::Close | State::Probe => {
                speed(motion.closing_rad_per_s, motion.probing_current_a)
            }
            State::RecordOpening => speed(-motion.closing_rad_per_s, motion.free_current_a),
            State::Open => speed(-motion.opening_rad_per_s, motion.free_current_a),
            State::Hold => Setpoint::Current {
                a: motion.holding_current_a,
            },
        }
    }
}
