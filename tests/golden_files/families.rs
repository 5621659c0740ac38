//! Checks of the library for each family of reference files.

use super::fingers::{FromRow, Kind, assembly, finger, numbered, posture};
use super::measure::{FileReport, Limit};
use super::table::{FileError, Row, Table};
use palpate::finger::{
    Candidate, Class, Configuration, Contact, Finger, FourBar, Free, Inverse, Levers, Linkage,
    Mechanics, Parameters, Path, Roots, Tendon, ThreeJointContact, Transmission,
    TransmissionFactors, TwoJointContact,
};
use palpate::numeric::{Rotation, sin_cos};
use palpate::sensing::location::{NoJointSensor, Rigid};
use palpate::sensing::step;

/// Calls a generic function for the finger that the header describes.
macro_rules! by_kind {
    ($table:expr, $function:ident, $report:expr) => {
        match Kind::of($table)? {
            Kind::Tendon2 => $function::<2, Tendon<2>>($table, $report),
            Kind::Linkage2 => $function::<2, Linkage<1>>($table, $report),
            Kind::Tendon3 => $function::<3, Tendon<3>>($table, $report),
            Kind::Linkage3 => $function::<3, Linkage<2>>($table, $report),
            Kind::Linkage4 => $function::<4, Linkage<3>>($table, $report),
            Kind::Tendon5 => $function::<5, Tendon<5>>($table, $report),
            Kind::Tendon6 => $function::<6, Tendon<6>>($table, $report),
            Kind::Linkage6 => $function::<6, Linkage<5>>($table, $report),
        }
    };
}

/// Evaluates a file; its header says which family it belongs to.
pub fn evaluate(table: &Table) -> Result<FileReport, FileError> {
    let mut report = FileReport::new(&table.name);
    if table.has(&["g", "a", "b", "c", "psi", "mode", "v", "status"]) {
        four_bar(table, &mut report)?;
    } else if table.has(&["tau1", "f1", "x2"]) {
        static_forces(table, &mut report)?;
    } else if table.has(&["K2p", "k_minus", "k_plus"]) {
        hard_pair(table, &mut report)?;
    } else if table.has(&["disc_rel", "k_a", "k_b", "x3"]) {
        hard_triple(table, &mut report)?;
    } else if table.has(&["C_meas", "n_sol"]) {
        by_kind!(table, inverse, &mut report)?;
    } else if table.has(&["dT", "dtheta_a", "k_after"]) {
        by_kind!(table, contact, &mut report)?;
    } else if table.has(&["T_a", "K_a", "K_tangent"]) {
        by_kind!(table, preshape, &mut report)?;
    } else if table.has(&["T_c", "phal", "C", "df_dT"]) {
        by_kind!(table, stiffness, &mut report)?;
    } else {
        return Err(
            table.error("its header is that of no known family of reference files".to_owned())
        );
    }
    Ok(report)
}

/// A value that may be absent, as a number; an absent one counts as not finite.
fn number(value: Option<f32>) -> f64 {
    value.map_or(f64::NAN, f64::from)
}

/// Error relative to the value, or to `scale` where the value is smaller.
fn relative(got: f64, want: f64, scale: f64) -> f64 {
    (got - want).abs() / want.abs().max(scale)
}

/// Limit of what the issue calls "1e-5 relative to the natural scale".
const NATURAL: f64 = 1e-5;

/// kc_*: preshaping, gear and K_c (18).
fn stiffness<const N: usize, T: FromRow<N>>(
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
fn inverse<const N: usize, T: FromRow<N>>(
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

/// The conditioning floor of a place: how far it moves when any one input moves by half an ulp, in f64; both ways, the
/// farther. Where it vanishes (past a double root), it has no digits: infinite.
fn floor(inputs: &[f64], place: impl Fn(&[f64]) -> Option<f64>) -> f64 {
    let Some(here) = place(inputs) else {
        return f64::INFINITY;
    };
    let mut farthest = 0.0f64;
    for i in 0..inputs.len() {
        for half_ulp in [-(2.0f64.powi(-24)), 2.0f64.powi(-24)] {
            let mut moved = inputs.to_vec();
            moved[i] *= 1.0 + half_ulp;
            farthest =
                farthest.max(place(&moved).map_or(f64::INFINITY, |there| (there - here).abs()));
        }
    }
    farthest
}

/// How far a solver's error exceeds what conditioning excuses: at most 1 is asked.
fn over_floor(error_percent: f64, floor_percent: f64) -> f64 {
    error_percent / (4.0 * floor_percent + 1e-4)
}

/// docs/MECHANICS.md#contact-stiffness in f64, for the floor only.
fn pair_root_f64(inputs: &[f64], far: bool) -> Option<f64> {
    let &[l1, theta, x2, k1, h, compliance] = inputs else {
        return None;
    };
    let c = l1 * theta.cos();
    let num = x2 * x2 - compliance * h;
    let square = compliance * h + compliance * k1 * num;
    if square < 0.0 {
        return None;
    }
    let s = square.sqrt();
    let k = if far {
        c * (x2 + s) / (1.0 - x2 - compliance * k1 - s)
    } else {
        c * num / (x2 * (1.0 - x2) + compliance * h + s)
    };
    Some(k)
}

/// hard_2p: the two-joint inverse where it is hard.
fn hard_pair(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
    let names = [
        [
            "k below e_2 in closed form, over its allowance",
            "k below e_2 by bisection, over its allowance",
        ],
        [
            "k beyond e_2 in closed form, over its allowance",
            "k beyond e_2 by bisection, over its allowance",
        ],
    ];
    names
        .iter()
        .flatten()
        .for_each(|name| report.quantity(name, Limit::max(1.0)));
    for row in table.rows() {
        report.rows += 1;
        let (l1, l2, compliance) = (row.f32("l1")?, row.f32("l2")?, row.f32("C")?);
        let (_, cos) = sin_cos(row.f32("th2")?);
        let pair = TwoJointContact {
            c_m: l1 * cos,
            x2: row.f32("x2")?,
            k1: row.f32("K1")?,
            h22: row.f32("K2p")?,
        };
        let mut inputs = Vec::new();
        for column in ["l1", "th2", "x2", "K1", "K2p", "C"] {
            inputs.push(row.f64(column)?);
        }
        let wanted = [row.f64("k_minus")?, row.f64("k_plus")?];
        // The file's roots may lie off the phalanx: bisection searches as far as they do, each with a bracket of its own,
        // whose halvings leave a share of it.
        let [near, far] = reaches(wanted, l2);
        let closed = pair.closed(compliance);
        let bisected = Roots {
            near_m: pair.bisected(compliance, near).near_m,
            far_m: pair.bisected(compliance, far).far_m,
        };
        let by_side = [
            [closed.near_m, bisected.near_m],
            [closed.far_m, bisected.far_m],
        ];
        for (far, ((got, want), names)) in by_side.into_iter().zip(wanted).zip(names).enumerate() {
            let floor = floor(&inputs, |i| pair_root_f64(i, far == 1)) / f64::from(l2) * 100.0;
            judge_root(report, row.line, names, got, want, f64::from(l2), floor);
        }
    }
    Ok(())
}

/// How far to search for the nearer and the farther of the wanted roots: past them, at least to the phalanx's end.
fn reaches(wanted: [f64; 2], length: f32) -> [f32; 2] {
    let finite = || wanted.iter().copied().filter(|k| k.is_finite());
    let [near, far] = [
        finite().fold(f64::INFINITY, f64::min),
        finite().fold(0.0, f64::max),
    ];
    [if near.is_finite() { near } else { far }, far].map(|k| 1.5 * k.max(f64::from(length)) as f32)
}

/// One root of a hard case by both solvers.
fn judge_root(
    report: &mut FileReport,
    line: usize,
    names: [&'static str; 2],
    got: [Option<f32>; 2],
    want: f64,
    length: f64,
    floor_percent: f64,
) {
    for (name, got) in names.into_iter().zip(got) {
        match got {
            _ if want.is_nan() => {
                if let Some(k) = got {
                    report.misclassify(line, format!("{name}: found {k}, there is none"));
                }
            }
            Some(k) => {
                let error = (f64::from(k) - want).abs() / length * 100.0;
                report.note(name, line, over_floor(error, floor_percent));
            }
            // A double root may be lost to half an ulp of the input: then there is nothing to find.
            None if floor_percent.is_infinite() => {}
            None => report.note(name, line, f64::NAN),
        }
    }
}

/// Quadratic of docs/MECHANICS.md#contact-stiffness for phalanx 3 in f64, for the floor only.
fn triple_root_f64(inputs: &[f64], which: f64) -> Option<f64> {
    let &[l1, l2, theta_2, theta_3, x2, x3, k1, k2, k3, compliance] = inputs else {
        return None;
    };
    let d2 = l2 * theta_3.cos();
    let d1 = d2 + l1 * (theta_2 + theta_3).cos();
    // softness - C energy at three places gives the quadratic exactly.
    let value = |k: f64| {
        let p = [d1 + k, d2 + k, k];
        let v = [p[1] * x3 - p[2] * x2, p[2] - p[0] * x3, p[0] * x2 - p[1]];
        k1 * v[0] * v[0] + k2 * v[1] * v[1] + k3 * v[2] * v[2]
            - compliance * (k2 * k3 * p[0] * p[0] + k1 * k3 * p[1] * p[1] + k1 * k2 * p[2] * p[2])
    };
    let unit = l1 + l2;
    let (low, middle, high) = (value(-unit), value(0.0), value(unit));
    let (q1, q2) = (
        0.5 * (high - low) / unit,
        0.5 * (high + low - 2.0 * middle) / (unit * unit),
    );
    let square = q1 * q1 - 4.0 * q2 * middle;
    if square < 0.0 {
        return None;
    }
    let large = -0.5 * (q1 + square.sqrt().copysign(q1));
    let roots = [large / q2, middle / large];
    roots
        .into_iter()
        .min_by(|a, b| (a - which).abs().total_cmp(&(b - which).abs()))
}

/// The same for phalanx 2 with springs of their own at each joint.
fn reduced_pair_root_f64(inputs: &[f64], which: f64) -> Option<f64> {
    let &[l1, _, theta_2, _, x2, x3, k1, k2, k3, compliance] = inputs else {
        return None;
    };
    let pair = [l1, theta_2, x2, k1, k2, compliance - x3 * x3 / k3];
    let roots = [pair_root_f64(&pair, false)?, pair_root_f64(&pair, true)?];
    roots
        .into_iter()
        .min_by(|a, b| (a - which).abs().total_cmp(&(b - which).abs()))
}

/// hard_3p: the three-joint inverse where it is hard.
fn hard_triple(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
    let names = [
        "k in closed form, over its allowance",
        "k by bisection, over its allowance",
    ];
    names
        .iter()
        .for_each(|name| report.quantity(name, Limit::max(1.0)));
    for row in table.rows() {
        report.rows += 1;
        let phalanx = row.f64("phal")? as usize;
        let [l1, l2, l3] = numbered::<3>(&row, "l", "")?;
        let (theta_2, theta_3, compliance) = (
            Rotation::by(row.f32("th2")?),
            Rotation::by(row.f32("th3")?),
            row.f32("C")?,
        );
        let (x2, x3, [k1, h22, h33]) = (
            row.f32("x2")?,
            row.f32("x3")?,
            numbered::<3>(&row, "K", "")?,
        );
        let length = if phalanx == 3 { l3 } else { l2 };
        let mut wanted = [row.f64("k_a")?, row.f64("k_b")?];
        let [near, far] = reaches(wanted, length);
        let (closed, bisected) = if phalanx == 3 {
            let d2_m = l2 * theta_3.cos;
            let d1_m = l1 * theta_2.then(theta_3).cos + d2_m;
            let triple = ThreeJointContact {
                d1_m,
                d2_m,
                x2,
                x3,
                k1,
                h22,
                h23: 0.0,
                h33,
            };
            (
                triple.closed(compliance),
                Roots {
                    near_m: triple.bisected(compliance, near).near_m,
                    far_m: triple.bisected(compliance, far).far_m,
                },
            )
        } else {
            let pair = TwoJointContact {
                c_m: l1 * theta_2.cos,
                x2,
                k1,
                h22,
            };
            let rest = compliance - x3 * (x3 / h33);
            let bisected = Roots {
                near_m: pair.bisected(rest, near).near_m,
                far_m: pair.bisected(rest, far).far_m,
            };
            (pair.closed(rest), bisected)
        };
        let mut inputs = Vec::new();
        for column in ["l1", "l2", "th2", "th3", "x2", "x3", "K1", "K2", "K3", "C"] {
            inputs.push(row.f64(column)?);
        }
        wanted.sort_by(f64::total_cmp);
        let wanted: Vec<f64> = wanted.into_iter().filter(|k| k.is_finite()).collect();
        for (name, roots) in names.into_iter().zip([closed, bisected]) {
            let mut got: Vec<f32> = [roots.near_m, roots.far_m].into_iter().flatten().collect();
            got.sort_by(f32::total_cmp);
            let floors: Vec<f64> = wanted
                .iter()
                .map(|k| {
                    let root = |i: &[f64]| {
                        if phalanx == 3 {
                            triple_root_f64(i, *k)
                        } else {
                            reduced_pair_root_f64(i, *k)
                        }
                    };
                    floor(&inputs, root) / f64::from(length) * 100.0
                })
                .collect();
            if got.len() != wanted.len() {
                // Half an ulp of the input may make or lose a double root, or take one through the joint.
                let excused = floors.iter().any(|f| f.is_infinite());
                if !excused {
                    report.misclassify(row.line, format!("{name}: {got:?}, reference {wanted:?}"));
                }
                continue;
            }
            for ((got, want), floor) in got.iter().zip(&wanted).zip(&floors) {
                judge_root(
                    report,
                    row.line,
                    [name; 2],
                    [Some(*got), Some(*got)],
                    *want,
                    f64::from(length),
                    *floor,
                );
            }
        }
    }
    Ok(())
}

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
fn contact<const N: usize, T: FromRow<N>>(
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
        let reach = |share: f32| {
            path.clone()
                .and_then(|mut path| built.follow(&mut path, share * more))
        };
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
        let mut end = path.clone();
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
            let places = step::places(&built, &at, torque, &step, &Rigid, &NoJointSensor);
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

/// preshape_*: the free finger (6), (7).
fn preshape<const N: usize, T: FromRow<N>>(
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

/// fourbar: one stage by itself.
fn four_bar(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
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
fn static_forces(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
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
