//! contact_*: the path after a finite torque step, and the place from that step.

use super::super::fingers::{FromRow, finger, posture};
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Row, Table};
use super::{NATURAL, number, relative};
use palpate::finger::{Configuration, Contact, Finger, Mechanics, Path};
use palpate::sensing::location::Rigid;
use palpate::sensing::step;

/// Relative change of an input that tells how much the compliance depends on it.
const NUDGE: f64 = 1e-4;

/// Conditioning floor of a row's compliance: by what share it changes when every input changes by half an ulp.
fn compliance_floor<const N: usize, T: FromRow<N>>(row: &Row<'_>) -> Result<f64, FileError>
where
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let phalanx = row.f64("phal")? as u8;
    let logarithm = |row: &Row<'_>| -> Option<f64> {
        let built = finger::<N, T>(row).ok()?;
        let (at, torque) = posture(row, &built, "T_c").ok()??;
        built
            .contact_compliance(&at, torque, phalanx, row.f32("k").ok()?)
            .map(|c| f64::from(c).ln())
    };
    let mut change = 0.0;
    for column in row
        .columns_to("T_c")
        .iter()
        .map(String::as_str)
        .chain(["k"])
        .filter(|c| !c.starts_with("mode"))
    {
        let both = (
            logarithm(&row.nudged(column, NUDGE)),
            logarithm(&row.nudged(column, -NUDGE)),
        );
        if let (Some(up), Some(down)) = both {
            change += (up - down).abs() / (2.0 * NUDGE);
        }
    }
    Ok(change * 2.0f64.powi(-24))
}

/// contact_*: the path after a finite torque step, and the place from that step.
pub fn contact<const N: usize, T: FromRow<N>>(
    table: &Table,
    report: &mut FileReport,
) -> Result<(), FileError>
where
    Finger<N, T>: Mechanics<Configuration = Configuration<N>, Path = Path<N>>,
{
    report.quantity("dtheta_a in every row, relative", Limit::default());
    report.quantity("dtheta_a, relative", Limit::max(1e-5));
    report.quantity(
        "dtheta_a ill-conditioned, over its allowance",
        Limit::max(1.0),
    );
    report.quantity("joint angles after, rad", Limit::max(NATURAL));
    report.quantity("k after, over l", Limit::max(NATURAL));
    report.quantity("force, relative", Limit::max(NATURAL));
    report.quantity(
        "k from the step, % of l",
        Limit::max(if N == 2 { 1e-3 } else { 0.05 }),
    );
    for row in table.rows() {
        report.rows += 1;
        let line = row.line;
        let built = finger::<N, T>(&row)?;
        let Some((at, torque)) = posture(&row, &built, "T_c")? else {
            report.misclassify(line, "no posture found".to_owned());
            continue;
        };
        let phalanx = row.f64("phal")? as u8;
        let (k_m, more) = (row.f32("k")?, row.f32("dT")?);
        let length = f64::from(built.phalanx_length_m(phalanx).unwrap_or(f32::NAN));
        let path = built.path(
            &at,
            torque,
            Contact {
                phalanx,
                k_m,
                radius_m: 0.0,
            },
        );
        let reach = |share: f32| path.and_then(|mut path| built.follow(&mut path, share * more));
        let (half, full) = (reach(0.5), reach(1.0));
        // At e_2 the rotation vanishes while the joints move: there half an ulp of an input changes it, relatively, by
        // more than the limit. Where four times that floor exceeds the limit, the floor judges.
        let allowance = 4.0 * compliance_floor::<N, T>(&row)?;
        for (point, column) in [(full, "dtheta_a"), (half, "dtheta_a_half")] {
            let error = relative(number(point.map(|p| p.rotation_rad)), row.f64(column)?, 0.0);
            report.note("dtheta_a in every row, relative", line, error);
            if allowance > 1e-5 {
                report.note(
                    "dtheta_a ill-conditioned, over its allowance",
                    line,
                    error / allowance,
                );
            } else {
                report.note("dtheta_a, relative", line, error);
            }
        }
        let mut end = path;
        let changes = end.as_mut().and_then(|path| {
            built.follow(path, more)?;
            Some(path.joint_changes_rad())
        });
        for joint in 1..=N {
            let was = at.rad().get(joint - 1).copied().map_or(f64::NAN, f64::from);
            let change = number(changes.and_then(|changes| changes.get(joint - 1).copied()));
            let want = row.f64(&format!("th{joint}_after"))?;
            report.note("joint angles after, rad", line, (was + change - want).abs());
        }
        let after = (number(full.map(|p| p.k_now_m)) - row.f64("k_after")?).abs() / length;
        report.note("k after, over l", line, after);
        report.note(
            "force, relative",
            line,
            relative(number(full.map(|p| p.force_n)), row.f64("f")?, 0.0),
        );
        if phalanx > 1 {
            let step = step::Measured {
                rise_nm: more,
                rotation_rad: row.f32("dtheta_a")?,
                radius_m: 0.0,
            };
            let places = step::places(&built, &at, torque, &step, &Rigid, None);
            let best = places
                .iter()
                .filter(|place| place.phalanx == phalanx)
                .map(|place| {
                    (f64::from(place.k_m) - row.f64("k").unwrap_or(f64::NAN)).abs() / length * 100.0
                })
                .fold(f64::NAN, f64::min);
            report.note("k from the step, % of l", line, best);
        }
    }
    Ok(())
}
