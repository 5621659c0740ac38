//! Sampling of a posterior: values of all unknowns by how likely they make a curve (Metropolis and Hastings).
//!
//! A chain is proposed to by the linear solution about the truth, which saves time: what it comes to in the end does not depend on that,
//! nor on where it begins. One that begins at the truth and ends too early is too near to it and too sure, so that its error is a bound
//! still. One that is heated first has left the truth by some of its deviations when it begins to count; too sure it may be as well.

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::information::MEAN_SHARE;

/// Steps of a chain that count, and those before them: rounds, after each of which the walk takes the shape of what it has come to.
const STEPS: usize = 800;
const ROUND: usize = 200;
/// Temperatures of the rounds of a chain that begins at the truth, and of one that is heated.
const COLD: [f64; 3] = [1.0; 3];
const HEATED: [f64; 4] = [30.0, 10.0, 3.0, 1.0];
/// Width of the proposals about the linear solution, and of steps from where the chain is, over the root of the unknowns' number.
const WIDER: f64 = 1.2;
const WALK: f64 = 1.8;
/// Share of the linear solution's covariance in the shape of the walk.
const OF_LINEAR: f64 = 0.05;

/// What a posterior makes of drawn contacts, percent of the phalanx.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Told {
    /// Mean error without sign of the posterior's mean.
    pub error_pct: f64,
    /// Mean error without sign that its deviations stand for.
    pub claimed_pct: f64,
    /// Errors within two deviations.
    pub within2_pct: f64,
}

impl Told {
    /// From errors and deviations, shares of the phalanx.
    pub(super) fn of(all: &[[f64; 2]]) -> Self {
        let mean_pct = |of: &dyn Fn(&[f64; 2]) -> f64| {
            100.0 * all.iter().map(of).sum::<f64>() / all.len() as f64
        };
        Self {
            error_pct: mean_pct(&|[error, _]| error.abs()),
            claimed_pct: MEAN_SHARE * mean_pct(&|[_, sigma]| *sigma),
            within2_pct: mean_pct(&|[error, sigma]| f64::from(u8::from(error.abs() < 2.0 * sigma))),
        }
    }
}

/// Independent normal variables.
pub(super) fn normals(number: usize, random: &mut Pcg64Mcg) -> DVector<f64> {
    DVector::from_fn(number, |_, _| StandardNormal.sample(random))
}

/// Rows and columns of unknowns that are not exact.
pub(super) fn of_open(matrix: &DMatrix<f64>, open: &[usize]) -> DMatrix<f64> {
    matrix.select_rows(open).select_columns(open)
}

/// The linear solution about the truth, in units of the unknowns' deviations: its middle, and a root of its covariance.
pub(super) struct Linear {
    middle: DVector<f64>,
    root: DMatrix<f64>,
}

impl Linear {
    /// From whitened derivatives and noise of a curve, the information of what is told beside it, and what is known beforehand: how far it
    /// expects each unknown from the truth, and its information.
    pub(super) fn of(
        [slopes, beside]: [&DMatrix<f64>; 2],
        noise: &DVector<f64>,
        (expected, precision): (&DVector<f64>, &DMatrix<f64>),
    ) -> Option<Self> {
        let matrix = slopes.tr_mul(slopes) + beside + precision;
        let covariance = matrix.try_inverse()?;
        Some(Self {
            middle: &covariance * (slopes.tr_mul(noise) + precision * expected),
            root: ((&covariance + covariance.transpose()) * 0.5)
                .cholesky()?
                .unpack(),
        })
    }

    /// Mean and deviation of one unknown by a chain from the truth; `density` is the logarithm of the posterior's, but for a constant.
    pub(super) fn sampled(
        &self,
        unknown: usize,
        density: impl Fn(&DVector<f64>) -> Option<f64>,
        random: &mut Pcg64Mcg,
    ) -> [f64; 2] {
        self.chain(unknown, density, &COLD, random)
    }

    /// The same by a chain that is heated first.
    pub(super) fn sampled_from_afar(
        &self,
        unknown: usize,
        density: impl Fn(&DVector<f64>) -> Option<f64>,
        random: &mut Pcg64Mcg,
    ) -> [f64; 2] {
        self.chain(unknown, density, &HEATED, random)
    }

    /// The same with rounds at these temperatures before what counts.
    fn chain(
        &self,
        unknown: usize,
        density: impl Fn(&DVector<f64>) -> Option<f64>,
        temperatures: &[f64],
        random: &mut Pcg64Mcg,
    ) -> [f64; 2] {
        let Self { middle, root } = self;
        let number = middle.len();
        let mut at = DVector::zeros(number);
        let mut here = density(&at).unwrap_or(f64::NEG_INFINITY);
        // Logarithm of the density of proposals about the linear solution.
        let proposed = |at: &DVector<f64>| {
            let off = root.solve_lower_triangular(&(at - middle));
            off.map_or(0.0, |off| -0.5 * off.norm_squared() / (WIDER * WIDER))
        };
        let mut run = |steps: usize,
                       (walk, temperature): (&DMatrix<f64>, f64),
                       see: &mut dyn FnMut(&DVector<f64>)| {
            for step in 0..steps {
                let walks = temperature > 1.0 || step % 4 != 0;
                let next = if walks {
                    &at + walk * normals(number, random) * (WALK / (number as f64).sqrt())
                } else {
                    middle + root * normals(number, random) * WIDER
                };
                if let Some(there) = density(&next) {
                    let mut gain = (there - here) / temperature;
                    if !walks {
                        gain += proposed(&at) - proposed(&next);
                    }
                    if gain >= 0.0 || random.random_range(0.0..1.0) < gain.exp() {
                        (at, here) = (next, there);
                    }
                }
                see(&at);
            }
        };
        let mut walk = root * temperatures.first().map_or(1.0, |hot| hot.sqrt());
        for (round, &temperature) in temperatures.iter().enumerate() {
            let (mut sum, mut squares) = (DVector::zeros(number), DMatrix::zeros(number, number));
            run(ROUND, (&walk, temperature), &mut |at| {
                sum += at;
                squares += at * at.transpose();
            });
            let mean = sum / ROUND as f64;
            let spread = squares / ROUND as f64 - &mean * mean.transpose();
            let shape = spread + root * root.transpose() * OF_LINEAR;
            let cooler = temperatures.get(round + 1).unwrap_or(&1.0) / temperature;
            if let Some(shape) = (shape * cooler).cholesky() {
                walk = shape.unpack();
            }
        }
        let (mut sum, mut squares) = (0.0, 0.0);
        run(STEPS, (&walk, 1.0), &mut |at| {
            sum += at[unknown];
            squares += at[unknown] * at[unknown];
        });
        let mean = sum / STEPS as f64;
        [mean, (squares / STEPS as f64 - mean * mean).max(0.0).sqrt()]
    }
}
