//! Small systems of linear equations.

use crate::real::Real;

/// A vector.
pub type Vector = Vec<Real>;
/// Rows of a matrix.
pub type Matrix = Vec<Vector>;

/// Scalar product.
#[must_use]
pub fn dot(a: &[Real], b: &[Real]) -> Real {
    a.iter()
        .zip(b)
        .fold(Real::zero(), |sum, (a, b)| sum + a * b)
}

/// The solution and the determinant; `None` for a singular matrix.
#[must_use]
pub fn solve(mut matrix: Matrix, mut right: Vector) -> Option<(Vector, Real)> {
    let size = right.len();
    let mut determinant = Real::one();
    for column in 0..size {
        let pivot = (column..size).reduce(|best, row| {
            let larger = matrix[row][column].abs() > matrix[best][column].abs();
            if larger { row } else { best }
        })?;
        if matrix[pivot][column].is_zero() || matrix[pivot][column].is_nan() {
            return None;
        }
        if pivot != column {
            matrix.swap(pivot, column);
            right.swap(pivot, column);
            determinant = -determinant;
        }
        determinant = determinant * &matrix[column][column];
        for row in column + 1..size {
            let factor = &matrix[row][column] / &matrix[column][column];
            for at in column..size {
                matrix[row][at] = &matrix[row][at] - &factor * &matrix[column][at];
            }
            right[row] = &right[row] - &factor * &right[column];
        }
    }
    for row in (0..size).rev() {
        let known = dot(&matrix[row][row + 1..], &right[row + 1..]);
        right[row] = (&right[row] - known) / &matrix[row][row];
    }
    Some((right, determinant))
}

/// `[matrix column; column^T 0]`.
#[must_use]
pub fn border(matrix: &Matrix, column: &[Real]) -> Matrix {
    let mut bordered: Matrix = matrix.clone();
    for (row, value) in bordered.iter_mut().zip(column) {
        row.push(value.clone());
    }
    bordered.push(column.iter().cloned().chain([Real::zero()]).collect());
    bordered
}

#[cfg(test)]
mod tests {
    use super::{Real, solve};

    #[test]
    fn a_system_with_a_zero_on_the_diagonal_is_solved() {
        let row = |values: [f64; 2]| values.map(Real::from).to_vec();
        let (solution, determinant) =
            solve(vec![row([0.0, 2.0]), row([3.0, 1.0])], row([4.0, 5.0])).unwrap();
        let values: Vec<f64> = solution.iter().map(Real::to_f64).collect();
        assert_eq!((values, determinant.to_f64()), (vec![1.0, 2.0], -6.0));
        assert!(solve(vec![row([1.0, 1.0]), row([1.0, 1.0])], row([1.0, 2.0])).is_none());
    }
}
