//! The back-EMF that the control loop hands to the sensing, against the motor that the plant has. Simulated.

use palpate::drive::demand::{Demand, Setpoint, Status};
use palpate::sample::Drive;
use palpate::scene::{SampleOf, Scene};
use palpate_plant::{Grasp, Plant, World};
use palpate_scenes::P70;
use palpate_simulation::{Board, Machine, SlowLoop};

/// Drawn fingers of each world.
const PLANTS: u64 = 40;
/// What happens until when, millisecond: the offset is measured, the finger closes, it opens twice as fast.
const OFFSET: u64 = 400;
const CLOSING: u64 = 2_000;
const OPENING: u64 = 2_700;
/// A speed is steady this long after it is demanded, millisecond.
const STEADY: u64 = 300;

/// Closes at the sensing's speed, then opens at twice that.
#[derive(Default)]
struct ThereAndBack {
    samples: u64,
    /// Sum of the back-EMF in the direction of motion, and number of samples, closing and opening.
    sums: [(f64, f64); 2],
}

impl SlowLoop for ThereAndBack {
    type Joint = <P70 as Scene>::Joint;

    fn sample(&mut self, sample: &SampleOf<P70>, _: &Status) -> Demand {
        self.samples += 1;
        let (phase, drive, sign) = if self.samples < CLOSING {
            (0, Drive::Closing, 1.0)
        } else {
            (1, Drive::Opening, -1.0)
        };
        let begin = [OFFSET, CLOSING][phase];
        if self.samples > begin + STEADY && sample.drive == drive {
            self.sums[phase].0 += sign * f64::from(sample.emf_v);
            self.sums[phase].1 += 1.0;
        }
        if self.samples < OFFSET {
            return Setpoint::MeasureOffset.into();
        }
        let rad_per_s = [1.0, -2.0][phase] * P70::MOTION.closing_rad_per_s;
        Setpoint::Speed {
            counts_per_s: rad_per_s / P70::drivetrain(&P70::MECHANISM).rad_per_count,
            current_limit_a: 0.1,
        }
        .into()
    }
}

/// What is wrong with the torque constant, as a share of the nominal one, by the back-EMF of one speed and by that of both.
fn errors(world: &World, seed: u64) -> [f64; 2] {
    let parameters = world.of(P70::NAME).expect("valid").randomised(seed);
    let plant = Plant::new(&parameters, &Grasp::Free, seed).expect("a plant");
    let joint = P70::joint_sensor().expect("no sensor");
    let slow = ThereAndBack::default();
    let mut machine = Machine::new(Board::new(plant), &P70::DRIVE, joint, slow).expect("a drive");
    for _ in 0..OPENING {
        machine.until_sample();
    }
    let [closing_v, opening_v] = machine.slow.sums.map(|(sum, count)| {
        assert!(count > 300.0, "{seed}: it does not turn");
        sum / count
    });
    let drivetrain = P70::drivetrain(&P70::MECHANISM);
    let nominal_v = f64::from(drivetrain.torque_per_ampere_nm * P70::MOTION.closing_rad_per_s);
    let true_share = parameters.motor.torque_constant_nm_per_a
        / f64::from(P70::DRIVE.motor.torque_constant_nm_per_a);
    [closing_v, opening_v - closing_v].map(|volt| volt / nominal_v - true_share)
}

#[test]
fn two_speeds_tell_the_torque_constant() {
    for (name, most) in [("ideal", 0.005), ("workshop", 0.01), ("harsh", 0.015)] {
        let world = World::named(name).expect("a named world");
        let all: Vec<[f64; 2]> = (0..PLANTS).map(|seed| errors(&world, seed)).collect();
        let rms = [0, 1].map(|i| {
            let sum: f64 = all.iter().map(|errors| errors[i] * errors[i]).sum();
            (sum / PLANTS as f64).sqrt()
        });
        println!(
            "{name}: off by {:.2} % with one speed, {:.2} % with two",
            100.0 * rms[0],
            100.0 * rms[1]
        );
        // With one speed, what the sensing expects of bridge and resistance: 0.15 V and 11.5 % of 0.6 V, of 3.4 V. The bridge of the
        // ideal world has no dead time, 0.4 V that the current loop makes up for.
        assert!(name == "ideal" || rms[0] < 0.06, "{name}: {all:?}");
        assert!(rms[1] < most, "{name}: {all:?}");
    }
}
