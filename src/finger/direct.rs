//! A motor at every joint: the one that is asked turns joint 1 alone (docs/FINGERS.md#one-motor-a-joint).

use super::error::ConfigError;
use super::{Configuration, JointStep, Parameters, Transmission, TransmissionFactors};

/// No transmission: the motor turns joint 1. Every joint beyond it has a motor of its own behind a self-locking worm, which
/// holds it through a spring: its stiffness and rest angle are those of the joint in [`Parameters`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direct<const N: usize>;

impl<const N: usize> Direct<N> {
    /// x: the input link is joint 1.
    const X: [f32; N] = {
        let mut x = [0.0; N];
        x[0] = 1.0;
        x
    };
}

impl<const N: usize> Transmission<N> for Direct<N> {
    type Design = ();

    const COUPLES: bool = false;
    const UNEVEN: bool = false;

    fn build((): (), _: &Parameters<N>) -> Result<Self, ConfigError> {
        Ok(Self)
    }

    fn factors(&self, _: &Configuration<N>) -> Option<TransmissionFactors<N>> {
        Some(TransmissionFactors {
            x: Self::X,
            w: [[0.0; N]; N],
        })
    }

    fn rotation_rad(&self, at: &Configuration<N>) -> f32 {
        at.rad()[0]
    }

    fn turned_rad(&self, _: &Configuration<N>, step: &JointStep<N>) -> Option<f32> {
        Some(step.rad[0])
    }

    fn x_change(&self, _: &Configuration<N>, _: &JointStep<N>) -> Option<[f32; N]> {
        Some([0.0; N])
    }
}
