//! A normal distribution truncated at zero, for quantities that cannot be negative.

use super::{Bounded, exp, sqrt};

/// Density of the standard normal distribution at zero.
const PEAK: f32 = 0.398_942_3;
/// A logistic curve of this rate is the normal distribution within 0.0095.
const LOGISTIC: f32 = 1.702;

/// Returns mean and deviation of a normal distribution truncated at zero, from those of the whole one. Valid for means >= 0, where
/// both are within 2 % of the deviation.
pub fn not_negative([mean, deviation]: [f32; 2]) -> [f32; 2] {
    let known = deviation > 0.0;
    if !known {
        return [mean, deviation];
    }
    let at = mean / deviation;
    let ratio = PEAK * exp(-0.5 * at * at) * (1.0 + exp(-LOGISTIC * at));
    let left = 1.0 - ratio * (at + ratio);
    [
        mean + deviation * ratio,
        deviation * sqrt(left.at_least(0.0)),
    ]
}

#[cfg(test)]
mod tests {
    use super::not_negative;

    /// By sums over a million steps, in double precision.
    fn summed(mean: f64, deviation: f64) -> [f64; 2] {
        let mut sums = [0.0; 3];
        let steps = 1_000_000;
        for step in 0..steps {
            let x = (f64::from(step) + 0.5) / f64::from(steps) * (mean.abs() + 12.0 * deviation);
            let off = (x - mean) / deviation;
            let weight = (-0.5 * off * off).exp();
            sums = [
                sums[0] + weight,
                sums[1] + weight * x,
                sums[2] + weight * x * x,
            ];
        }
        let [all, first, second] = sums;
        let middle = first / all;
        [middle, (second / all - middle * middle).sqrt()]
    }

    #[test]
    fn moments_are_those_of_the_distribution_that_is_left() {
        for mean in [0.0f32, 0.25, 1.0, 2.0, 4.0] {
            let deviation = 0.4;
            let found = not_negative([mean * deviation, deviation]);
            let truth = summed(f64::from(mean * deviation), f64::from(deviation));
            for (found, truth) in found.into_iter().zip(truth) {
                let off = (f64::from(found) - truth).abs() / f64::from(deviation);
                assert!(off < 0.02, "{mean}: {found} {truth}");
            }
        }
    }

    #[test]
    fn what_is_certain_stays() {
        assert_eq!(not_negative([0.3, 0.0]), [0.3, 0.0]);
        let [mean, deviation] = not_negative([1.0, 0.01]);
        assert!((mean - 1.0).abs() < 1e-6 && (deviation - 0.01).abs() < 1e-6);
    }
}
