//! Posture: joint angles with their cosines and sines, and small steps away from it.

use crate::numeric::Rotation;

/// Joint angles, each relative to the phalanx before it, with their rotations. State, not configuration of the finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration<const N: usize> {
    rad: [f32; N],
    turn: [Rotation; N],
}

impl<const N: usize> Configuration<N> {
    /// The posture of given angles; `None` where one is not finite or beyond two turns.
    pub(crate) const fn of(rad: [f32; N]) -> Option<Self> {
        let (mut turn, mut i) = ([Rotation::NONE; N], 0);
        while i < N {
            // A comparison that NaN fails too.
            let near = rad[i].abs() <= 4.0 * core::f32::consts::PI;
            if !near {
                return None;
            }
            turn[i] = Rotation::by(rad[i]);
            i += 1;
        }
        Some(Self { rad, turn })
    }

    /// Joint angles, radian.
    pub fn rad(&self) -> [f32; N] {
        self.rad
    }

    /// Their rotations.
    pub fn turn(&self) -> [Rotation; N] {
        self.turn
    }

    /// The posture a step away: by rotation, no trigonometric function and no difference of large angles.
    pub(crate) fn advanced(&self, step: &JointStep<N>) -> Self {
        let mut to = *self;
        for j in 0..N {
            to.rad[j] += step.rad[j];
            to.turn[j] = to.turn[j].then(step.half[j].twice());
        }
        to
    }
}

/// Changes of the joint angles, with the rotations of their halves: 1 - cos of a small angle is 2 sin^2 of its half,
/// without cancellation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointStep<const N: usize> {
    /// Changes of the angles, radian.
    pub rad: [f32; N],
    /// Rotations by half of them.
    pub half: [Rotation; N],
}

impl<const N: usize> JointStep<N> {
    /// The step of given changes, radian.
    pub fn of(rad: [f32; N]) -> Self {
        Self {
            rad,
            half: rad.map(|a| Rotation::by(0.5 * a)),
        }
    }
}
