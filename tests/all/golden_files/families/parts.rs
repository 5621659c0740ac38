//! fourbar and static_forces: one stage of a linkage, and the balance of torques, each by itself.

use super::super::fingers::{assembly, numbered};
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Row, Table};
use super::{NATURAL, number, relative};
use palpate::finger::{
    Finger, FourBar, Levers, Parameters, Tendon, Transmission, TransmissionFactors,
};
use palpate::numeric::Rotation;

/// fourbar: one stage by itself.
pub fn four_bar(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
    for name in [
        "F, rad",
        "h, over g",
        "x, over 1",
        "dx, over 1",
        "d2x, over 1",
    ] {
        report.quantity(name, Limit::max(NATURAL));
    }
    for row in table.rows() {
        report.rows += 1;
        let line = row.line;
        let levers = Levers {
            driving_m: row.f32("a")?,
            coupler_m: row.f32("b")?,
            driven_m: row.f32("c")?,
            offset_rad: row.f32("psi")?,
            assembly: assembly(&row, "mode")?,
        };
        let (ground, v) = (row.f32("g")?, row.f32("v")?);
        let built = FourBar::build(1, ground, levers, [v, v]);
        let closes = match row.text("status")? {
            "ok" => true,
            "no_closure" => false,
            other => {
                return Err(row.error(format!("status is {other:?}, neither ok nor no_closure")));
            }
        };
        let stage = match (built, closes) {
            (Ok(stage), true) => stage,
            (Err(_), false) => continue,
            (Ok(_), false) => {
                report.misclassify(line, "accepted, does not close".to_owned());
                continue;
            }
            (Err(error), true) => {
                report.misclassify(line, format!("rejected, closes: {error}"));
                continue;
            }
        };
        let turn = Rotation::by(v);
        let ratio = stage.ratio(turn);
        report.note(
            "F, rad",
            line,
            (f64::from(stage.lever(turn).rad()) - row.f64("F")?).abs(),
        );
        report.note(
            "h, over g",
            line,
            relative(
                number(stage.intersection_m(turn)),
                row.f64("h")?,
                ground.into(),
            ),
        );
        report.note(
            "x, over 1",
            line,
            relative(number(ratio.map(|r| r.first)), row.f64("x")?, 1.0),
        );
        report.note(
            "dx, over 1",
            line,
            relative(number(ratio.map(|r| r.second)), row.f64("dx")?, 1.0),
        );
        report.note(
            "d2x, over 1",
            line,
            relative(number(ratio.map(|r| r.third)), row.f64("d2x")?, 1.0),
        );
    }
    Ok(())
}

/// static_forces: equivalent torques (5) and contact forces (1), the transmission factors given.
pub fn static_forces(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
    report.quantity("tau, over the largest term", Limit::max(NATURAL));
    report.quantity("f, over the largest term", Limit::max(NATURAL));
    for row in table.rows() {
        report.rows += 1;
        match row.f64("n")? {
            2.0 => forces_of::<2, Tendon<2>>(&row, report, [1.0, 1.0])?,
            3.0 => forces_of::<3, Tendon<3>>(&row, report, [1.0; 4])?,
            other => return Err(row.error(format!("n is {other}, neither 2 nor 3"))),
        }
    }
    Ok(())
}

fn forces_of<const N: usize, T: Transmission<N>>(
    row: &Row<'_>,
    report: &mut FileReport,
    design: T::Design,
) -> Result<(), FileError> {
    let turn = 2.0 * core::f32::consts::PI;
    let parameters = Parameters {
        lengths_m: numbered(row, "l", "")?,
        stiffness_nm_per_rad: numbered(row, "K", "")?,
        rest_rad: numbered(row, "th", "0")?,
        range_rad: [[-turn, turn]; N],
    };
    let complain = |error: palpate::finger::ConfigError| row.error(error.to_string());
    let built = Finger::<N, T>::new(parameters, design).map_err(complain)?;
    let at = built
        .configuration(numbered(row, "th", "")?)
        .map_err(complain)?;
    let gear = TransmissionFactors {
        x: numbered(row, "x", "")?,
        w: [[0.0; N]; N],
    };
    let (k, torque) = (numbered::<N>(row, "k", "")?, row.f32("T_a")?);
    let tau = built.equivalent_torques_nm(&gear, &at, torque);
    let force = tau.and_then(|tau| built.contact_forces_n(&at, k, tau));
    let arms = built.arms_m(&at, k);
    for i in 0..N {
        let spring = parameters.stiffness_nm_per_rad[i] * (at.rad()[i] - parameters.rest_rad[i]);
        let scale = f64::from(gear.x[i] * torque)
            .abs()
            .max(f64::from(spring).abs());
        let want = row.f64(&format!("tau{}", i + 1))?;
        report.note(
            "tau, over the largest term",
            row.line,
            relative(number(tau.map(|t| t[i])), want, scale),
        );
        // A force is a sum of torques over arms: the largest of them is its natural scale.
        let mut scale = 0.0f64;
        for (j, arm) in arms[i].into_iter().enumerate().skip(i + 1) {
            scale = scale.max((f64::from(arm) * row.f64(&format!("f{}", j + 1))?).abs());
        }
        scale = scale.max(want.abs()) / f64::from(k[i]);
        let want = row.f64(&format!("f{}", i + 1))?;
        report.note(
            "f, over the largest term",
            row.line,
            relative(number(force.map(|f| f[i])), want, scale),
        );
    }
    Ok(())
}
