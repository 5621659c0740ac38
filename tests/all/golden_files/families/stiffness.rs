//! kc_*: preshaping, gear and contact stiffness.

use super::super::fingers::{FromRow, finger, posture};
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Row, Table};
use super::{NATURAL, number, relative};
use palpate::finger::{Configuration, Contact, Finger, Mechanics};

/// kc_*: preshaping, gear and K_c (18).
pub fn stiffness<const N: usize, T: FromRow<N>>(
    table: &Table,
    report: &mut FileReport,
) -> Result<(), FileError>
where
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let away = Limit {
        median: Some(5e-7),
        p99: Some(2e-5),
        max: None,
    };
    report.quantity("C away from e_2, relative", away);
    report.quantity("C near e_2, over C_prox", Limit::max(1e-6));
    report.quantity("C_free, relative", Limit::max(NATURAL));
    report.quantity("x, over 1", Limit::max(NATURAL));
    report.quantity("G, over the stiffest spring", Limit::max(NATURAL));
    report.quantity("e_2, relative", Limit::default());
    for row in table.rows() {
        report.rows += 1;
        let line = row.line;
        let built = finger::<N, T>(&row)?;
        let Some((at, torque)) = posture(&row, &built, "T_c")? else {
            report.note("C away from e_2, relative", line, f64::NAN);
            continue;
        };
        let phalanx = row.f64("phal")? as u8;
        let (k, want) = (row.f32("k")?, row.f64("C")?);
        let got = number(built.contact_compliance(&at, torque, phalanx, k));
        let proximal = reference_proximal::<N>(&row)?;
        if want > 1e-3 * proximal {
            report.note("C away from e_2, relative", line, relative(got, want, 0.0));
        } else {
            report.note(
                "C near e_2, over C_prox",
                line,
                (got - want).abs() / proximal,
            );
        }
        let free = row.f64("C_free")?;
        if free.is_finite() {
            report.note(
                "C_free, relative",
                line,
                relative(number(built.free_compliance(&at, torque)), free, 0.0),
            );
        } else if built.free_compliance(&at, torque).is_some() {
            report.misclassify(line, "C_free should not exist".to_owned());
        }
        let gear = built.transmission().factors(&at);
        for joint in 2..=N {
            let x = gear.and_then(|gear| gear.x.get(joint - 1).copied());
            report.note(
                "x, over 1",
                line,
                relative(number(x), row.f64(&format!("x{joint}"))?, 1.0),
            );
            for other in joint..=N {
                let g = gear.and_then(|gear| Some(gear.w.get(joint - 1)?.get(other - 1)? * torque));
                let scale = row.f64("K2")?.max(row.f64("K1")?);
                let error = relative(number(g), row.f64(&format!("g{joint}{other}"))?, scale);
                report.note("G, over the stiffest spring", line, error);
            }
        }
        let e2 = row.f64("e2")?;
        if N == 2 && e2 > 0.0 {
            report.note(
                "e_2, relative",
                line,
                relative(number(built.stiffest_m(&at, torque, 2)), e2, 0.0),
            );
        }
        let presses = built
            .path(
                &at,
                torque,
                Contact {
                    phalanx,
                    k_m: k,
                    radius_m: 0.0,
                },
            )
            .is_some();
        let should = row.f64("df_dT")? > 0.0;
        if presses != should {
            report.misclassify(
                line,
                format!("contact presses: {presses}, reference {should}"),
            );
        }
    }
    Ok(())
}

/// Compliance of a proximal contact from the file's own numbers.
#[expect(
    clippy::needless_range_loop,
    reason = "matrices are written with indices, as on paper"
)]
fn reference_proximal<const N: usize>(row: &Row<'_>) -> Result<f64, FileError> {
    let (x2, h22) = (row.f64("x2")?, row.f64("K2")? - row.f64("g22")?);
    if N == 2 {
        return Ok(x2 * x2 / h22);
    }
    // x'^T H'^-1 x' over the joints beyond the first, by elimination from the tip.
    let mut h = [[0.0; N]; N];
    let mut x = [0.0; N];
    for i in 1..N {
        x[i] = row.f64(&format!("x{}", i + 1))?;
        for j in i..N {
            let spring = if i == j {
                row.f64(&format!("K{}", i + 1))?
            } else {
                0.0
            };
            h[i][j] = spring - row.f64(&format!("g{}{}", i + 1, j + 1))?;
            h[j][i] = h[i][j];
        }
    }
    let mut compliance = 0.0;
    for last in (1..N).rev() {
        compliance += x[last] * x[last] / h[last][last];
        for i in 1..last {
            let share = h[i][last] / h[last][last];
            x[i] -= share * x[last];
            for j in 1..last {
                h[i][j] -= share * h[last][j];
            }
        }
    }
    Ok(compliance)
}
