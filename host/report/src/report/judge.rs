//! Errors of every candidate over all reference rows, on this PC with the code that the chip runs.

use palpate_bench::candidate::{Candidate, Role};
use palpate_bench::function::{self, Angle};
use palpate_bench::rows::{self, Reference};
use palpate_bench::step::{self, Row as StepRow};
use palpate_bench::task::{Bits, Task, Visitor, checksum};
use palpate_bench::{task, three, two};

use super::inputs::{SWEEP, angle, equations, number, point, unsolved};
use super::published;
use super::row::Error;

/// What is known of a candidate without the chip.
pub struct Judged {
    /// Task.
    pub task: &'static str,
    /// Candidate.
    pub name: &'static str,
    /// What it is to the firmware.
    pub role: Role,
    /// How far it is off.
    pub error: Error,
    /// Of its results over the inputs that the chip times; nothing for what cannot run there.
    pub checksum: Option<u32>,
}

/// Errors of one candidate, gathered.
#[derive(Default)]
struct Gathered {
    random: Vec<f64>,
    hard: Vec<f64>,
    nonfinite: usize,
    spurious: usize,
}

impl Gathered {
    fn add(&mut self, error: f64, hard: bool) {
        if error.is_finite() {
            if hard {
                &mut self.hard
            } else {
                &mut self.random
            }
            .push(error);
        } else {
            self.nonfinite += 1;
        }
    }

    fn summary(self, unit: &'static str) -> Error {
        let most = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
        let (random_max, hard_max) = (most(&self.random), most(&self.hard));
        let has_hard = !self.hard.is_empty();
        let mut all = [self.random, self.hard].concat();
        all.sort_by(f64::total_cmp);
        let count = all.len().max(1) as f64;
        let share = |share: f64| {
            let at = (share * (count - 1.0)).round() as usize;
            all.get(at).copied().unwrap_or(f64::NAN)
        };
        Error {
            error_unit: unit,
            error_median: share(0.5),
            error_p99: share(0.99),
            error_max: share(1.0),
            error_rms: (all.iter().map(|error| error * error).sum::<f64>() / count).sqrt(),
            random_max,
            hard_max: has_hard.then_some(hard_max),
            nonfinite: self.nonfinite,
            spurious: self.spurious,
            rows: all.len() + self.nonfinite,
        }
    }
}

/// Distances between wanted and found places, nearest pair first; infinite for a wanted place without a partner. Returns
/// how many were found beyond those.
fn match_places(wanted: &[f64], found: &[f64]) -> (Vec<f64>, usize) {
    let (mut wanted, mut found) = (wanted.to_vec(), found.to_vec());
    let mut distances = Vec::new();
    while !wanted.is_empty() {
        let pairs = (0..wanted.len()).flat_map(|i| (0..found.len()).map(move |j| (i, j)));
        let distance = |&(i, j): &(usize, usize)| (wanted[i] - found[j]).abs();
        let Some((i, j)) = pairs.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
            distances.resize(distances.len() + wanted.len(), f64::INFINITY);
            break;
        };
        distances.push(distance(&(i, j)));
        wanted.remove(i);
        found.remove(j);
    }
    (distances, found.len())
}

/// Places on a phalanx, in % of its length.
fn places<I>(
    candidate: &Candidate<I, [f32; 2]>,
    rows: &[Reference<I>],
    length: fn(&I) -> f32,
) -> Error {
    let mut gathered = Gathered::default();
    for row in rows {
        let finite = |values: [f64; 2]| {
            values
                .into_iter()
                .filter(|k| k.is_finite())
                .collect::<Vec<_>>()
        };
        let found = finite((candidate.run)(&row.input).map(f64::from));
        let (distances, spurious) = match_places(&finite(row.roots), &found);
        gathered.spurious += spurious;
        for distance in distances {
            gathered.add(100.0 * distance / f64::from(length(&row.input)), row.hard);
        }
    }
    gathered.summary("% of the phalanx")
}

/// The place that a finite step came from, in % of the phalanx's length. Other places that explain the same step are no
/// mistake: they are not counted.
fn stepped<I, const N: usize, const S: usize>(
    candidate: &Candidate<I, [f32; 2]>,
    rows: &[(StepRow<N, S>, f64)],
    ready: fn(&StepRow<N, S>) -> Option<I>,
) -> Error {
    let mut gathered = Gathered::default();
    for (row, k) in rows {
        // A row that the library refuses is an answer that is lacking.
        let found = ready(row).map_or([f64::NAN; 2], |input| {
            (candidate.run)(&input).map(f64::from)
        });
        let nearest = found
            .into_iter()
            .filter(|k| k.is_finite())
            .map(|found| (found - k).abs())
            .fold(f64::INFINITY, f64::min);
        gathered.add(100.0 * nearest / f64::from(row.length()), false);
    }
    gathered.summary("% of the phalanx")
}

/// A function of one result over the sweep: the truth in f64, absolute or relative.
fn sweep<I, O>(
    candidate: &Candidate<I, O>,
    input: fn(u32) -> I,
    error: fn(&I, O) -> f64,
    unit: &'static str,
) -> Error {
    let mut gathered = Gathered::default();
    for at in 0..SWEEP {
        let input = input(at);
        gathered.add(error(&input, (candidate.run)(&input)), false);
    }
    gathered.summary(unit)
}

fn relative(found: f32, truth: f64) -> f64 {
    (f64::from(found) - truth).abs() / truth.abs()
}

/// The larger of the errors of a sine and a cosine.
fn off(angle: &Angle, [sin, cos]: [f32; 2]) -> f64 {
    let (true_sin, true_cos) = f64::from(angle.rad).sin_cos();
    let (sin, cos) = (f64::from(sin) - true_sin, f64::from(cos) - true_cos);
    sin.abs().max(cos.abs())
}

/// The CORDIC's promise: its low bits on the emulated chip are a model's, of which only the largest error means something.
fn documented() -> Error {
    let promise = function::cordic::LARGEST_ERROR;
    Error {
        error_unit: "absolute",
        error_median: f64::NAN,
        error_p99: promise,
        error_max: promise,
        error_rms: f64::NAN,
        random_max: promise,
        rows: SWEEP as usize,
        ..Error::default()
    }
}

fn errors(task: &str, at: usize) -> Error {
    match task {
        "k2_2p" => places(&two::CANDIDATES[at], rows::TWO, |input| input.l2),
        "k2_3p" => places(
            &three::CANDIDATES[at],
            rows::THREE,
            three::ThreePhalanges::length,
        ),
        "k2_2p_step" => stepped(&step::TWO[at], rows::TWO_STEPS, step::ready),
        "k2_3p_step" => stepped(&step::THREE[at], rows::THREE_STEPS, step::ready),
        "sqrt" => sweep(
            &function::SQRT[at],
            number,
            |x, y| relative(y, f64::from(*x).sqrt()),
            "relative",
        ),
        "recip" => sweep(
            &function::RECIP[at],
            number,
            |x, y| relative(y, 1.0 / f64::from(*x)),
            "relative",
        ),
        "sin" if function::SIN[at].name == function::cordic::NAME => documented(),
        "sin_cos" if function::SIN_COS[at].name == function::cordic::NAME => documented(),
        "sin" => sweep(
            &function::SIN[at],
            angle,
            |angle, sin| (f64::from(sin) - f64::from(angle.rad).sin()).abs(),
            "absolute",
        ),
        "sin_cos" => sweep(&function::SIN_COS[at], angle, off, "absolute"),
        "sin_cos_step" => sweep(&function::SIN_COS_STEP[at], angle, off, "absolute"),
        "ln" => sweep(
            &function::LN[at],
            number,
            |x, y| (f64::from(y) - f64::from(*x).ln()).abs(),
            "absolute",
        ),
        "solve_3" => sweep(
            &function::SOLVE[at],
            equations,
            unsolved,
            "of the largest unknown",
        ),
        "atan2" => sweep(
            &function::ATAN2[at],
            point,
            |[y, x], angle| (f64::from(angle) - f64::from(*y).atan2(f64::from(*x))).abs(),
            "rad",
        ),
        _ => Error::default(),
    }
}

/// Candidates of a task that need the standard library.
fn on_pc_only(task: &'static str) -> Vec<Judged> {
    let judged = |name, error| Judged {
        task,
        name,
        role: Role::Rival,
        error,
        checksum: None,
    };
    match task {
        "k2_2p" => published::TWO
            .iter()
            .map(|one| judged(one.name, places(one, rows::TWO, |input| input.l2)))
            .collect(),
        "k2_3p" => published::THREE
            .iter()
            .map(|one| {
                let length = three::ThreePhalanges::length;
                judged(one.name, places(one, rows::THREE, length))
            })
            .collect(),
        _ => Vec::new(),
    }
}

struct Judge(Vec<Judged>);

impl Visitor for Judge {
    fn task<I, O: Bits>(&mut self, task: &Task<'_, I, O>) {
        for (at, candidate) in task.candidates.iter().enumerate() {
            self.0.push(Judged {
                task: task.name,
                name: candidate.name,
                role: candidate.role,
                error: errors(task.name, at),
                checksum: Some(checksum(task, candidate)),
            });
        }
        self.0.extend(on_pc_only(task.name));
    }
}

/// Judges all candidates of all tasks.
pub fn judge() -> Vec<Judged> {
    let mut judge = Judge(Vec::new());
    task::visit(&mut judge);
    judge.0
}

#[cfg(test)]
mod tests {
    use super::{Role, judge, match_places};

    #[test]
    fn a_missing_place_is_no_large_distance() {
        let (distances, spurious) = match_places(&[0.2, 0.7], &[0.71]);
        assert!((distances[0] - 0.01).abs() < 1e-12 && distances[1].is_infinite());
        assert_eq!((distances.len(), spurious), (2, 0));
        assert_eq!(match_places(&[], &[0.5]).1, 1);
    }

    #[test]
    fn every_task_has_errors_and_every_place_in_the_firmware_a_choice() {
        // What the code does not do: a sine alone, a rotation advanced from the last sample.
        const NOT_DONE: &[&str] = &["sin", "sin_cos_step"];
        let judged = judge();
        assert!(judged.iter().all(|one| one.error.rows > 0));
        for one in &judged {
            let mut of_task = judged.iter().filter(|other| other.task == one.task);
            let is_chosen = of_task.any(|other| matches!(other.role, Role::Used(_)));
            assert_ne!(is_chosen, NOT_DONE.contains(&one.task), "{}", one.task);
        }
    }

    #[test]
    fn bisection_and_its_check_are_at_the_rounding_of_f32() {
        let judged = judge();
        // Phalanx 3 is as good as its conditioning: docs/MECHANICS.md#single-precision.
        for (task, most) in [("k2_2p", 1e-4), ("k2_3p", 2e-2)] {
            for name in ["library_closed", "library_bisection"] {
                let of = |one: &&super::Judged| one.task == task && one.name == name;
                let error = &judged.iter().find(of).expect("it is a candidate").error;
                assert!(error.random_max <= most, "{task} {name}: {error:?}");
                // One double root of a hard row of three phalanges is lost to rounding.
                assert!(
                    error.nonfinite <= usize::from(task == "k2_3p"),
                    "{task} {name}: {error:?}"
                );
            }
        }
    }

    #[test]
    fn one_unknown_explains_a_finite_step_without_the_bias_of_the_secant() {
        let judged = judge();
        let of = |name: &str| {
            let found = judged
                .iter()
                .find(|one| one.task == "k2_2p_step" && one.name == name);
            &found.expect("it is a candidate").error
        };
        assert!(of("secant_closed").error_max > 1.0);
        let error = of("finite_step_one_unknown");
        assert!(error.error_max < 5e-4 && error.nonfinite == 0, "{error:?}");
    }
}
