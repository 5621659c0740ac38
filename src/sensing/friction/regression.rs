//! Least squares with regressors that may depend on each other, by the Cholesky factor of the columns' products.
//!
//! Own code: Cholesky factors of libraries end at a column that depends on others, and here it is left out.

// Indices are those of the matrix; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use crate::numeric::sqrt;

/// A pivot below this share of its column counts as zero.
const SINGULAR: f32 = 1e-5;

/// Products of `N` columns, of which the last is to be explained by the others: lower triangle.
pub(super) struct Regression<const N: usize> {
    products: [[f32; N]; N],
}

impl<const N: usize> Regression<N> {
    /// Without any rows.
    pub(super) const fn new() -> Self {
        Self {
            products: [[0.0; N]; N],
        }
    }

    /// Adds a row's products with itself.
    pub(super) fn add(&mut self, row: &[f32; N]) {
        // The hottest loop of the assessment, therefore two lines and two columns at a time; what of that lies above the diagonal is
        // not looked at.
        const { assert!(N.is_multiple_of(2)) };
        let (pairs, lines) = (row.as_chunks::<2>().0, self.products.as_chunks_mut::<2>().0);
        for (i, ([one, two], own)) in lines.iter_mut().zip(pairs).enumerate() {
            let ones = one.as_chunks_mut::<2>().0.iter_mut();
            let twos = two.as_chunks_mut::<2>().0.iter_mut();
            let others = pairs.get(..=i).unwrap_or_default();
            for ((one, two), other) in ones.zip(twos).zip(others) {
                one[0] += own[0] * other[0];
                one[1] += own[0] * other[1];
                two[0] += own[1] * other[0];
                two[1] += own[1] * other[1];
            }
        }
    }

    /// Replaces the products by their Cholesky factor. A regressor that is zero or depends on earlier ones gets a pivot of 0 and is left
    /// out. False if a value is NaN.
    pub(super) fn factor(&mut self) -> bool {
        for i in 0..N {
            let own = self.products[i][i];
            for j in 0..=i {
                let (above, rest) = self.products.split_at_mut(i);
                let line = &mut rest[0];
                let mut sum = line[j];
                if j < i {
                    let other = &above[j];
                    sum -= dot(&line[..j], &other[..j]);
                    let pivot = other[j];
                    line[j] = if pivot > 0.0 { sum / pivot } else { 0.0 };
                } else {
                    sum -= line[..j].iter().map(|value| value * value).sum::<f32>();
                    let least = if i == N - 1 { 0.0 } else { SINGULAR * own };
                    line[j] = if sum > least { sqrt(sum) } else { 0.0 };
                }
                if !line[j].is_finite() {
                    return false;
                }
            }
        }
        true
    }

    /// Coefficients of the regressors after [`Self::factor`]; the last element means nothing.
    pub(super) fn coefficients(&self) -> [f32; N] {
        // Back substitution: the last row of the factor holds the right-hand side.
        let mut coefficients = self.products[N - 1];
        for i in (0..N - 1).rev() {
            let mut sum = coefficients[i];
            for k in i + 1..N - 1 {
                sum -= self.products[k][i] * coefficients[k];
            }
            let pivot = self.products[i][i];
            coefficients[i] = if pivot > 0.0 { sum / pivot } else { 0.0 };
        }
        coefficients
    }

    /// Pivots of the regressors after [`Self::factor`].
    pub(super) fn pivots(&self) -> impl Iterator<Item = f32> {
        let lines = self.products.iter().enumerate().take(N - 1);
        lines.map(|(i, line)| line[i])
    }

    /// What the regressors leave after [`Self::factor`]: root of the sum of its squares.
    pub(super) fn left(&self) -> f32 {
        self.products[N - 1][N - 1]
    }
}

/// Scalar product of what both have.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
