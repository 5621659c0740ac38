//! preshape_*: the free finger.

use super::super::fingers::{FromRow, finger};
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Table};
use super::{NATURAL, number, relative};
use palpate::finger::{Configuration, Finger, Free, Mechanics};

/// preshape_*: the free finger (6), (7).
pub fn preshape<const N: usize, T: FromRow<N>>(
    table: &Table,
    report: &mut FileReport,
) -> Result<(), FileError>
where
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    for name in [
        "joint angles, rad",
        "dtheta_a, rad",
        "K_a, relative",
        "K_tangent, relative",
        "x, over 1",
    ] {
        report.quantity(name, Limit::max(NATURAL));
    }
    report.quantity(
        "joint angles from the input angle, rad",
        Limit::max(NATURAL),
    );
    for row in table.rows() {
        report.rows += 1;
        let line = row.line;
        let built = finger::<N, T>(&row)?;
        let torque_nm = row.f32("T_a")?;
        let Some(at) = built.free_at_torque(torque_nm, &built.rest()) else {
            report.note("joint angles, rad", line, f64::NAN);
            continue;
        };
        let free = Free {
            configuration: at,
            torque_nm,
        };
        let gear = built.transmission().factors(&at);
        let turned =
            f64::from(built.input_angle_rad(&at)) - f64::from(built.input_angle_rad(&built.rest()));
        report.note("dtheta_a, rad", line, (turned - row.f64("dtheta_a")?).abs());
        report.note(
            "K_a, relative",
            line,
            relative(number(built.expected_k_a(&free)), row.f64("K_a")?, 0.0),
        );
        let tangent = 1.0 / number(built.free_compliance(&at, torque_nm));
        report.note(
            "K_tangent, relative",
            line,
            relative(tangent, row.f64("K_tangent")?, 0.0),
        );
        let back = built.free_at_angle(built.input_angle_rad(&at), &built.rest());
        for joint in 1..=N {
            let want = row.f64(&format!("th{joint}"))?;
            let angle = |at: &Configuration<N>| number(built.joint_rad(at, joint as u8));
            report.note("joint angles, rad", line, (angle(&at) - want).abs());
            let error = back.map_or(f64::NAN, |back| (angle(&back.configuration) - want).abs());
            report.note("joint angles from the input angle, rad", line, error);
            if joint > 1 {
                let x = gear.and_then(|gear| gear.x.get(joint - 1).copied());
                report.note(
                    "x, over 1",
                    line,
                    relative(number(x), row.f64(&format!("x{joint}"))?, 1.0),
                );
            }
        }
    }
    Ok(())
}
