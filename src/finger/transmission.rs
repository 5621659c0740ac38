//! From the joints to the input link.

use super::{ConfigError, Configuration, JointStep, Parameters};

/// First and second derivatives of the input angle by the joint angles in one posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransmissionFactors<const N: usize> {
    /// Transmission factors x_i = d theta_a / d theta_i; x_1 = 1.
    pub x: [f32; N],
    /// W, the Hessian of theta_a: symmetric, first row and column zero. G = T_a W (docs/MECHANICS.md#transmission).
    pub w: [[f32; N]; N],
}

/// What drives the joints: theta_a = theta_1 + F2(theta_2 + F3(theta_3)) (docs/MECHANICS.md#transmission), F3 absent
/// with two phalanges.
pub trait Transmission<const N: usize>: Copy + core::fmt::Debug {
    /// What a user gives: radii or levers.
    type Design: Copy + core::fmt::Debug;

    /// Whether the motor turns joints beyond the first. Where it does not, a contact on phalanx 1 is rigid and the softest
    /// one lies at the tip, otherwise the softest one lies on phalanx 1.
    const COUPLES: bool = true;

    /// Whether tolerances and losses may let a torque do some percent more at one contact than at another: pulleys of a few
    /// millimetres or several stages, but neither one stage of long levers nor none.
    const UNEVEN: bool = true;

    /// Whether its derivatives are the same in every posture. Then torque rises in a straight line with the angle while joint 1 stands
    /// and the springs alone give way; the weight bends it by some percent.
    const CONSTANT: bool = false;

    /// Share of the torque carried to each joint beyond the first that is lost there: mean and deviation.
    const JOINT_LOSS: [f32; 2] = [0.0; 2];

    /// Checks a design against the finger that it shall drive.
    ///
    /// # Errors
    /// A radius or lever outside its range, or a four-bar that does not close over the whole range of the joints.
    fn build(design: Self::Design, finger: &Parameters<N>) -> Result<Self, ConfigError>;

    /// Derivatives in a posture; `None` where the transmission cannot take it or stands in a dead point.
    fn factors(&self, at: &Configuration<N>) -> Option<TransmissionFactors<N>>;

    /// theta_a in a posture, radian, 0 where all joint angles are. A posture that the transmission cannot take counts as
    /// its dead point: finite, but only good for postures that [`super::Finger::configuration`] or the solvers gave.
    fn rotation_rad(&self, at: &Configuration<N>) -> f32;

    /// Change of theta_a over a step, radian, without the cancellation of taking two absolute angles apart.
    fn turned_rad(&self, from: &Configuration<N>, step: &JointStep<N>) -> Option<f32>;

    /// Change of the transmission factors x over a step, again without cancellation.
    fn x_change(&self, from: &Configuration<N>, step: &JointStep<N>) -> Option<[f32; N]>;

    /// Both changes at once, where that saves work.
    fn changes(&self, from: &Configuration<N>, step: &JointStep<N>) -> Option<(f32, [f32; N])> {
        Some((self.turned_rad(from, step)?, self.x_change(from, step)?))
    }
}
