//! Tendon on pulleys: constant transmission factors.

use super::error::{check_range, try_const};
use super::{
    ConfigError, Configuration, JointStep, Parameter, Parameters, Transmission, TransmissionFactors,
};

/// Limits of a pulley's radius, in the unit of the finger's lengths.
const RADIUS_RANGE: [f32; 2] = [1e-6, 1e6];

/// A tendon over pulleys. Its design is the radii, two a stage: r_1, r_2 with two phalanges, r_1 to r_4 with three and so
/// on up to six.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tendon<const N: usize> {
    x: [f32; N],
}

const fn checked<const R: usize>(radii: [f32; R]) -> Result<[f32; R], ConfigError> {
    let [min, max] = RADIUS_RANGE;
    let (mut i, mut pulley) = (0, 1);
    while i < R {
        try_const!(check_range(
            Parameter::PulleyRadius { pulley },
            radii[i],
            min,
            max
        ));
        (i, pulley) = (i + 1, pulley + 1);
    }
    Ok(radii)
}

impl<const N: usize> Tendon<N> {
    fn constant(&self) -> TransmissionFactors<N> {
        TransmissionFactors {
            x: self.x,
            w: [[0.0; N]; N],
        }
    }

    fn sum(&self, rad: &[f32; N]) -> f32 {
        self.x.iter().zip(rad).map(|(x, a)| x * a).sum()
    }
}

/// A tendon for each number of phalanges, with two pulleys a stage.
macro_rules! tendons {
    ($($phalanges:literal on $radii:literal;)*) => { $(
        impl Tendon<$phalanges> {
            pub(crate) const fn of(radii: [f32; $radii]) -> Result<Self, ConfigError> {
                let radii = try_const!(checked(radii));
                let (mut x, mut joint) = ([1.0; $phalanges], 1);
                while joint < $phalanges {
                    x[joint] = x[joint - 1] * (radii[2 * joint - 1] / radii[2 * joint - 2]);
                    joint += 1;
                }
                Ok(Self { x })
            }
        }

        impl Transmission<$phalanges> for Tendon<$phalanges> {
            type Design = [f32; $radii];

            const CONSTANT: bool = true;

            // A pulley in balls takes 1 % of the tension, a plain one 3, a dirty one 8 (R).
            const JOINT_LOSS: [f32; 2] = [0.03, 0.03];

            fn build(design: Self::Design, _: &Parameters<$phalanges>) -> Result<Self, ConfigError> {
                Self::of(design)
            }

            fn factors(&self, _: &Configuration<$phalanges>) -> Option<TransmissionFactors<$phalanges>> {
                Some(self.constant())
            }

            fn rotation_rad(&self, at: &Configuration<$phalanges>) -> f32 {
                self.sum(&at.rad())
            }

            fn turned_rad(
                &self,
                _: &Configuration<$phalanges>,
                step: &JointStep<$phalanges>,
            ) -> Option<f32> {
                Some(self.sum(&step.rad))
            }

            fn x_change(
                &self,
                _: &Configuration<$phalanges>,
                _: &JointStep<$phalanges>,
            ) -> Option<[f32; $phalanges]> {
                Some([0.0; $phalanges])
            }
        }
    )* };
}

tendons! {
    2 on 2;
    3 on 4;
    4 on 6;
    5 on 8;
    6 on 10;
}
