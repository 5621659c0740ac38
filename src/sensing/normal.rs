//! Weighted least squares with priors: normal equations of a few whitened unknowns, by Cholesky.
//!
//! Unknowns are whitened: in units of their prior deviation from their prior mean. A prior then adds 1 to the diagonal,
//! which bounds the condition number so that f32 suffices; an unknown that a hypothesis lacks stays at 0.

use crate::numeric::{Bounded, ln, sqrt};
use core::marker::PhantomData;

/// Which of the unknowns of a problem there are.
pub trait Unknowns: Copy + core::fmt::Debug {
    /// The number of those that are missing: the last ones.
    const MISSING: usize = 0;
}

impl Unknowns for () {}

/// Normal equations of `P` unknowns, but for those that `U` says are missing, about a point, and the Cholesky factor of their matrix.
///
/// The matrix is symmetric and stored on and below the diagonal; the factor is stored above.
#[derive(Clone, Copy, Debug)]
pub struct Normal<const P: usize, U: Unknowns = ()> {
    matrix: [[f32; P]; P],
    /// Diagonal of the factor.
    diagonal: [f32; P],
    right: [f32; P],
    unknowns: PhantomData<U>,
}

impl<const P: usize, U: Unknowns> Normal<P, U> {
    /// No information.
    pub const EMPTY: Self = Self {
        matrix: [[0.0; P]; P],
        diagonal: [0.0; P],
        right: [0.0; P],
        unknowns: PhantomData,
    };

    /// Number of unknowns: the last ones are those that may be missing.
    const USED: usize = P - U::MISSING;

    /// Adds a residual (measured less model) with the model's derivatives and the inverse of its variance.
    #[expect(clippy::needless_range_loop, reason = "a triangle of a matrix")]
    pub fn add(&mut self, residual: f32, slopes: &[f32; P], weight: f32) {
        for row in 0..Self::USED {
            let weighted = weight * slopes[row];
            self.right[row] += weighted * residual;
            for column in 0..=row {
                self.matrix[row][column] += weighted * slopes[column];
            }
        }
    }

    /// Starts with the priors of all unknowns, which stand at `values` (whitened): mean 0, variance 1.
    pub fn of_priors(values: &[f32; P]) -> Self {
        let mut normal = Self::EMPTY;
        for (unknown, value) in values.iter().enumerate() {
            normal.set_prior(unknown, *value, 1.0);
        }
        normal
    }

    /// Sets the prior of one unknown that stands at `value`: mean 0, variance 1/`weight`. Call before adding residuals, which it discards.
    // Not inlined: written out for each unknown it would be twice as long.
    #[inline(never)]
    pub fn set_prior(&mut self, unknown: usize, value: f32, weight: f32) {
        let row = self.matrix.get_mut(unknown);
        if let Some(cell) = row.and_then(|row| row.get_mut(unknown)) {
            *cell = weight;
        }
        if let Some(right) = self.right.get_mut(unknown) {
            *right = -weight * value;
        }
    }

    /// Fixes an unknown, so that only the others are solved for. Keeps its diagonal entry: the determinant, and with it the evidence, still
    /// counts the unknown.
    pub fn hold(&mut self, unknown: usize) {
        for (row, cells) in self.matrix.iter_mut().enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                if (row == unknown) != (column == unknown) {
                    *cell = 0.0;
                }
            }
        }
        if let Some(right) = self.right.get_mut(unknown) {
            *right = 0.0;
        }
    }

    /// Shift of one unknown that makes up for a shift of a later one by 1, all others as they are.
    pub fn ratio(&self, later: usize, unknown: usize) -> f32 {
        self.matrix[later][unknown] / self.matrix[unknown][unknown]
    }

    /// Predicted decrease of the sum of squares by a step (quadratic model).
    pub fn promise(&self, step: &[f32; P]) -> f32 {
        let mut gain = 0.0;
        for row in 0..Self::USED {
            let mut along = 0.0;
            for (column, step) in step.iter().enumerate().take(Self::USED) {
                along += self.matrix[row.max(column)][row.min(column)] * step;
            }
            gain += step[row] * (2.0 * self.right[row] - along);
        }
        gain
    }

    /// Factors the matrix, its diagonal raised by `damping` times itself. None unless it is positive definite.
    pub fn factor(&mut self, damping: f32) -> Option<Factor<'_, P, U>> {
        for row in 0..Self::USED {
            for column in 0..=row {
                let mut sum = self.matrix[row][column];
                if row == column {
                    sum *= 1.0 + damping;
                }
                for inner in 0..column {
                    sum -= self.matrix[inner][row] * self.matrix[inner][column];
                }
                if row == column {
                    if !(f32::MIN_POSITIVE..=f32::MAX).contains(&sum) {
                        return None;
                    }
                    self.diagonal[row] = sqrt(sum);
                } else {
                    self.matrix[column][row] = sum / self.diagonal[column];
                }
            }
        }
        Some(Factor { normal: self })
    }
}

/// Normal equations whose matrix has been factored.
#[derive(Clone, Copy, Debug)]
pub struct Factor<'a, const P: usize, U: Unknowns = ()> {
    normal: &'a Normal<P, U>,
}

impl<const P: usize, U: Unknowns> Factor<'_, P, U> {
    /// The step to the minimum.
    pub fn step(&self) -> [f32; P] {
        let mut x = self.normal.right;
        self.solve(&mut x);
        x
    }

    /// Solves for a right-hand side, in place.
    #[inline(never)]
    fn solve(&self, x: &mut [f32; P]) {
        let Normal {
            matrix, diagonal, ..
        } = self.normal;
        for row in 0..Normal::<P, U>::USED {
            let mut sum = x[row];
            for column in 0..row {
                sum -= matrix[column][row] * x[column];
            }
            x[row] = sum / diagonal[row];
        }
        for row in (0..Normal::<P, U>::USED).rev() {
            let mut sum = x[row];
            for column in row + 1..Normal::<P, U>::USED {
                sum -= matrix[row][column] * x[column];
            }
            x[row] = sum / diagonal[row];
        }
    }

    /// Column of the inverse: covariances of one unknown with all.
    pub fn covariance(&self, unknown: usize) -> [f32; P] {
        let mut unit = [0.0; P];
        if let Some(one) = unit.get_mut(unknown) {
            *one = 1.0;
        }
        self.solve(&mut unit);
        unit
    }

    /// Variance of one unknown, not below 0.
    #[inline(never)]
    pub fn variance(&self, unknown: usize) -> f32 {
        let column = self.covariance(unknown);
        column.get(unknown).copied().unwrap_or(0.0).at_least(0.0)
    }

    /// Logarithm of the matrix's determinant.
    pub fn ln_determinant(&self) -> f32 {
        2.0 * self
            .normal
            .diagonal
            .iter()
            .take(Normal::<P, U>::USED)
            .map(|&diagonal| ln(diagonal))
            .sum::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::Normal;

    #[test]
    fn a_line_is_found_with_its_covariance() {
        // y = 2 + 3 x at x = -1, 0, 1 with unit weights: covariance diag(1/3, 1/2).
        let mut normal = Normal::<2>::EMPTY;
        for x in [-1.0f32, 0.0, 1.0] {
            normal.add(2.0 + 3.0 * x, &[1.0, x], 1.0);
        }
        let factor = normal.factor(0.0).unwrap();
        let [offset, slope] = factor.step();
        assert!((offset - 2.0).abs() < 1e-6 && (slope - 3.0).abs() < 1e-6);
        assert!((factor.covariance(0)[0] - 1.0 / 3.0).abs() < 1e-6);
        assert!((factor.covariance(1)[1] - 0.5).abs() < 1e-6);
        assert!(factor.covariance(0)[1].abs() < 1e-6);
        assert!((factor.ln_determinant() - 6.0f32.ln()).abs() < 1e-5);
    }

    #[test]
    fn a_held_unknown_does_not_move_and_counts_in_the_determinant() {
        let mut normal = Normal::<2>::of_priors(&[0.5, 0.0]);
        normal.add(1.0, &[1.0, 1.0], 4.0);
        let mut held = normal;
        held.hold(0);
        let factor = held.factor(0.0).unwrap();
        // Alone, the second has the information 1 + 4, and 4 of the residual; the first has 1 + 4.
        let [still, moved] = factor.step();
        assert!(
            still == 0.0 && (moved - 0.8).abs() < 1e-6,
            "{still} {moved}"
        );
        assert!((factor.ln_determinant() - 25.0f32.ln()).abs() < 3e-4);
        assert!(normal.factor(0.0).unwrap().step()[0] != 0.0);
    }

    #[test]
    fn what_the_data_do_not_tell_is_refused_or_left_to_the_prior() {
        let mut normal = Normal::<2>::EMPTY;
        normal.add(1.0, &[1.0, 0.0], 4.0);
        assert!(normal.factor(0.0).is_none());
        normal.set_prior(1, 0.5, 1.0);
        let factor = normal.factor(0.0).unwrap();
        let step = factor.step();
        assert!((step[0] - 1.0).abs() < 1e-6 && (step[1] + 0.5).abs() < 1e-6);
        assert!((factor.covariance(1)[1] - 1.0).abs() < 1e-6);
        normal.add(f32::NAN, &[f32::NAN, 0.0], 1.0);
        assert!(normal.factor(0.0).is_none());
    }
}
