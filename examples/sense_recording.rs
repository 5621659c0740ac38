//! The sensor on a recording: `cargo run --example sense_recording -- FREE.csv GRASP.csv`.
//!
//! FREE.csv is a free closing and opening of the finger, GRASP.csv a closing on an object; each has a head with at least the
//! columns `time_s`, `encoder_counts` (from the opening stop) and `current_a` (closing positive), a row a millisecond. The
//! drivetrain below is that of the prototype: yours has other numbers. (`cargo xtask replay` does more: it resamples,
//! finds the free closing by itself and reads the drivetrain from a scene.)

use std::error::Error;

use palpate::finger::{Assembly, Finger, Levers, Linkage, Mechanics, Parameters, Springless};
use palpate::sensing::{Calibration, Directive, Drive, Drivetrain, Sample, Sensor, Settings};

type Prototype = Finger<2, Linkage<1>, Springless>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [free, grasp] = arguments.as_slice() else {
        return Err("usage: sense_recording FREE.csv GRASP.csv".into());
    };
    let finger = Prototype::constant(
        Parameters {
            lengths_m: [0.090, 0.070],
            stiffness_nm_per_rad: [0.0, 0.05],
            rest_rad: [0.0, 0.0],
            range_rad: [[-0.5, 2.6], [0.0, 2.0]],
        },
        [Levers {
            driving_m: 0.060,
            coupler_m: 0.104,
            driven_m: 0.030,
            offset_rad: 120.0_f32.to_radians(),
            assembly: Assembly::Clockwise,
        }],
    )?;
    let mut sensor: Sensor<Prototype> = Sensor::new(
        finger,
        drivetrain(&finger),
        Settings::default(),
        UNCALIBRATED,
    );
    sensor.direct(Directive::RecordFriction);
    run(&mut sensor, &read(free)?);
    sensor.direct(Directive::Watch);
    run(&mut sensor, &read(grasp)?);
    Ok(())
}

fn run(sensor: &mut Sensor<Prototype>, samples: &[Sample]) {
    for sample in samples {
        if let Some(event) = sensor.update(sample) {
            println!("{:9.3} s  {event:?}", sample.time_us as f64 * 1e-6);
        }
    }
    // The end of the motion: what was going on is judged as it stands.
    sensor.direct(Directive::Rest);
    if let Some(last) = samples.last()
        && let Some(event) = sensor.update(last)
    {
        println!("{:9.3} s  {event:?}", last.time_us as f64 * 1e-6);
    }
}

/// Nothing was calibrated: the torque factor is known to 12 %, the cable (1.2 N m/rad) to 30 %.
const UNCALIBRATED: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.115,
    cable_rad_per_nm: 1.0 / 1.2,
    cable_sigma_rad_per_nm: 0.25,
    correlation: 0.0,
    stiffening_per_nm: 0.0,
    stiffening_sigma_per_nm: 0.3,
    contacts: 0,
    presses: 0,
};

/// A motor of 8.9 mN m/A with 1024 counts a turn behind a gearhead of 64:1 and a worm of 20:1.
fn drivetrain(finger: &Prototype) -> Drivetrain {
    let reduction = 64.0 * 20.0;
    let rad_per_count = core::f32::consts::TAU / (1024.0 * reduction);
    Drivetrain {
        rad_per_count,
        counts_per_turn: 1024,
        counts_per_worm_turn: 64 * 1024,
        creep: 0.05,
        creep_s: 5.0,
        opening_stop_rad: finger.input_angle_rad(&finger.rest()),
        torque_per_ampere_nm: 8.9e-3 * reduction,
        efficiency: 0.33,
        inertia_kg_m2: 1e-8 * reduction * reduction,
        inertia_share: 0.115,
        viscous_nm_s_per_rad: 2.3e-8 * reduction * reduction,
        efficiency_per_speed: 0.07,
        backlash_rad: 1456.0 * rad_per_count,
    }
}

/// The rows of a file as samples.
fn read(path: &str) -> Result<Vec<Sample>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        let found = head.iter().position(|column| column.trim() == name);
        found.ok_or_else(|| format!("{path}: there is no column {name}"))
    };
    let columns = [
        column("time_s")?,
        column("encoder_counts")?,
        column("current_a")?,
    ];
    let mut samples: Vec<Sample> = Vec::new();
    for (number, line) in (2..).zip(lines) {
        let cells: Vec<&str> = line.split(',').collect();
        let value = |at: usize| -> Result<f64, String> {
            let cell = cells.get(at).map(|cell| cell.trim().parse());
            cell.and_then(Result::ok)
                .ok_or_else(|| format!("{path}:{number}: a number is expected"))
        };
        let [time_s, counts, current_a] =
            [value(columns[0])?, value(columns[1])?, value(columns[2])?];
        let position_counts = counts as i32;
        // Ten milliseconds back: less is within the encoder's steps.
        let before = samples
            .len()
            .checked_sub(10)
            .map(|at| samples[at].position_counts);
        let moved = before.map_or(0, |before| position_counts.wrapping_sub(before));
        samples.push(Sample {
            time_us: (1e6 * time_s) as u64,
            position_counts,
            current_a: current_a as f32,
            drive: match moved {
                20.. => Drive::Closing,
                ..=-20 => Drive::Opening,
                _ => Drive::Idle,
            },
            joint: (),
        });
    }
    Ok(samples)
}
