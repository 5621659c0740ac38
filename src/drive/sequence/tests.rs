//! The sequence with the controller and a simple motor, and the transition table against what really happens.

use super::*;
use crate::drive::Controller;
use crate::drive::bench::Bench;
use crate::drive::config::tests::p70;

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
struct Rig {
    bench: Bench,
    controller: Controller,
    sequence: Sequence,
    demand: Demand,
    outputs: crate::drive::io::Outputs,
    now_us: u64,
    log: Vec<(State, State)>,
    done: Option<Outcome>,
}

impl Rig {
    fn new(seed: u64) -> Self {
        let controller = Controller::new(&p70()).expect("valid");
        let sequence = Sequence::new(motion(), *controller.scale());
        Self {
            bench: Bench::new(seed),
            controller,
            sequence,
            demand: Demand::default(),
            outputs: crate::drive::io::Outputs::Off,
            now_us: 0,
            log: Vec::new(),
            done: None,
        }
    }

    /// A millisecond. A contact is told 20 ms after it began.
    fn millisecond(&mut self, notice: Option<Notice>) -> Advance {
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

    fn run(&mut self, request: Request, seconds: u32) -> Option<Outcome> {
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

    fn states(&self) -> Vec<State> {
        self.log.iter().map(|&(_, to)| to).collect()
    }
}

#[test]
fn a_run_without_object_records_closes_and_opens() {
    use State::*;
    let mut rig = Rig::new(1);
    assert_eq!(
        rig.run(Request::Run, 60),
        Some(Outcome::NoContact),
        "{:?} {:?}",
        rig.log,
        rig.sequence.fault()
    );
    assert_eq!(
        rig.states(),
        [
            CalibrateOffset,
            Home,
            RecordClosing,
            RecordOpening,
            Close,
            Open,
            Idle
        ]
    );
    rig.log.clear();
    assert_eq!(rig.run(Request::Run, 60), Some(Outcome::NoContact));
    assert_eq!(
        rig.states(),
        [CalibrateOffset, Home, Close, Open, Idle],
        "the record is kept"
    );
}

#[test]
fn a_run_with_object_probes_and_holds() {
    use State::*;
    let mut rig = Rig::new(2);
    rig.bench.object_rad = 0.8;
    rig.sequence.friction_known = true;
    assert_eq!(
        rig.run(Request::Run, 60),
        Some(Outcome::Contact),
        "{:?} {:?}",
        rig.log,
        rig.sequence.fault()
    );
    assert_eq!(
        rig.states(),
        [CalibrateOffset, Home, Close, Probe, Hold, Open, Idle]
    );
    assert!(rig.bench.link_rad() < 0.07);
}

#[test]
fn homing_finds_the_stop_and_not_the_windup() {
    for (seed, start_rad) in [(1, 0.02), (2, 0.5), (3, 1.4)] {
        let mut rig = Rig::new(seed);
        rig.bench.angle = start_rad * 1280.0;
        assert_eq!(
            rig.run(Request::Home, 60),
            Some(Outcome::Complete),
            "{:?}",
            rig.sequence.fault()
        );
        let zero_rad = rig.bench.link_rad()
            - f64::from(
                rig.controller
                    .scale()
                    .angle_rad(rig.controller.status().position_counts),
            );
        // The stop is at 0, the motor stands at about -0.03 with the bench's friction and cable.
        assert!(zero_rad.abs() < 0.012, "zero off by {zero_rad} rad");
    }
}

#[test]
fn pressing_ends_at_the_closing_stop() {
    use State::*;
    let mut rig = Rig::new(3);
    rig.sequence.friction_known = true;
    assert_eq!(
        rig.run(Request::Press, 60),
        Some(Outcome::Complete),
        "{:?} {:?}",
        rig.log,
        rig.sequence.fault()
    );
    assert_eq!(rig.states(), [CalibrateOffset, Home, Close, Open, Idle]);
}

#[test]
fn close_keeps_the_grip_and_open_lets_go() {
    let mut rig = Rig::new(4);
    rig.bench.object_rad = 0.5;
    rig.sequence.friction_known = true;
    assert_eq!(rig.run(Request::Close, 60), Some(Outcome::Contact));
    assert!(rig.bench.link_rad() > 0.5);
    assert_eq!(rig.run(Request::Open, 60), Some(Outcome::Complete));
    assert!(rig.bench.link_rad() < 0.07);
}
