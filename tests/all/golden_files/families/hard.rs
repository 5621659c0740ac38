//! hard_*: the inverse where it is badly conditioned, judged against the conditioning floor.

use super::super::fingers::numbered;
use super::super::measure::{FileReport, Limit};
use super::super::table::{FileError, Table};
use palpate::finger::{Roots, ThreeJointContact, TwoJointContact};
use palpate::numeric::{Rotation, sin_cos};

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
pub fn hard_pair(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
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
pub fn hard_triple(table: &Table, report: &mut FileReport) -> Result<(), FileError> {
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
