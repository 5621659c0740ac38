//! A finger with a motor at every joint feels where it touches: each motor in turn pushes a little harder, and how far its
//! joint gives way tells the place: `cargo run --example actuated_finger`.
//!
//! The finger is simulated here from positions and energy alone, with nothing of the library.

use palpate::finger::{ActuatedFinger, Parameters};

const LENGTHS_M: [f64; 3] = [0.060, 0.045, 0.030];
const STIFFNESS_NM_PER_RAD: [f64; 3] = [0.4, 0.3, 0.2];
/// By how much each motor's torque rises, newton metre, and how well each encoder reads, radian.
const STEP_NM: f64 = 0.010;
const READING_SIGMA_RAD: f64 = 0.2e-3;

/// Where a point of the object lies before the palm side of a phalanx, metre.
fn gap(joints: [f64; 3], phalanx: usize, [x, y]: [f64; 2]) -> f64 {
    let (mut at, mut angle) = ([0.0, 0.0], 0.0);
    for j in 0..phalanx {
        angle += joints[j];
        if j + 1 < phalanx {
            at = [
                at[0] + LENGTHS_M[j] * angle.cos(),
                at[1] + LENGTHS_M[j] * angle.sin(),
            ];
        }
    }
    (y - at[1]) * angle.cos() - (x - at[0]) * angle.sin()
}

/// A place on a phalanx.
fn point(joints: [f64; 3], phalanx: usize, k_m: f64) -> [f64; 2] {
    let (mut at, mut angle) = ([0.0, 0.0], 0.0);
    for j in 0..phalanx {
        angle += joints[j];
        let along = if j + 1 < phalanx { LENGTHS_M[j] } else { k_m };
        at = [at[0] + along * angle.cos(), at[1] + along * angle.sin()];
    }
    at
}

/// Joint angles under torques with a phalanx on a fixed point: springs against a very stiff object, by Newton's method.
fn held(torques: [f64; 3], from: [f64; 3], phalanx: usize, object: [f64; 2]) -> [f64; 3] {
    const OBJECT_N_PER_M: f64 = 1e8;
    let mut joints = from;
    for _ in 0..50 {
        let here = gap(joints, phalanx, object);
        let slope: [f64; 3] = core::array::from_fn(|j| {
            let mut beside = joints;
            beside[j] += 1e-7;
            (gap(beside, phalanx, object) - here) / 1e-7
        });
        // (K + k s s^T) step = residual, by Sherman and Morrison.
        let residual: [f64; 3] = core::array::from_fn(|j| {
            torques[j] - STIFFNESS_NM_PER_RAD[j] * joints[j] - OBJECT_N_PER_M * here * slope[j]
        });
        let soft =
            |v: [f64; 3]| -> [f64; 3] { core::array::from_fn(|j| v[j] / STIFFNESS_NM_PER_RAD[j]) };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let share = dot(slope, soft(residual)) / (1.0 / OBJECT_N_PER_M + dot(slope, soft(slope)));
        joints = core::array::from_fn(|j| joints[j] + soft(residual)[j] - share * soft(slope)[j]);
    }
    joints
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let finger = ActuatedFinger::new(Parameters {
        lengths_m: LENGTHS_M.map(|l| l as f32),
        stiffness_nm_per_rad: STIFFNESS_NM_PER_RAD.map(|k| k as f32),
        rest_rad: [0.0; 3],
        range_rad: [[-0.5, 2.0]; 3],
    })?;
    let torques = [0.24, 0.15, 0.08];
    let free: [f64; 3] = core::array::from_fn(|j| torques[j] / STIFFNESS_NM_PER_RAD[j]);
    let at = finger
        .free_at_torques(torques.map(|t| t as f32))
        .ok_or("no posture")?;
    // Encoder noise that is the same each time: a few fixed deviates.
    let mut noise = [0.3, -0.9, 1.1, -0.4, 0.7, -1.2, 0.1, 0.8, -0.6]
        .into_iter()
        .cycle();

    for (phalanx, k_mm) in [(1, 40.0), (2, 15.0), (2, 35.0), (3, 12.0), (3, 24.0)] {
        let object = point(free, phalanx, 1e-3 * k_mm);
        let mut compliance = [0.0f32; 3];
        for (motor, compliance) in compliance.iter_mut().enumerate() {
            let mut pushed = torques;
            pushed[motor] += STEP_NM;
            let turned = held(pushed, free, phalanx, object)[motor] - free[motor];
            let reading = turned + READING_SIGMA_RAD * noise.next().unwrap_or(0.0);
            *compliance = (reading / STEP_NM) as f32;
        }
        let sigma = (READING_SIGMA_RAD / STEP_NM) as f32;
        let place = finger
            .locate(&at, compliance, [sigma; 3])
            .ok_or("no contact felt")?;
        match place.k_m {
            Some(k_m) => println!(
                "phalanx {phalanx} at {k_mm:.0} mm: felt on phalanx {} at {:.1} mm, deviation {:.1} mm",
                place.phalanx,
                1e3 * k_m,
                1e3 * place.sigma_m
            ),
            None => println!(
                "phalanx {phalanx} at {k_mm:.0} mm: felt on phalanx {}, anywhere on it",
                place.phalanx
            ),
        }
    }
    Ok(())
}
