//! Recursive least squares of a few unknowns.

use super::dot;

/// Variance of every unknown before the first equation. The caller scales unknowns to some size of one.
const UNKNOWN: f32 = 1e4;

/// Unknowns `x` of equations `y = a x + noise`, taken one at a time in constant memory, with their covariance.
///
/// Unknowns that no equation mentions stay zero. Rounding: with 1,000 equations and unknowns of size one, `x` differs from the
/// solution in f64 by less than 1e-4 (test).
#[derive(Clone, Debug)]
pub struct LeastSquares<const N: usize> {
    x: [f32; N],
    /// Covariance for noise of variance one.
    p: [[f32; N]; N],
    squares: f32,
    equations: f32,
}

impl<const N: usize> LeastSquares<N> {
    /// Nothing known.
    pub fn new() -> Self {
        let mut p = [[0.0; N]; N];
        for (i, row) in p.iter_mut().enumerate() {
            row[i] = UNKNOWN;
        }
        Self {
            x: [0.0; N],
            p,
            squares: 0.0,
            equations: 0.0,
        }
    }

    /// Takes the equation `y = a x`.
    pub fn add(&mut self, a: &[f32; N], y: f32) {
        let mut pa = [0.0; N];
        for (sum, row) in pa.iter_mut().zip(&self.p) {
            *sum = dot(row, a);
        }
        let denominator = 1.0 + dot(&pa, a);
        let error = y - dot(&self.x, a);
        // The residual before and the one after this equation: their product sums up to the residuals' squares of the end.
        self.squares += error * error / denominator;
        self.equations += 1.0;
        let gain = error / denominator;
        for (x, pa) in self.x.iter_mut().zip(&pa) {
            *x += gain * pa;
        }
        for (row, left) in self.p.iter_mut().zip(&pa) {
            for (entry, right) in row.iter_mut().zip(&pa) {
                // Symmetric, product by product: rounding cannot make it lean.
                *entry -= left * right / denominator;
            }
        }
    }

    /// The unknowns.
    pub fn solution(&self) -> &[f32; N] {
        &self.x
    }

    /// Variance of `c x` by the scatter of the residuals, where these are independent of each other; not a number before there
    /// are more equations than unknowns.
    pub fn variance(&self, c: &[f32; N]) -> f32 {
        let mut sum = 0.0;
        for (row, c_i) in self.p.iter().zip(c) {
            sum += c_i * dot(row, c);
        }
        let excess = self.equations - N as f32;
        if excess > 0.0 {
            sum * self.squares / excess
        } else {
            f32::NAN
        }
    }
}

impl<const N: usize> Default for LeastSquares<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform, -1 to 1.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    const TRUE: [f64; 3] = [0.7, -1.3, 0.2];

    fn estimated(random: &mut Random, equations: usize, noise: f64) -> LeastSquares<3> {
        let mut squares = LeastSquares::new();
        for _ in 0..equations {
            // A constant beside two that vary little: about what pulses of a motor give.
            let a = [0.5 + 0.2 * random.next(), 0.5 + 0.5 * random.next(), 1.0];
            let y: f64 = a.iter().zip(TRUE).map(|(a, x)| a * x).sum();
            let y = y + noise * random.next();
            squares.add(&a.map(|a| a as f32), y as f32);
        }
        squares
    }

    #[test]
    fn equations_without_noise_give_the_unknowns() {
        let squares = estimated(&mut Random(7), 1000, 0.0);
        for (x, wanted) in squares.solution().iter().zip(TRUE) {
            assert!((f64::from(*x) - wanted).abs() < 1e-4, "{x} {wanted}");
        }
    }

    #[test]
    fn errors_have_the_variance_that_is_stated() {
        let mut random = Random(11);
        let mut sums = [0.0; 3];
        const RUNS: usize = 300;
        for _ in 0..RUNS {
            let squares = estimated(&mut random, 200, 0.1);
            for (i, sum) in sums.iter_mut().enumerate() {
                let mut c = [0.0; 3];
                c[i] = 1.0;
                let error = f64::from(squares.solution()[i]) - TRUE[i];
                *sum += error * error / f64::from(squares.variance(&c)) / RUNS as f64;
            }
        }
        // The mean of 300 squares of unit variance scatters by 8 %.
        assert!(sums.iter().all(|z| (0.7..1.3).contains(z)), "{sums:?}");
    }

    #[test]
    fn what_no_equation_mentions_stays_zero_and_too_few_state_no_variance() {
        let mut squares = LeastSquares::<2>::new();
        for y in [1.0, 1.0, 1.0] {
            assert!(squares.variance(&[1.0, 0.0]).is_nan());
            squares.add(&[1.0, 0.0], y);
        }
        assert!(squares.variance(&[1.0, 0.0]) < 1e-4);
        assert!((squares.solution()[0] - 1.0).abs() < 1e-4);
        assert_eq!(squares.solution()[1].to_bits(), 0);
    }
}
