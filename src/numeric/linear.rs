//! Scalar products, and systems of a few linear equations.

// Indices are those of the matrix; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

/// Scalar product, summed in the order of the elements.
pub fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves `a x = b` for several right-hand sides at once.
///
/// `None` where a pivot is zero or a result is not finite. The caller scales rows and columns to a common size.
pub fn solve<const N: usize, const M: usize>(
    a: [[f32; N]; N],
    mut b: [[f32; N]; M],
) -> Option<[[f32; N]; M]> {
    solve_in_place(a, &mut b).then_some(b)
}

/// Solves `a x = b` for each right-hand side in `sides`, which becomes its `x`: Gaussian elimination with row pivoting.
/// False where a pivot is zero or a result is not finite; what is in `sides` then means nothing.
// Not inlined: one copy for each number of unknowns, whatever the number of sides.
#[inline(never)]
pub fn solve_in_place<const N: usize>(mut a: [[f32; N]; N], sides: &mut [[f32; N]]) -> bool {
    for i in 0..N {
        // Brings the largest pivot up by swaps on the way: indices stay those of the loops, which need no bounds check.
        for r in i + 1..N {
            if a[r][i].abs() > a[i][i].abs() {
                for c in i..N {
                    (a[i][c], a[r][c]) = (a[r][c], a[i][c]);
                }
                for side in &mut *sides {
                    (side[i], side[r]) = (side[r], side[i]);
                }
            }
        }
        let pivot = a[i][i];
        if pivot == 0.0 || pivot.is_nan() {
            return false;
        }
        for r in i + 1..N {
            let factor = a[r][i] / pivot;
            for c in i + 1..N {
                a[r][c] -= factor * a[i][c];
            }
            for side in &mut *sides {
                side[r] -= factor * side[i];
            }
        }
    }
    let mut finite = true;
    for side in sides {
        for i in (0..N).rev() {
            let mut sum = side[i];
            for c in i + 1..N {
                sum -= a[i][c] * side[c];
            }
            side[i] = sum / a[i][i];
            finite &= side[i].is_finite();
        }
    }
    finite
}
