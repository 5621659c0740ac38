//! The decision which state comes next.

use super::Sequence;
use super::messages::{MotionResult, Notice, Request};
use super::state::{JUDGING_S, State};
use crate::drive::demand::{OffsetState, Status};
use crate::drive::fault::Fault;

/// So close to the rest position counts as there, radian.
const AT_REST_RAD: f32 = 0.05;

/// What a step decides from.
pub(super) struct Observation<'s> {
    pub(super) now_us: u32,
    /// What the control interrupt reports.
    pub(super) status: &'s Status,
    /// What sensing or the board notified.
    pub(super) notice: Option<Notice>,
    /// Angle of the input link from the zero, radian.
    pub(super) angle_rad: f32,
    /// The same from where the state began, or this leg of homing.
    pub(super) way_rad: f32,
    /// The motor wants to move and does not.
    pub(super) stalled: bool,
}

impl Sequence {
    /// The state to enter now, `None` to stay. Faults come first, then stop, then timeouts, then what the state decides.
    pub(super) fn next(&mut self, seen: &Observation) -> Option<State> {
        let request = self.request.take();
        if self.state == State::Fault {
            return self.leave_fault(seen.status, request);
        }
        let told = if let Some(Notice::Fault(fault)) = seen.notice {
            Some(fault)
        } else {
            None
        };
        if let Some(fault) = seen.status.fault.or(told) {
            return self.fail(fault);
        }
        match (request, self.state) {
            (Some(Request::Stop), State::Idle) => return None,
            (Some(Request::Stop), _) => return self.end(MotionResult::Stopped),
            (_, State::Idle) => return self.start(request),
            (Some(Request::Open), State::Close | State::Probe | State::Hold) => {
                self.pressing = false;
                return self.open_with(MotionResult::Complete);
            }
            _ => {}
        }
        let stay_s = seen.now_us.wrapping_sub(self.since_us) as f32 * 1e-6;
        let overdue = |limit_s| stay_s > limit_s;
        if self.state.timeout_s(&self.motion).is_some_and(overdue) {
            return self.fail(Fault::StateTimeout);
        }
        match self.state {
            State::Idle | State::Fault => None,
            State::CalibrateOffset => self.offset_measured(seen),
            State::Home => self.home(seen),
            State::RecordClosing => self.record_closing(seen),
            State::RecordOpening => self.record_opening(seen),
            State::Close => self.close(seen),
            State::Probe => self.probe(seen),
            State::Hold => self.hold(stay_s),
            State::Open => self.open(seen),
        }
    }

    /// Latches a fault.
    pub(super) fn fail(&mut self, fault: Fault) -> Option<State> {
        self.latched = Some(fault);
        if fault.loses_counts() {
            self.zeroed = false;
        }
        Some(State::Fault)
    }

    /// A fault where the motor stands still and should not.
    pub(super) fn fail_if_stalled(&mut self, seen: &Observation) -> Option<State> {
        if seen.stalled {
            self.fail(Fault::Stall)
        } else {
            None
        }
    }

    /// Ends the motion.
    fn end(&mut self, outcome: MotionResult) -> Option<State> {
        self.outcome = outcome;
        Some(State::Idle)
    }

    /// Opens, which is how the motion ends.
    fn open_with(&mut self, outcome: MotionResult) -> Option<State> {
        self.outcome = outcome;
        Some(State::Open)
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
            self.unsure = true;
            Some(State::Idle)
        }
    }

    /// Out of `Idle`: every motion begins with the offset.
    fn start(&mut self, request: Option<Request>) -> Option<State> {
        let goal = request?;
        if matches!(goal, Request::Stop | Request::Clear) {
            return None;
        }
        self.goal = goal;
        self.returning = false;
        self.pressing = goal == Request::Press;
        Some(State::CalibrateOffset)
    }

    fn offset_measured(&mut self, seen: &Observation) -> Option<State> {
        let Status { offset, homed, .. } = *seen.status;
        // `Known` may be the last motion's until the control interrupt has started the new one.
        self.measuring |= offset == OffsetState::Measuring;
        if !self.measuring || offset != OffsetState::Known {
            return None;
        }
        if !homed || matches!(self.goal, Request::Run | Request::Home) {
            return Some(State::Home);
        }
        let at_rest = seen.angle_rad < self.motion.rest_rad + AT_REST_RAD;
        if self.goal == Request::Open || self.begins_at_rest() && !at_rest {
            return Some(State::Open);
        }
        self.first_motion()
    }

    /// Whether friction is still to be recorded.
    fn must_record(&self) -> bool {
        match self.goal {
            Request::RecordFriction => true,
            Request::Open | Request::Home => false,
            _ => !self.friction_known,
        }
    }

    /// Whether the goal's first motion needs a finger that is open. A closing of a finger that is pressed would miss where the contact began.
    fn begins_at_rest(&self) -> bool {
        self.goal == Request::Press || self.unsure || self.must_record()
    }

    /// The goal's first motion of a finger at its rest position.
    pub(super) fn first_motion(&mut self) -> Option<State> {
        self.unsure = false;
        self.pressing = self.goal == Request::Press;
        if matches!(self.goal, Request::Open | Request::Home) {
            self.end(MotionResult::Complete)
        } else if self.must_record() {
            Some(State::RecordClosing)
        } else {
            Some(State::Close)
        }
    }

    fn record_closing(&mut self, seen: &Observation) -> Option<State> {
        if seen.angle_rad >= self.motion.travel_rad {
            return Some(State::RecordOpening);
        }
        self.fail_if_stalled(seen)
    }

    fn record_opening(&mut self, seen: &Observation) -> Option<State> {
        if seen.angle_rad > self.motion.rest_rad {
            return self.fail_if_stalled(seen);
        }
        self.friction_known = true;
        self.pressing |= self.press;
        if self.goal == Request::RecordFriction && !self.pressing {
            return self.end(MotionResult::Complete);
        }
        Some(State::Close)
    }

    fn close(&mut self, seen: &Observation) -> Option<State> {
        match seen.notice {
            Some(Notice::FrictionNotRecorded) => {
                self.pressing = false;
                self.open_with(MotionResult::NotRecorded)
            }
            _ if self.pressing => {
                // Pressing on the stop ends at the current limit, or where a soft cable is wound up to the position limit.
                let wound_up = seen.status.limited.position;
                (seen.stalled || wound_up).then_some(State::Open)
            }
            Some(Notice::Touched) => {
                // A closing that stood for an instant was judged then; the contact is not yet.
                self.judged = false;
                self.outcome = MotionResult::Contact;
                Some(State::Probe)
            }
            _ if seen.angle_rad >= self.motion.travel_rad => {
                self.open_with(MotionResult::NoContact)
            }
            _ => self.fail_if_stalled(seen),
        }
    }

    fn probe(&mut self, seen: &Observation) -> Option<State> {
        let ended = seen.notice == Some(Notice::Settled)
            || seen.way_rad >= self.motion.probing_rad
            || seen.angle_rad >= self.motion.travel_rad
            || seen.stalled;
        ended.then_some(State::Hold)
    }

    /// The object is held for its time, and until the contact is judged: what ends the motion comes last in the log.
    fn hold(&self, stay_s: f32) -> Option<State> {
        let judging_s = if self.judged { 0.0 } else { JUDGING_S };
        if stay_s < self.motion.holding_s + judging_s {
            None
        } else if self.goal == Request::Run {
            Some(State::Open)
        } else {
            Some(State::Idle)
        }
    }

    fn open(&mut self, seen: &Observation) -> Option<State> {
        if seen.angle_rad > self.motion.rest_rad {
            return self.fail_if_stalled(seen);
        }
        // After a press that nobody asked for, go on to what was asked for.
        let pressed = core::mem::take(&mut self.pressing);
        let goes_on = pressed && matches!(self.goal, Request::Run | Request::Close);
        if goes_on || !self.returning && self.begins_at_rest() {
            self.first_motion()
        } else {
            Some(State::Idle)
        }
    }
}
