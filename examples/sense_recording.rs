//! The sensor on a recording: `cargo run --example sense_recording -- FREE.csv GRASP.csv`.
//!
//! FREE.csv is a free closing and opening of the finger, GRASP.csv a closing on an object; each has a head with at least the
//! columns `time_s`, `encoder_counts` (from the opening stop) and `current_a` (closing positive), a row a millisecond. The
//! drivetrain in `prototype/mod.rs` is that of the paper's finger: yours has other numbers. (`cargo xtask replay` does more: it
//! resamples, finds the free closing by itself and reads the drivetrain from a scene.)

use std::error::Error;

mod prototype;

use palpate::sensing::{Directive, Drive, Sample, Sensor, Settings};
use prototype::{Prototype, UNCALIBRATED, drivetrain};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [free, grasp] = arguments.as_slice() else {
        return Err("usage: sense_recording FREE.csv GRASP.csv".into());
    };
    let finger = prototype::finger()?;
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
            emf_v: f32::NAN,
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
