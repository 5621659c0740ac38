//! Linkages of three stages and more: what [`Linkage`] does for one and two, as recursions over the stages.
//!
//! With G_j = F_j(theta_j + G_(j+1)), the rotation of the lever that drives phalanx j, theta_a = theta_1 + G_2.

// Indices are those of the joints; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::error::try_const;
use super::fourbar::{FourBar, Levers, Ratio};
use super::linkage::RANGE_SAMPLES;
use super::{
    ConfigError, Configuration, JointStep, Linkage, Parameters, Transmission, TransmissionFactors,
};
use crate::numeric::Rotation;

impl<const STAGES: usize> Linkage<STAGES> {
    /// F_s', F_s'' and F_s''' of every stage in a posture.
    fn ratios<const N: usize>(&self, at: &Configuration<N>) -> Option<[Ratio; STAGES]> {
        let none = Ratio {
            first: 0.0,
            second: 0.0,
            third: 0.0,
        };
        let (mut ratios, mut beyond, turn) = ([none; STAGES], Rotation::NONE, at.turn());
        for s in (0..STAGES).rev() {
            let driven = turn[s + 1].then(beyond);
            ratios[s] = self.stage[s].ratio(driven)?;
            beyond = self.stage[s].lever(driven);
        }
        Some(ratios)
    }

    fn chain_factors<const N: usize>(
        &self,
        at: &Configuration<N>,
    ) -> Option<TransmissionFactors<N>> {
        let ratios = self.ratios(at)?;
        // Gradient and Hessian of the stages from s on, by the joints they are driven by.
        let (mut x, mut w) = ([0.0f32; N], [[0.0f32; N]; N]);
        for s in (0..STAGES).rev() {
            let Ratio { first, second, .. } = ratios[s];
            x[s + 1] = 1.0;
            for i in s + 1..N {
                for j in s + 1..N {
                    w[i][j] = first * w[i][j] + second * x[i] * x[j];
                }
            }
            for j in s + 1..N {
                x[j] *= first;
            }
        }
        x[0] = 1.0;
        Some(TransmissionFactors { x, w })
    }

    fn chain_rotation<const N: usize>(&self, at: &Configuration<N>) -> f32 {
        let (mut beyond, turn) = (Rotation::NONE, at.turn());
        for s in (0..STAGES).rev() {
            beyond = self.stage[s].lever(turn[s + 1].then(beyond));
        }
        at.rad()[0] + beyond.rad()
    }

    /// Change of theta_a and of the transmission factors over a step.
    fn chain_changes<const N: usize>(
        &self,
        from: &Configuration<N>,
        step: &JointStep<N>,
    ) -> Option<(f32, [f32; N])> {
        let (ratios, turn) = (self.ratios(from)?, from.turn());
        let (mut beyond, mut half) = (Rotation::NONE, Rotation::NONE);
        let mut first_change = [0.0f32; STAGES];
        for s in (0..STAGES).rev() {
            let driven = turn[s + 1].then(beyond);
            let advance = self.stage[s].advance(driven, step.half[s + 1].then(half))?;
            beyond = self.stage[s].lever(driven);
            half = advance.half;
            first_change[s] = advance.first_change;
        }
        // x_j is a product over the stages up to j: the product rule, without a difference of two products.
        let (mut change, mut x, mut x_change) = ([0.0f32; N], 1.0f32, 0.0f32);
        for s in 0..STAGES {
            let now = ratios[s].first + first_change[s];
            x_change = x_change * now + x * first_change[s];
            x *= ratios[s].first;
            change[s + 1] = x_change;
        }
        Some((step.rad[0] + 2.0 * half.rad(), change))
    }
}

/// A linkage for each number of phalanges beyond three.
macro_rules! long_linkages {
    ($($phalanges:literal with $stages:literal;)*) => { $(
        impl Linkage<$stages> {
            pub(crate) const fn of(
                levers: [Levers; $stages],
                finger: &Parameters<$phalanges>,
            ) -> Result<Self, ConfigError> {
                const LAST: usize = $stages - 1;
                let mut range = finger.range_rad[LAST + 1];
                let last = FourBar::build($stages, finger.lengths_m[LAST], levers[LAST], range);
                let (mut stage, mut s) = ([try_const!(last); $stages], LAST);
                while s > 0 {
                    // A stage sees its joint turned by what the stage beyond gives; see `Linkage<2>`.
                    let ([low, high], mut sample) = (range, 0);
                    let (mut least, mut most) = (0.0f32, 0.0f32);
                    while sample <= RANGE_SAMPLES {
                        let share = sample as f32 / RANGE_SAMPLES as f32;
                        let driven = Rotation::by(low + share * (high - low));
                        let turned = stage[s].constant_lever(driven).rad();
                        (least, most) = (least.min(turned), most.max(turned));
                        sample += 1;
                    }
                    let [joint_low, joint_high] = finger.range_rad[s];
                    range = [joint_low + least, joint_high + most];
                    s -= 1;
                    let ground = finger.lengths_m[s];
                    stage[s] = try_const!(FourBar::build(s as u8 + 1, ground, levers[s], range));
                }
                Ok(Self { stage })
            }
        }

        impl Transmission<$phalanges> for Linkage<$stages> {
            type Design = [Levers; $stages];

            fn build(
                design: Self::Design,
                finger: &Parameters<$phalanges>,
            ) -> Result<Self, ConfigError> {
                Self::of(design, finger)
            }

            fn factors(
                &self,
                at: &Configuration<$phalanges>,
            ) -> Option<TransmissionFactors<$phalanges>> {
                self.chain_factors(at)
            }

            fn rotation_rad(&self, at: &Configuration<$phalanges>) -> f32 {
                self.chain_rotation(at)
            }

            fn turned_rad(
                &self,
                from: &Configuration<$phalanges>,
                step: &JointStep<$phalanges>,
            ) -> Option<f32> {
                self.chain_changes(from, step).map(|(turned, _)| turned)
            }

            fn x_change(
                &self,
                from: &Configuration<$phalanges>,
                step: &JointStep<$phalanges>,
            ) -> Option<[f32; $phalanges]> {
                self.chain_changes(from, step).map(|(_, change)| change)
            }

            fn changes(
                &self,
                from: &Configuration<$phalanges>,
                step: &JointStep<$phalanges>,
            ) -> Option<(f32, [f32; $phalanges])> {
                self.chain_changes(from, step)
            }
        }
    )* };
}

long_linkages! {
    4 with 3;
    5 with 4;
    6 with 5;
}
