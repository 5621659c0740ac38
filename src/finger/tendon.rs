//! Tendon on pulleys: constant transmission factors.

use super::error::{check_range, try_const};
use super::{
    ConfigError, Configuration, JointStep, Parameter, Parameters, Transmission, TransmissionFactors,
};

/// Limits of a pulley's radius, in the unit of the finger's lengths.
const RADIUS_RANGE: [f32; 2] = [1e-6, 1e6];

/// A tendon over pulleys. Its design is the radii: r_1, r_2 with two phalanges, r_1 to r_4 with three.
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

impl Tendon<2> {
    pub(crate) const fn of(radii: [f32; 2]) -> Result<Self, ConfigError> {
        let [r1, r2] = try_const!(checked(radii));
        Ok(Self { x: [1.0, r2 / r1] })
    }
}

impl Tendon<3> {
    pub(crate) const fn of(radii: [f32; 4]) -> Result<Self, ConfigError> {
        let [r1, r2, r3, r4] = try_const!(checked(radii));
        Ok(Self {
            x: [1.0, r2 / r1, (r2 / r1) * (r4 / r3)],
        })
    }
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

impl Transmission<2> for Tendon<2> {
    type Design = [f32; 2];

    fn build(design: Self::Design, _: &Parameters<2>) -> Result<Self, ConfigError> {
        Self::of(design)
    }

    fn factors(&self, _: &Configuration<2>) -> Option<TransmissionFactors<2>> {
        Some(self.constant())
    }

    fn rotation_rad(&self, at: &Configuration<2>) -> f32 {
        self.sum(&at.rad())
    }

    fn turned_rad(&self, _: &Configuration<2>, step: &JointStep<2>) -> Option<f32> {
        Some(self.sum(&step.rad))
    }

    fn x_change(&self, _: &Configuration<2>, _: &JointStep<2>) -> Option<[f32; 2]> {
        Some([0.0; 2])
    }
}

impl Transmission<3> for Tendon<3> {
    type Design = [f32; 4];

    fn build(design: Self::Design, _: &Parameters<3>) -> Result<Self, ConfigError> {
        Self::of(design)
    }

    fn factors(&self, _: &Configuration<3>) -> Option<TransmissionFactors<3>> {
        Some(self.constant())
    }

    fn rotation_rad(&self, at: &Configuration<3>) -> f32 {
        self.sum(&at.rad())
    }

    fn turned_rad(&self, _: &Configuration<3>, step: &JointStep<3>) -> Option<f32> {
        Some(self.sum(&step.rad))
    }

    fn x_change(&self, _: &Configuration<3>, _: &JointStep<3>) -> Option<[f32; 3]> {
        Some([0.0; 3])
    }
}
