//! inverse_*: all places that explain a compliance, and the class.

use super::super::fingers::{FromRow, finger, posture};
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Row, Table};
use palpate::finger::{Candidate, Class, Configuration, Finger, Inverse, Mechanics};

/// Limits of the inverse by phalanx, % of its length: names differ because limits do.
fn inverse_limits<const N: usize>() -> [Limit; 5] {
    if N == 2 {
        [Limit::max(1e-4); 5]
    } else {
        let [second, further] = [5e-3, 0.2].map(Limit::max);
        [second, further, further, further, further]
    }
}

const BISECTION: [&str; 5] = [
    "k on phalanx 2 by bisection, % of l",
    "k on phalanx 3 by bisection, % of l",
    "k on phalanx 4 by bisection, % of l",
    "k on phalanx 5 by bisection, % of l",
    "k on phalanx 6 by bisection, % of l",
];
const CLOSED: [&str; 5] = [
    "k on phalanx 2 in closed form, % of l",
    "k on phalanx 3 in closed form, % of l",
    "k on phalanx 4 in closed form, % of l",
    "k on phalanx 5 in closed form, % of l",
    "k on phalanx 6 in closed form, % of l",
];

/// inverse_* and inverse_folded_*: all places that explain a compliance, and the class.
pub fn inverse<const N: usize, T: FromRow<N>>(
    table: &Table,
    report: &mut FileReport,
) -> Result<(), FileError>
where
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    // Folded postures are judged by what is accepted and missed; their places are badly conditioned around 90 degrees.
    let folded = table.has(&["rej_phal_a"]);
    let limits = if folded {
        [Limit::default(); 5]
    } else {
        inverse_limits::<N>()
    };
    for names in [BISECTION, CLOSED] {
        for (name, limit) in names.into_iter().zip(limits).take(N - 1) {
            report.quantity(name, limit);
        }
    }
    for row in table.rows() {
        report.rows += 1;
        let built = finger::<N, T>(&row)?;
        let Some((at, torque)) = posture(&row, &built, "T_c")? else {
            report.misclassify(row.line, "no posture found".to_owned());
            continue;
        };
        let compliance = row.f32("C_meas")?;
        let answers = [
            (BISECTION, built.locate(&at, torque, compliance)),
            (CLOSED, built.locate_closed(&at, torque, compliance)),
        ];
        for (names, answer) in answers {
            compare_places(&row, report, names, &built, &answer)?;
        }
    }
    Ok(())
}

fn compare_places<const N: usize, T: FromRow<N>>(
    row: &Row<'_>,
    report: &mut FileReport,
    names: [&'static str; 5],
    finger: &Finger<N, T>,
    answer: &Inverse,
) -> Result<(), FileError> {
    let count = row.f64("n_sol")? as usize;
    let mut want: Vec<(u8, f64)> = Vec::new();
    for letter in ('a'..='j').take(count) {
        want.push((
            row.f64(&format!("phal_{letter}"))? as u8,
            row.f64(&format!("k_{letter}"))?,
        ));
    }
    let mut got: Vec<Candidate> = answer.candidates().to_vec();
    let order = |a: (u8, f64), b: (u8, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    want.sort_by(|a, b| order(*a, *b));
    got.sort_by(|a, b| order((a.phalanx, a.k_m.into()), (b.phalanx, b.k_m.into())));
    let class = row.text("class").ok();
    let places = |list: &[u8]| format!("{list:?}");
    let (got_on, want_on) = (
        places(&got.iter().map(|c| c.phalanx).collect::<Vec<_>>()),
        places(&want.iter().map(|c| c.0).collect::<Vec<_>>()),
    );
    if got_on != want_on || class.is_some_and(|class| class != class_name(answer.class())) {
        let got_class = class_name(answer.class());
        let want_class = class.unwrap_or("-");
        report.misclassify(
            row.line,
            format!("{got_class} on {got_on}, reference {want_class} on {want_on}"),
        );
        return Ok(());
    }
    for (got, (phalanx, k)) in got.iter().zip(want) {
        let length = finger
            .parameters()
            .lengths_m
            .get(usize::from(phalanx) - 1)
            .copied()
            .unwrap_or(f32::NAN);
        let error = (f64::from(got.k_m) - k).abs() / f64::from(length) * 100.0;
        let name = names
            .get(usize::from(phalanx) - 2)
            .copied()
            .unwrap_or(names[0]);
        report.note(name, row.line, error);
    }
    Ok(())
}

/// The class as the files spell it.
fn class_name(class: Class) -> &'static str {
    match class {
        Class::Unique => "unique",
        Class::AmbiguousSame => "ambig_same",
        Class::AmbiguousAcross => "ambig_cross",
        Class::TooSoft => "none_too_soft",
        Class::Gap => "none_gap",
        Class::TooStiff => "none_too_stiff",
        Class::Proximal => "proximal",
        Class::Invalid => "invalid",
    }
}
