//! The motion sequence against the plant, with contacts taken from the truth: how steadily it moves, where it stops.

use palpate::drive::demand::{Demand, Status};
use palpate::drive::sequence::{Notice, Request, Sequence, State};
use palpate::joint_sensor::NoJointSensor;
use palpate::sample::{Drive, Sample};
use palpate::scene::Scene;
use palpate_plant::{Grasp, Parameters, Plant, Shape};
use palpate_scenes::P70;
use palpate_simulation::{Board, Machine, SlowLoop};

struct Motion {
    sequence: Sequence,
    notice: Option<Notice>,
    fault: Option<palpate::drive::fault::Fault>,
}

impl SlowLoop for Motion {
    type Joint = NoJointSensor;

    fn sample(&mut self, sample: &Sample, status: &Status) -> Demand {
        let advance = self
            .sequence
            .advance(sample.time_us, status, self.notice.take());
        self.fault = self.fault.or(advance.fault);
        advance.demand
    }
}

/// Mean and standard deviation of what is added.
#[derive(Default)]
struct Spread(f64, f64, f64);

impl Spread {
    fn add(&mut self, x: f32) {
        let x = f64::from(x);
        *self = Self(self.0 + 1.0, self.1 + x, self.2 + x * x);
    }
    fn of(&self) -> (f64, f64) {
        let mean = self.1 / self.0;
        (mean, (self.2 / self.0 - mean * mean).max(0.0).sqrt())
    }
}

fn main() {
    let seed = std::env::args()
        .nth(1)
        .and_then(|s| s.parse().ok())
        .unwrap_or(1);
    let plant = Plant::new(&Parameters::default(), &Grasp::Free, seed).expect("plant");
    let scale = *P70::CHECKED.scale();
    let motion = Motion {
        sequence: Sequence::new(P70::MOTION, scale),
        notice: None,
        fault: None,
    };
    let mut machine =
        Machine::new(Board::new(plant), &P70::DRIVE, NoJointSensor, motion).expect("config");
    let start = std::time::Instant::now();
    for request in [Request::RecordFriction, Request::Close, Request::Open] {
        if request == Request::Close {
            let grasp = Grasp::touching(2, 0.03, 0.8, Shape::Cylinder { diameter_m: 0.01 });
            machine.board.plant.place(&grasp).expect("free");
            machine.slow.notice = Some(Notice::FrictionKnown);
            machine.until_sample();
        }
        machine.slow.sequence.request(request).expect("idle");
        let mut touched = false;
        let (mut speed, mut current) = (Spread::default(), Spread::default());
        let mut last = State::Idle;
        for _ in 0..40_000 {
            let sample = machine.until_sample();
            let truth = machine.board.plant.truth();
            if let Some(first) = truth.first_contact
                && request == Request::Close
                && !touched
                && truth.time_s > first.time_s + 0.03
            {
                touched = true;
                machine.slow.notice = Some(Notice::Touched);
            }
            let state = machine.slow.sequence.state();
            if state == last {
                if sample.drive != Drive::Idle {
                    speed.add(machine.controller.status().speed_counts_per_s);
                    current.add(1e3 * sample.current_a);
                }
                continue;
            }
            println!(
                "{:8.3} s {last:?}: speed {:.0?} counts/s, current {:.3?} mA, theta_a {:.4} rad, torque {:.3} N m, position {:.4} rad, offset {:.2} mA",
                sample.time_us as f64 * 1e-6,
                speed.of(),
                current.of(),
                truth.theta_a_rad,
                truth.torque_nm,
                machine.controller.scale().angle_rad(sample.position_counts),
                1e3 * machine.controller.status().offset_a,
            );
            (speed, current, last) = (Spread::default(), Spread::default(), state);
            if state == State::Idle || state == State::Fault {
                break;
            }
        }
        println!(
            "{request:?}: fault {:?}, {:?}",
            machine.slow.fault,
            machine.board.plant.truth().contacts
        );
    }
    let truth = machine.board.plant.truth();
    println!(
        "{:.0} times real time",
        truth.time_s / start.elapsed().as_secs_f64()
    );
}
