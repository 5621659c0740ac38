//! Wander: an Ornstein-Uhlenbeck process, over time or distance.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Configuration and state. With an rms of zero no random number is drawn, so that other noise does not change.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wander {
    rms: f64,
    scale: f64,
    /// Time or distance since the last draw.
    passed: f64,
    value: f64,
}

impl Wander {
    /// `scale`: correlation time or distance, in the unit of [`Wander::advance`]. The first value is drawn from its distribution.
    pub fn new(rms: f64, scale: f64, random: &mut Pcg64Mcg) -> Self {
        let mut new = Self {
            rms,
            scale,
            ..Self::default()
        };
        if rms > 0.0 {
            let normal: f64 = StandardNormal.sample(random);
            new.value = rms * normal;
        }
        new
    }

    /// Advances time or distance; the value is drawn again after each fiftieth of the scale.
    pub fn advance(&mut self, passed: f64, random: &mut Pcg64Mcg) {
        if self.rms <= 0.0 {
            return;
        }
        self.passed += passed.abs();
        if self.passed < 0.02 * self.scale {
            return;
        }
        let kept = (-self.passed / self.scale).exp();
        let normal: f64 = StandardNormal.sample(random);
        self.value = kept * self.value + self.rms * (1.0 - kept * kept).sqrt() * normal;
        self.passed = 0.0;
    }

    /// The present value.
    pub fn value(&self) -> f64 {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn it_has_its_rms_and_forgets_over_its_scale() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let mut wander = Wander::new(0.03, 2.0, &mut random);
        let mut values = Vec::new();
        // 40,000 s in steps of 0.05 s.
        for _ in 0..800_000 {
            wander.advance(0.05, &mut random);
            values.push(wander.value());
        }
        let mean_product = |lag: usize| {
            let pairs = values.iter().zip(&values[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (values.len() - lag) as f64
        };
        let variance = mean_product(0);
        assert!((variance.sqrt() / 0.03 - 1.0).abs() < 0.05, "{variance}");
        // After one scale, 40 steps, the correlation is 1/e.
        let left = mean_product(40) / variance;
        assert!((left - (-1.0f64).exp()).abs() < 0.05, "{left}");
    }

    #[test]
    fn without_rms_it_draws_nothing() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let before = random.clone();
        let mut wander = Wander::new(0.0, 1.0, &mut random);
        wander.advance(10.0, &mut random);
        assert_eq!((wander.value(), random), (0.0, before));
    }
}
