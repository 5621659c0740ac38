//! The exact posterior of a second contact's place: a curve is drawn with noise, and values of all unknowns are sampled by how likely they
//! make it (Metropolis and Hastings).
//!
//! The chain begins at the truth and is proposed to by the linear solution about it, which only saves time: what it comes to does not
//! depend on either.

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::fisher::{ROUND, SHARED, is_possible, normals};
use super::grasp::{
    Asked, CORNER, Grasp, K, ONSET, RADIUS, RADIUS_THERE, SECOND, UNKNOWNS, Values,
};
use crate::bound::known::{OFFSET_M, UNIFORM};
use crate::reference::Noise;

/// Deviation of a detected onset from the true one, radian.
const DETECTED_RAD: f64 = 0.01;
/// Radii of objects, metre: even in the logarithm of radius plus [`OFFSET_M`].
const RADII_M: [f64; 2] = [0.001, 0.056];
/// Steps of a chain, and those at its beginning that do not count.
const STEPS: usize = 600;
const FORGOTTEN: usize = 100;
/// Width of the proposals about the linear solution, and of steps from where the chain is, over the root of the unknowns' number.
const WIDER: f64 = 1.2;
const WALK: f64 = 1.5;

/// A curve with noise, and what is known beside it.
struct Asking<'a> {
    asked: &'a Asked,
    grasp: &'a Grasp,
    deviations: Values,
    /// Unknowns that are not exact.
    open: Vec<usize>,
    measured: DVector<f64>,
    lower: DMatrix<f64>,
    /// Inverse covariance of what is known beforehand of the finger, in units of the deviations; 0 for exact ones.
    precision: DMatrix<f64>,
    detected_rad: f64,
}

impl Asking<'_> {
    fn values(&self, off: &DVector<f64>) -> Values {
        let mut values = self.grasp.values;
        for (&unknown, off) in self.open.iter().zip(off) {
            values[unknown] += self.deviations[unknown] * off;
        }
        values
    }

    /// Logarithm of the posterior's density, but for a constant; none where the values cannot be.
    fn density(&self, off: &DVector<f64>) -> Option<f64> {
        let values = self.values(off);
        let within = |unknown: usize, [low, high]: [f64; 2]| {
            let value = values[unknown];
            value > low && value < high
        };
        let radii = RADII_M.map(|radius_m| (radius_m + OFFSET_M).ln());
        let length_m = |which: usize| {
            let phalanx = self.grasp.phalanges[which].unwrap_or(1);
            self.asked.known.lengths_m[phalanx - 1]
        };
        let is_within = within(K, [0.0, length_m(0)])
            && within(SECOND, [0.0, length_m(1)])
            && within(RADIUS, radii)
            && within(RADIUS_THERE, radii)
            && within(CORNER, [values[ONSET], f64::INFINITY]);
        if !is_within || !is_possible(&values) {
            return None;
        }
        let means = self.asked.means();
        let shared = DVector::from_fn(SHARED, |unknown, _| {
            let deviation = self.deviations[unknown];
            if deviation > 0.0 {
                (values[unknown] - means[unknown]) / deviation
            } else {
                0.0
            }
        });
        let late = (values[ONSET] - self.detected_rad) / self.deviations[ONSET];
        let shown = self.asked.shown(self.grasp, &values)?;
        if !shown.stays || shown.excess_nm.len() != self.measured.len() {
            return None;
        }
        let left = &self.measured - DVector::from_vec(shown.excess_nm);
        let white = self.lower.solve_lower_triangular(&left)?;
        let shape = shown.shape.unwrap_or_default();
        let round = shape.iter().map(|x| x * x).sum::<f64>() / (ROUND * ROUND);
        let squares = white.norm_squared() + shared.dot(&(&self.precision * &shared));
        Some(-0.5 * (squares + round + late * late))
    }
}

impl Asked {
    /// Error and deviation of the posterior's place, as shares of the phalanx.
    pub(super) fn sampled(
        &self,
        grasp: &Grasp,
        known: &DMatrix<f64>,
        noise: &Noise,
        random: &mut Pcg64Mcg,
    ) -> Option<[f64; 2]> {
        let deviations = self.deviations(grasp.phalanges);
        let open: Vec<usize> = (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0).collect();
        let shown = self.shown(grasp, &grasp.values)?;
        let [slopes, shape] = self.slopes(grasp, &shown, &deviations)?;
        let points = shown.excess_nm.len();
        let lower = self.whitening(grasp, &shown, noise, [0, points])?;
        let noise_nm = &lower * normals(points, random);
        let measured = DVector::from_vec(shown.excess_nm) + &noise_nm;
        let late: f64 = DETECTED_RAD * normals(1, random)[0];
        let precision = of_open(known, &open).try_inverse()?;
        let finger: Vec<usize> = open.iter().copied().filter(|&i| i < SHARED).collect();
        let mut of_finger = DMatrix::zeros(SHARED, SHARED);
        for (row, &i) in finger.iter().enumerate() {
            for (column, &j) in finger.iter().enumerate() {
                of_finger[(i, j)] = precision[(row, column)];
            }
        }
        let asking = Asking {
            asked: self,
            grasp,
            measured,
            lower,
            precision: of_finger,
            detected_rad: grasp.values[ONSET] + late,
            deviations,
            open,
        };
        // The linear solution.
        let white = asking
            .lower
            .solve_lower_triangular(&slopes.select_columns(&asking.open))?;
        let shape = shape.select_columns(&asking.open) / ROUND;
        let matrix = white.tr_mul(&white) + shape.tr_mul(&shape) + &precision;
        let covariance = matrix.try_inverse()?;
        let means = self.means();
        let expected = DVector::from_iterator(
            asking.open.len(),
            asking.open.iter().map(|&unknown| {
                let off = match unknown {
                    ONSET => late,
                    _ if unknown < SHARED => means[unknown] - grasp.values[unknown],
                    _ => 0.0,
                };
                off / asking.deviations[unknown]
            }),
        );
        let noise_white = asking.lower.solve_lower_triangular(&noise_nm)?;
        let middle = &covariance * (white.tr_mul(&noise_white) + &precision * expected);
        let root = ((&covariance + covariance.transpose()) * 0.5)
            .cholesky()?
            .unpack();
        Some(asking.chain(&middle, &root, random))
    }
}

/// Rows and columns of unknowns that are not exact.
fn of_open(matrix: &DMatrix<f64>, open: &[usize]) -> DMatrix<f64> {
    matrix.select_rows(open).select_columns(open)
}

impl Asking<'_> {
    /// Error and deviation of the place by a chain from the truth.
    fn chain(&self, middle: &DVector<f64>, root: &DMatrix<f64>, random: &mut Pcg64Mcg) -> [f64; 2] {
        let number = self.open.len();
        let place = self.open.iter().position(|&unknown| unknown == SECOND);
        let mut at = DVector::zeros(number);
        let mut density = self.density(&at).unwrap_or(f64::NEG_INFINITY);
        // Logarithm of the density of proposals about the linear solution.
        let proposed = |at: &DVector<f64>| {
            let off = root.solve_lower_triangular(&(at - middle));
            off.map_or(0.0, |off| -0.5 * off.norm_squared() / (WIDER * WIDER))
        };
        let (mut sum, mut squares) = (0.0, 0.0);
        for step in 0..STEPS {
            let walks = step % 2 == 1;
            let next = if walks {
                &at + root * normals(number, random) * (WALK / (number as f64).sqrt())
            } else {
                middle + root * normals(number, random) * WIDER
            };
            if let Some(there) = self.density(&next) {
                let mut gain = there - density;
                if !walks {
                    gain += proposed(&at) - proposed(&next);
                }
                if gain >= 0.0 || random.random_range(0.0..1.0) < gain.exp() {
                    (at, density) = (next, there);
                }
            }
            if step >= FORGOTTEN {
                let off = place.map_or(0.0, |place| UNIFORM * at[place]);
                sum += off;
                squares += off * off;
            }
        }
        let counted = (STEPS - FORGOTTEN) as f64;
        let mean = sum / counted;
        [mean, (squares / counted - mean * mean).max(0.0).sqrt()]
    }
}
