//! The sequence with the controller and a simple motor.

mod bridge;
mod control;
mod faults;
mod grasps;
mod motions;
mod transitions;

use super::*;
use crate::drive::Controller;
use crate::drive::config::CheckedConfig;
use crate::drive::config::tests::p70;
use crate::drive::io::Outputs;
use crate::drive::test_motor::{Defect, TestMotor};

pub(crate) fn motion() -> Motion {
    Motion {
        closing_rad_per_s: 0.3,
        opening_rad_per_s: 0.6,
        free_current_a: 0.12,
        homing_current_a: 0.06,
        probing_current_a: 0.1,
        probing_rad: 0.6,
        holding_current_a: 0.05,
        holding_s: 0.5,
        rest_rad: 0.05,
        travel_rad: 1.5,
    }
}

/// Motor, controller and sequence.
struct Simulation {
    bench: TestMotor,
    controller: Controller,
    sequence: Sequence,
    demand: Demand,
    outputs: Outputs,
    now_us: u64,
    log: Vec<(State, State)>,
    done: Option<MotionResult>,
}

impl Simulation {
    fn new(seed: u64) -> Self {
        let controller = Controller::new(&CheckedConfig::new(p70()).expect("valid"));
        let sequence = Sequence::new(motion(), *controller.scale());
        Self {
            bench: TestMotor::new(seed),
            controller,
            sequence,
            demand: Demand::default(),
            outputs: Outputs::Off,
            now_us: 0,
            log: Vec::new(),
            done: None,
        }
    }

    /// A millisecond. A contact is told 20 ms after it began.
    fn millisecond(&mut self, notice: Option<Notice>) -> StepOutput {
        for _ in 0..20 {
            let inputs = self.bench.step(self.outputs);
            self.outputs = self.controller.step(&inputs, &self.demand);
        }
        self.now_us += 1000;
        let touched = self.sequence.state() == State::Close
            && self.bench.link_rad() > self.bench.object_rad + 0.006;
        let notice = notice.or(touched.then_some(Notice::Touched));
        let advance = self
            .sequence
            .advance(self.now_us, self.controller.status(), notice);
        self.demand = advance.demand;
        self.log.extend(advance.changed);
        self.done = self.done.or(advance.done);
        advance
    }

    fn run(&mut self, request: Request, seconds: u32) -> Option<MotionResult> {
        self.done = None;
        self.sequence.request(request).expect("accepted");
        for _ in 0..seconds * 1000 {
            self.millisecond(None);
            if self.done.is_some() || self.sequence.state() == State::Fault {
                break;
            }
        }
        self.done
    }

    /// Runs a request and demands how it ends.
    #[track_caller]
    fn ends(&mut self, request: Request, expected: MotionResult) {
        let result = self.run(request, 60);
        let why = (&self.log, self.sequence.fault());
        assert_eq!(result, Some(expected), "{why:?}");
    }

    /// Clears a fault.
    #[track_caller]
    fn clear(&mut self) {
        let request = self.sequence.request(Request::Clear);
        request.expect("a fault to clear");
        for _ in 0..5 {
            self.millisecond(None);
        }
    }

    fn states(&self) -> Vec<State> {
        self.log.iter().map(|&(_, to)| to).collect()
    }
}

/// A simulation that closes steadily in mid-travel.
fn closing(seed: u64) -> Simulation {
    let mut simulation = Simulation::new(seed);
    simulation.sequence.friction_known = true;
    simulation.sequence.request(Request::Run).expect("accepted");
    for _ in 0..20_000 {
        simulation.millisecond(None);
        if simulation.sequence.state() == State::Close && simulation.bench.link_rad() > 0.5 {
            return simulation;
        }
    }
    panic!(
        "does not close: {:?} {:?}",
        simulation.log,
        simulation.sequence.fault()
    );
}
