//! The exact posterior of a second contact's place: a curve is drawn with noise, and values of all unknowns are sampled by how likely they
//! make it ([`Linear::sampled`]).

use nalgebra::{DMatrix, DVector};
use rand_pcg::Pcg64Mcg;

use super::fisher::{ROUND, SHARED};
use super::grasp::{
    Asked, CORNER, FRICTION, Grasp, K, ONSET, RADIUS, RADIUS_THERE, SECOND, UNKNOWNS, Values,
};
use crate::bound::chain::{Linear, normals, of_open};
use crate::bound::known::{DETECTED_RAD, OFFSET_M, RADII_M, UNIFORM, is_possible};
use crate::reference::Noise;

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
        if !is_within || !is_possible(&values, &[FRICTION]) {
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
        let beside = shape.tr_mul(&shape);
        let linear = Linear::of([&white, &beside], &noise_white, (&expected, &precision))?;
        let place = asking.open.iter().position(|&unknown| unknown == SECOND)?;
        let sampled = linear.sampled(place, |off| asking.density(off), random);
        Some(sampled.map(|off| UNIFORM * off))
    }
}
