//! Two fingers close on one cylinder between them, and what each of them feels gives its centre and radius:
//! `cargo run --profile host -p palpate-simulation --example two_fingers`.
//!
//! The second finger is the mirror image of the first, across a line parallel to phalanx 1 at rest. Each tells where along
//! its distal phalanx the cylinder lies, and its posture where the phalanx is: four equations for three unknowns.

use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::{Error, Outcome, Simulation};

/// Distance between the fingers' bases, metre.
const APART_M: f64 = 0.18;
/// How well a posture at contact is known, radian: onset, backlash and cable.
const POSTURE_SIGMA_RAD: f64 = 8e-3;

/// An equation a . (x, y, r) = b with a deviation.
type Equation = ([f64; 3], f64, f64);

/// What a finger's events say about the cylinder, in that finger's own frame.
fn equations(outcome: &Outcome) -> Option<[Equation; 2]> {
    let finger = P70::MECHANISM;
    let half_m = f64::from(P70::settings().half_thickness_m);
    let theta_a = outcome.events.iter().find_map(|(_, event)| match event {
        Event::Touch { theta_a_rad, .. } => Some(*theta_a_rad),
        _ => None,
    })?;
    let (phalanx, k_m, sigma_m) = outcome.events.iter().rev().find_map(|(_, e)| match *e {
        Event::Located {
            phalanx,
            k_m,
            sigma_m,
            ..
        } => Some((phalanx, k_m, sigma_m)),
        _ => None,
    })?;
    let free = finger.free_at_angle(theta_a, &finger.rest())?;
    let (mut joint, mut angle) = ([0.0, 0.0], 0.0);
    for j in 1..=phalanx {
        angle += f64::from(finger.joint_rad(&free.configuration, j)?);
        if j < phalanx {
            let length = f64::from(finger.phalanx_length_m(j)?);
            joint = [
                joint[0] + length * angle.cos(),
                joint[1] + length * angle.sin(),
            ];
        }
    }
    let (sin, cos) = angle.sin_cos();
    // The centre lies at k along the phalanx, and a radius and half the phalanx's thickness before it.
    let along = joint[0] * cos + joint[1] * sin + f64::from(k_m);
    let before = -joint[0] * sin + joint[1] * cos + half_m;
    let arm_m = f64::from(k_m) + f64::from(finger.phalanx_length_m(1)?);
    Some([
        ([cos, sin, 0.0], along, f64::from(sigma_m)),
        ([-sin, cos, -1.0], before, POSTURE_SIGMA_RAD * arm_m),
    ])
}

/// Least squares: the unknowns and their deviations, by Cramer's rule.
fn solve(equations: &[Equation]) -> ([f64; 3], [f64; 3]) {
    let (mut n, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (a, b, sigma) in equations {
        for i in 0..3 {
            for j in 0..3 {
                n[i][j] += a[i] * a[j] / (sigma * sigma);
            }
            right[i] += a[i] * b / (sigma * sigma);
        }
    }
    let minor = |i: usize, j: usize| {
        let ([i1, i2], [j1, j2]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
        n[i1][j1] * n[i2][j2] - n[i1][j2] * n[i2][j1]
    };
    let determinant: f64 = (0..3).map(|j| n[0][j] * minor(0, j)).sum();
    let inverse = |i: usize, j: usize| minor(j, i) / determinant;
    let found = core::array::from_fn(|i| (0..3).map(|j| inverse(i, j) * right[j]).sum());
    (found, core::array::from_fn(|i| inverse(i, i).sqrt()))
}

fn main() -> Result<(), Error> {
    let mut fingers = Vec::new();
    for seed in [1, 2] {
        let mut finger = Simulation::<P70>::new(&Parameters::default(), seed)?;
        finger.prepare()?;
        fingers.push(finger);
    }
    for [x_m, y_m, diameter_m] in [
        [0.102, 0.085, 0.040],
        [0.110, 0.095, 0.030],
        [0.105, 0.090, 0.050],
    ] {
        let mut told = Vec::new();
        for (index, finger) in fingers.iter_mut().enumerate() {
            let is_mirrored = index == 1;
            let y_m = if is_mirrored { APART_M - y_m } else { y_m };
            let outcome = finger.close(&Grasp::At {
                origin_m: [x_m, y_m],
                angle_rad: 0.0,
                shape: Shape::Cylinder { diameter_m },
            })?;
            finger.open()?;
            for (a, b, sigma) in equations(&outcome).into_iter().flatten() {
                // Back from the mirror: y' = apart - y.
                let back = ([a[0], -a[1], a[2]], b - a[1] * APART_M, sigma);
                told.push(if is_mirrored { back } else { (a, b, sigma) });
            }
        }
        println!(
            "cylinder of {:.0} mm at ({:.1}, {:.1}) mm",
            1e3 * diameter_m,
            1e3 * x_m,
            1e3 * y_m
        );
        if told.len() < 4 {
            println!("  a finger did not locate it: {} equations", told.len());
            continue;
        }
        let ([x, y, r], [sx, sy, sr]) = solve(&told);
        println!(
            "  felt: centre ({:.1} +- {:.1}, {:.1} +- {:.1}) mm, diameter {:.1} +- {:.1} mm",
            1e3 * x,
            1e3 * sx,
            1e3 * y,
            1e3 * sy,
            2e3 * r,
            2e3 * sr
        );
    }
    Ok(())
}
