//! The motion sequence: an explicit state machine that turns requests and notices into demands on the control interrupt.
//! It runs about once a millisecond; every state has its legal successors and its timeout in [`State`].

mod homing;
mod messages;
mod motion;
mod stall_detector;
mod state;
mod stop_detector;
#[cfg(test)]
mod tests;
mod transitions;

use super::convert::Scale;
use super::demand::{Demand, Setpoint, Status};
use super::fault::Fault;
use crate::numeric::Bounded;
use homing::Homing;
pub use messages::{MotionResult, Notice, Refused, Request};
pub use motion::{Motion, WINDUP_RAD};
use stall_detector::StallDetector;
pub use state::State;
use stop_detector::StopDetector;
use transitions::Observation;

/// Way in which opening, and homing after a fault, may take all the current that the drive allows, radian at the input link.
/// A worm that settled under the load of a probing may need as much current to start as made that load; to go on it needs no
/// more than free motion. Against a stop the cable winds up by no more than this.
const BREAKAWAY_RAD: f32 = 0.02;

/// What one step of the sequence decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepOutput {
    /// For the control interrupt.
    pub demand: Demand,
    /// A change of state: from, to.
    pub changed: Option<(State, State)>,
    /// The sequence ended in this step.
    pub done: Option<MotionResult>,
    /// The fault that was entered in this step.
    pub fault: Option<Fault>,
}

/// State of a sequence.
#[derive(Clone, Debug)]
pub struct Sequence {
    motion: Motion,
    scale: Scale,
    state: State,
    /// When the state began.
    since_us: u32,
    /// When homing last turned to the stop.
    turned_us: u32,
    start_counts: i32,
    /// Request that the motion under way serves.
    goal: Request,
    outcome: MotionResult,
    friction_known: bool,
    /// The finger was homed since the start, even if a fault was cleared afterwards: positions are roughly known.
    zeroed: bool,
    latched: Option<Fault>,
    /// See [`Status::present`].
    present: Option<Fault>,
    request: Option<Request>,
    demand: Demand,
    homing: Homing,
    /// Run-ups taken in this homing: each goes further, because a soft cable needs more way to unwind.
    run_ups: u8,
    onset: StopDetector,
    stall: StallDetector,
    /// The offset's measurement has begun in this state.
    measuring: bool,
    /// Clearing was asked for and not yet confirmed.
    clearing: bool,
    /// The closing is over: opening now ends the motion.
    returning: bool,
    /// A fault was cleared, or a closing ended where it was, and nothing homed since: the finger may be pressed on something. Homing
    /// of a finger that stands free starts gently, because what it starts with shifts the stop that it finds by some milliradians.
    unsure: bool,
    /// Sensing has said its last word on the contact of this closing.
    judged: bool,
    /// The next recording is followed by a press on the closing stop.
    press: bool,
    /// This closing presses on the closing stop.
    pressing: bool,
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
            goal: Request::Run,
            outcome: MotionResult::Complete,
            friction_known: false,
            zeroed: false,
            latched: None,
            present: None,
            request: None,
            demand: Demand::default(),
            homing: Homing::Seek,
            run_ups: 0,
            onset: StopDetector::default(),
            stall: StallDetector::default(),
            measuring: false,
            clearing: false,
            returning: false,
            judged: false,
            press: false,
            pressing: false,
            unsure: false,
        }
    }

    /// The state it is in.
    pub fn state(&self) -> State {
        self.state
    }

    /// Fault that is latched.
    pub fn fault(&self) -> Option<Fault> {
        self.latched
    }

    /// Speeds, currents and angles in force.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Changes speeds, currents and angles; `motion` is assumed valid. Takes effect with the next step.
    pub fn set_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// Changes the current that holds; within the limit of the current. Takes effect with the next step.
    pub fn set_holding_current(&mut self, current_a: f32) {
        self.motion.holding_current_a = current_a;
    }

    /// Lowers the current that holds to at most this, ampere. Takes effect with the next step.
    pub fn limit_holding_current(&mut self, current_a: f32) {
        self.motion.holding_current_a = self.motion.holding_current_a.at_most(current_a);
    }

    /// There is a friction record.
    pub fn friction_known(&self) -> bool {
        self.friction_known
    }

    /// The next motion that closes records friction first.
    pub fn forget_friction(&mut self) {
        self.friction_known = false;
    }

    /// Whether the next recording, which shows that nothing is in the way, is followed by a press on the closing stop: where nobody
    /// knows the cable.
    pub fn set_press(&mut self, press: bool) {
        self.press = press;
    }

    /// Whether the closing under way, or the last one, presses on the closing stop.
    pub fn is_pressing(&self) -> bool {
        self.pressing
    }

    /// Asks for a motion. `Stop` is never refused and replaces whatever was asked before.
    ///
    /// # Errors
    /// Why not now, and what to do first.
    pub fn request(&mut self, request: Request) -> Result<(), Refused> {
        let waiting = self.request == Some(Request::Stop) && request != Request::Stop;
        let permitted = match (request, self.state) {
            (Request::Stop, _) => true,
            (Request::Clear, State::Fault) => match self.present {
                Some(fault) => return Err(Refused::StillThere(fault)),
                None => true,
            },
            (Request::Clear, _) => return Err(Refused::NoFault),
            (_, State::Fault) => false,
            (_, State::Idle) => true,
            (Request::Open, State::Close | State::Probe | State::Hold) => !waiting,
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
    pub fn advance(&mut self, now_us: u64, status: &Status, notice: Option<Notice>) -> StepOutput {
        let before = self.state;
        self.present = status.present;
        match notice {
            Some(Notice::FrictionKnown) => {
                self.friction_known = true;
                // A recording that was stopped early may be good, but no press follows it.
                self.press &= !self.pressing;
            }
            Some(Notice::FrictionUnknown | Notice::FrictionNotRecorded) => {
                self.friction_known = false
            }
            Some(Notice::Settled) => self.judged = true,
            _ => {}
        }
        // Differences of the lower half are right for more than an hour, which no state lasts that has a timeout.
        let now_us = now_us as u32;
        let wanted_counts_per_s = self.scale.counts_per_s(self.motion.closing_rad_per_s);
        let way_counts = status.position_counts.wrapping_sub(self.start_counts);
        let seen = Observation {
            now_us,
            status,
            notice,
            angle_rad: self.scale.angle_rad(status.position_counts),
            way_rad: self.scale.angle_rad(way_counts),
            stalled: self.stall.update(now_us, status, wanted_counts_per_s),
        };
        if let Some(next) = self.next(&seen) {
            self.enter(next, now_us, status);
        }
        self.demand.setpoint = self.setpoint(status.position_counts);
        let entered = self.state != before;
        StepOutput {
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

    /// Enters a state; a step that is not in the table is a fault of its own.
    fn enter(&mut self, next: State, now_us: u32, status: &Status) {
        let legal = self.state.may_become(next);
        let pressed = matches!(self.state, State::Close | State::Probe | State::Hold);
        self.unsure |= pressed && next == State::Idle;
        self.state = if legal { next } else { State::Fault };
        if !legal {
            self.latched = Some(Fault::IllegalTransition);
        }
        self.since_us = now_us;
        self.turned_us = now_us;
        self.start_counts = status.position_counts;
        self.stall = StallDetector::default();
        match next {
            State::CalibrateOffset => {
                self.outcome = MotionResult::Complete;
                self.measuring = false;
            }
            State::Home => {
                self.homing = Homing::Seek;
                self.run_ups = 0;
                self.onset = StopDetector::default();
            }
            State::Close => {
                self.returning = true;
                self.judged = false;
            }
            _ => {}
        }
    }

    /// Setpoint of the state, at a position.
    fn setpoint(&self, position_counts: i32) -> Setpoint {
        let motion = &self.motion;
        let way_rad = self
            .scale
            .angle_rad(position_counts.wrapping_sub(self.start_counts));
        let may_break_away = match self.state {
            State::Open => true,
            State::Home => self.unsure,
            _ => false,
        };
        let breaks_away = may_break_away && way_rad.abs() < BREAKAWAY_RAD;
        let speed = |rad_per_s: f32, current_limit_a: f32| Setpoint::Speed {
            counts_per_s: self.scale.counts_per_s(rad_per_s),
            // The controller clamps at its own limit.
            current_limit_a: if breaks_away {
                f32::MAX
            } else {
                current_limit_a
            },
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
