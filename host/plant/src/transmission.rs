//! Errors between worm and wheel: periodic ones of worm, wheel and gearhead, a non-periodic one, and hysteresis.

use crate::parameters;
use crate::wander::Wander;
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct Transmission {
    parameters: parameters::Transmission,
    worm_phase: f64,
    wheel_phase: f64,
    random: Wander,
    /// State of the hysteresis: 1 after a long closing motion, -1 after opening.
    turned: f64,
}

impl Transmission {
    pub fn new(parameters: &parameters::Transmission, random: &mut Pcg64Mcg) -> Self {
        Self {
            worm_phase: parameters.worm_error_phase_deg.to_radians(),
            wheel_phase: parameters.wheel_error_phase_deg.to_radians(),
            random: Wander::new(
                parameters.random_error_rad,
                TAU * parameters.random_error_worm_revs,
                random,
            ),
            turned: 0.0,
            parameters: *parameters,
        }
    }

    /// Advances by a rotation of the worm (radian) that turned the wheel by `wheel`.
    pub fn advance(&mut self, worm: f64, wheel: f64, random: &mut Pcg64Mcg) {
        self.random.advance(worm, random);
        let share = (wheel.abs() / self.parameters.hysteresis_rad).min(1.0);
        self.turned += share * (wheel.signum() - self.turned);
    }

    /// Load at the wheel including hysteresis.
    pub fn loaded(&self, load: f64) -> f64 {
        load + self.parameters.hysteresis_share * load.abs() * self.turned
    }

    /// Periodic part of the error of the wheel's angle at a position of worm and wheel, radian.
    pub fn periodic_error(&self, worm: f64, wheel: f64) -> f64 {
        let p = &self.parameters;
        p.worm_error_rad * (worm - self.worm_phase).cos()
            + p.wheel_error_rad * (wheel - self.wheel_phase).cos()
            + p.gear_error_rad * (p.gear_error_per_worm_rev * worm).cos()
    }

    /// Error of the wheel's angle at the present position, where the periodic part is this, radian.
    pub fn error(&self, periodic: f64) -> f64 {
        periodic + self.random.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;
    use rand::SeedableRng;

    #[test]
    fn it_repeats_but_for_the_random_part() {
        let mut p = Parameters::default().transmission;
        p.worm_error_rad = 1e-3;
        p.wheel_error_rad = 2e-3;
        p.random_error_rad = 1e-4;
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut transmission = Transmission::new(&p, &mut random);
        let mut pass = || {
            (0..2000)
                .map(|i| {
                    let worm = f64::from(i) * 0.01;
                    transmission.advance(0.01, 0.0005, &mut random);
                    transmission.error(transmission.periodic_error(worm, worm / 20.0))
                })
                .collect::<Vec<_>>()
        };
        let (first, second) = (pass(), pass());
        let square = |a: f64| a * a;
        let n = first.len() as f64;
        let size = first.iter().map(|e| square(*e)).sum::<f64>() / n;
        let apart = first.iter().zip(&second).map(|(a, b)| square(a - b));
        let apart = (apart.sum::<f64>() / n).sqrt();
        assert!(size.sqrt() > 1e-3);
        // Two independent draws: the root of two times the random part.
        assert!((0.5e-4..3e-4).contains(&apart), "{apart}");
    }

    #[test]
    fn hysteresis_takes_its_share_against_the_motion() {
        let mut p = Parameters::default().transmission;
        p.hysteresis_share = 0.02;
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut transmission = Transmission::new(&p, &mut random);
        for (way, expected) in [(1e-4, 0.306), (-1e-4, 0.294)] {
            for _ in 0..1000 {
                transmission.advance(0.0, way, &mut random);
            }
            assert!((transmission.loaded(0.3) - expected).abs() < 1e-9);
        }
    }
}
