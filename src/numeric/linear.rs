//! Systems of a few linear equations.

// Indices are those of the matrix; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

/// Solves `a x = b` for several right-hand sides at once: Gaussian elimination with row pivoting, in place.
///
/// `None` where a pivot is zero or a result is not finite. The caller scales rows and columns to a common size.
pub fn solve<const N: usize, const M: usize>(
    mut a: [[f32; N]; N],
    mut b: [[f32; N]; M],
) -> Option<[[f32; N]; M]> {
    for i in 0..N {
        // Brings the largest pivot up by swaps on the way: indices stay those of the loops, which need no bounds check.
        for r in i + 1..N {
            if a[r][i].abs() > a[i][i].abs() {
                a.swap(i, r);
                for side in &mut b {
                    side.swap(i, r);
                }
            }
        }
        let pivot = a[i][i];
        if pivot == 0.0 || pivot.is_nan() {
            return None;
        }
        for r in i + 1..N {
            let factor = a[r][i] / pivot;
            for c in i + 1..N {
                a[r][c] -= factor * a[i][c];
            }
            for side in &mut b {
                side[r] -= factor * side[i];
            }
        }
    }
    for side in &mut b {
        for i in (0..N).rev() {
            let mut sum = side[i];
            for c in i + 1..N {
                sum -= a[i][c] * side[c];
            }
            side[i] = sum / a[i][i];
        }
    }
    b.iter().flatten().all(|x| x.is_finite()).then_some(b)
}
