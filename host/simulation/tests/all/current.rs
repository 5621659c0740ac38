//! The sign of the current behind the bridge's mirror, and the dead time, against the plant's edges. Simulated.

use palpate::drive::config::CheckedConfig;
use palpate::drive::io::Outputs;
use palpate::drive::{Controller, Demand, Setpoint};
use palpate::sample::Drive;
use palpate::scene::Scene;
use palpate_plant::{Grasp, Parameters, Plant, World};
use palpate_scenes::{P70, P70Shunt};
use palpate_simulation::{Board, PERIOD_S};

/// The workshop's power stage with an exact gain, and a rotor with 20 times the inertia, so that it takes long to slow down.
fn heavy() -> Parameters {
    heavy_of("p70")
}

fn heavy_of(scene: &str) -> Parameters {
    let world = World::named("workshop").expect("a named world");
    let mut parameters = world.of(scene).expect("valid");
    parameters.motor.rotor_inertia_kg_m2 *= 20.0;
    parameters.sense.gain_error = 0.0;
    parameters
}

/// Board and control loop without a sequence.
struct Bench {
    board: Board,
    controller: Controller,
    outputs: Outputs,
}

impl Bench {
    fn new(parameters: &Parameters) -> Self {
        Self::of::<P70>(parameters)
    }

    fn of<S: Scene>(parameters: &Parameters) -> Self {
        let drive = CheckedConfig::new(S::DRIVE).expect("valid");
        let mut bench = Self {
            board: Board::new(Plant::new(parameters, &Grasp::Free, 1).expect("valid")),
            controller: Controller::new(&drive),
            outputs: Outputs::Off,
        };
        bench.run(Setpoint::MeasureOffset, 0.3, |_, _, _| ());
        bench
    }

    /// Runs, and shows every sample's current, the mean of the true one over the same time, and what the bridge did.
    fn run(&mut self, setpoint: Setpoint, seconds: f64, mut see: impl FnMut(f64, f64, Drive)) {
        let mut true_a = Vec::new();
        for _ in 0..(seconds / PERIOD_S) as u64 {
            let inputs = self.board.inputs();
            true_a.push(self.board.plant.truth().motor_current_a);
            let outputs = self.controller.step(&inputs, &Demand::from(setpoint));
            self.board.period(self.outputs);
            self.outputs = outputs;
            if let Some(sample) = self.controller.sample() {
                let mean_a = true_a.iter().sum::<f64>() / true_a.len() as f64;
                see(f64::from(sample.current_a), mean_a, sample.drive);
                true_a.clear();
            }
        }
        assert_eq!(self.controller.status().fault, None);
    }
}

fn speed(rad_per_s: f32) -> Setpoint {
    Setpoint::Speed {
        counts_per_s: P70::DRIVE.drivetrain.counts_per_motor_rev
            * P70::DRIVE.drivetrain.reduction
            * rad_per_s
            / core::f32::consts::TAU,
        current_limit_a: 0.12,
    }
}

/// Read and true current, milliampere, of every sample after the first 10 ms.
fn after_a_run(parameters: &Parameters, setpoint: Setpoint) -> Vec<(f64, f64)> {
    let mut bench = Bench::new(parameters);
    bench.run(speed(0.6), 0.8, |_, _, _| ());
    let mut read = Vec::new();
    bench.run(setpoint, 0.06, |read_a, true_a, _| {
        read.push((1e3 * read_a, 1e3 * true_a));
    });
    read.split_off(10)
}

#[test]
fn an_opposing_current_is_read_with_its_sign_and_held() {
    for asked_ma in [-10.0f32, -20.0, -40.0, -80.0] {
        let read = after_a_run(&heavy(), Setpoint::Current { a: 1e-3 * asked_ma });
        let worst = read.iter().map(|(read, truth)| (read - truth).abs());
        let worst = worst.fold(0.0, f64::max);
        let mean = read.iter().map(|(_, truth)| truth).sum::<f64>() / read.len() as f64;
        println!("{asked_ma} mA asked, {mean:.2} mA flow, read within {worst:.2} mA");
        assert!(
            worst < 0.8 + 0.02 * f64::from(-asked_ma),
            "{asked_ma}: {read:?}"
        );
        assert!(
            (mean / f64::from(asked_ma) - 1.0).abs() < 0.05,
            "{asked_ma}: {mean}"
        );
    }
}

/// Four times the noise that the worlds have: no sample of a steady motion may turn its sign.
#[test]
fn noise_does_not_turn_the_sign() {
    let mut parameters = heavy();
    parameters.sense.noise_rms_a = 2e-3;
    let mut bench = Bench::new(&parameters);
    bench.run(speed(0.3), 0.8, |_, _, _| ());
    let mut read = Vec::new();
    bench.run(speed(0.3), 2.0, |read_a, true_a, _| {
        read.push((1e3 * read_a, 1e3 * true_a));
    });
    assert!(read.iter().all(|(_, truth)| *truth > 4.0), "{read:?}");
    let turned = read.iter().filter(|(read, _)| *read < 0.0).count();
    assert_eq!(turned, 0, "{read:?}");
}

#[test]
fn a_braking_current_has_the_sign_of_its_torque() {
    let read = after_a_run(&heavy(), Setpoint::Brake);
    assert!(read.iter().all(|(_, truth)| *truth < -50.0), "{read:?}");
    for (read, truth) in read {
        assert!((read - truth).abs() < 1.0, "{read} {truth}");
    }
}

/// The first milliseconds, in which the integral has not yet made up for anything.
#[test]
fn dead_time_does_not_keep_the_current_waiting() {
    for asked_ma in [-20.0f32, 10.0, 20.0] {
        let mut parameters = heavy();
        parameters.bridge.dead_time_s = 300e-9;
        let mut bench = Bench::new(&parameters);
        bench.board.plant.faults.rotor_locked = true;
        let mut first = Vec::new();
        bench.run(
            Setpoint::Current { a: 1e-3 * asked_ma },
            5e-3,
            |_, true_a, _| {
                first.push(1e3 * true_a);
            },
        );
        println!("{asked_ma} mA asked: {first:.2?}");
        let third = first[2];
        assert!(
            (third - f64::from(asked_ma)).abs() < 1.5,
            "{asked_ma}: {first:?}"
        );
    }
}

/// What flows then has the sign of the voltage that the motor induces, and says nothing of the load.
#[test]
fn a_motor_that_coasts_or_brakes_is_not_driven() {
    fn check<S: Scene>(scene: &str) {
        for setpoint in [Setpoint::Off, Setpoint::Brake] {
            let mut bench = Bench::of::<S>(&heavy_of(scene));
            let mut driven = Vec::new();
            bench.run(speed(0.6), 0.8, |_, _, drive| driven.push(drive));
            assert!(driven.ends_with(&[Drive::Closing; 100]), "{scene}");
            let from = bench.controller.status().position_counts;
            let mut after = Vec::new();
            bench.run(setpoint, 0.02, |_, _, drive| after.push(drive));
            let way = bench.controller.status().position_counts - from;
            assert!(way > 100, "{scene}: the rotor turns on, {way} counts");
            // The first sample may have begun before.
            assert!(
                after[1..].iter().all(|drive| *drive == Drive::Idle),
                "{scene} {setpoint:?}: {after:?}"
            );
        }
    }
    check::<P70>("p70");
    check::<P70Shunt>("p70-shunt");
}
