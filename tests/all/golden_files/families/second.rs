//! second_* and actuated_*: a second contact after the first, and a motor at every joint.

use super::super::fingers::{FromRow, finger, numbered, posture};
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Table};
use super::{NATURAL, number};
use palpate::finger::{ActuatedFinger, Contact, Finger, Mechanics, Parameters};

const PLACES: [&str; 2] = [
    "second contact by bisection, % of l",
    "second contact in closed form, % of l",
];

/// second_*: posture, force and compliance at a second contact, and its place.
pub fn second<T: FromRow<3>>(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
    report.quantity("C after the second, over that before", Limit::max(NATURAL));
    report.quantity("C before the second, relative", Limit::max(NATURAL));
    report.quantity("force of the first, relative", Limit::max(NATURAL));
    for name in PLACES {
        report.quantity(name, Limit::max(0.05));
    }
    for row in table.rows() {
        report.rows += 1;
        let line = row.line;
        let built: Finger<3, T> = finger(&row)?;
        let Some((at, torque)) = posture(&row, &built, "T_c")? else {
            report.misclassify(line, "no posture found".to_owned());
            continue;
        };
        let first = Contact {
            phalanx: row.f64("phal")? as u8,
            k_m: row.f32("k")?,
            radius_m: 0.0,
        };
        let pressed = built.path(&at, torque, first).and_then(|mut path| {
            built.follow(&mut path, row.f32("dT").ok()?)?;
            built.pressed(&path)
        });
        let Some(pressed) = pressed else {
            report.misclassify(line, "no posture after the first contact".to_owned());
            continue;
        };
        let (phalanx, k) = (row.f64("phal_b")? as u8, row.f32("k_b")?);
        let (before, after) = (row.f64("C_first")?, row.f64("C_second")?);
        let force = row.f64("f")?;
        let error = (f64::from(pressed.force_n) - force).abs() / force;
        report.note("force of the first, relative", line, error);
        let alone = pressed.compliance_rad_per_nm();
        let error = (f64::from(alone) - before).abs() / before;
        report.note("C before the second, relative", line, error);
        let got = number(pressed.second_compliance(phalanx, k));
        let error = (got - after).abs() / before;
        report.note("C after the second, over that before", line, error);

        let length = f64::from(built.parameters().lengths_m[usize::from(phalanx) - 1]);
        let observable = matches!((first.phalanx, phalanx), (1 | 2, 3) | (3, 2));
        let presses = row.f64("df_b_dT")? > 0.0;
        if pressed.second_presses(phalanx, k) != presses {
            report.misclassify(line, format!("presses: {}, reference {presses}", !presses));
        }
        let should = observable && presses;
        let measured = row.f32("C_second")?;
        let answers = [
            pressed.second_places(measured),
            pressed.second_places_closed(measured),
        ];
        for (name, places) in PLACES.into_iter().zip(answers) {
            let nearest = places
                .iter()
                .filter(|place| place.phalanx == phalanx)
                .map(|place| (f64::from(place.k_m) - f64::from(k)).abs() / length * 100.0)
                .fold(f64::INFINITY, f64::min);
            if should {
                report.note(name, line, nearest);
            } else if nearest < 0.05 {
                report.misclassify(line, format!("{name}: found where nothing presses"));
            }
        }
    }
    Ok(())
}

/// actuated_*: each actuator's compliance, and the place from all of them.
pub fn actuated(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
    report.quantity("C of each actuator, over 1/K", Limit::max(1e-6));
    report.quantity("place from all actuators, % of l", Limit::max(0.01));
    for row in table.rows() {
        report.rows += 1;
        let line = row.line;
        let springs: [f32; 3] = numbered(&row, "K", "")?;
        let built = ActuatedFinger::new(Parameters {
            lengths_m: numbered(&row, "l", "")?,
            stiffness_nm_per_rad: springs,
            rest_rad: numbered(&row, "th", "0")?,
            range_rad: [[-3.0, 3.0]; 3],
        })
        .map_err(|error| row.error(error.to_string()))?;
        let (phalanx, k) = (row.f64("phal")? as u8, row.f32("k")?);
        let felt = built
            .free_at_torques(numbered(&row, "t", "")?)
            .and_then(|at| Some((at, built.contact_compliance(&at, phalanx, k)?)));
        let Some((at, felt)) = felt else {
            report.misclassify(line, "no posture or contact".to_owned());
            continue;
        };
        for (joint, (c, spring)) in (1..).zip(felt.into_iter().zip(springs)) {
            let want = row.f64(&format!("C{joint}"))?;
            let error = (f64::from(c) - want).abs() * f64::from(spring);
            report.note("C of each actuator, over 1/K", line, error);
        }
        let measured: [f32; 3] = numbered(&row, "C", "")?;
        let Some(place) = built.locate(&at, measured, springs.map(|spring| 1e-5 / spring)) else {
            report.misclassify(line, "no contact found".to_owned());
            continue;
        };
        if place.phalanx != phalanx || place.k_m.is_some() != (phalanx > 1) {
            report.misclassify(line, format!("{place:?}, reference phalanx {phalanx}"));
        } else if let Some(found) = place.k_m {
            let length = f64::from(built.parameters().lengths_m[usize::from(phalanx) - 1]);
            let error = (f64::from(found) - f64::from(k)).abs() / length * 100.0;
            report.note("place from all actuators, % of l", line, error);
        }
    }
    Ok(())
}
