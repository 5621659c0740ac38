//! The weight of the phalanges, where the finger's springs do not let the motor tell it (docs/FINGERS.md#weight).
//!
//! Phalanx j, with all that it carries, pulls by a constant moment M_j times the sine of the angle between it and gravity; a joint
//! bears the sum of the phalanges beyond it. A type, so that a finger whose weight is not stated carries nothing of it.

use super::build::{BaseJoint, STIFFNESS_RANGE};
use super::error::{check_range, try_const};
use super::mechanics::LONGEST_FINGER;
use super::{Base, ConfigError, Configuration, Finger, Parameter, ReturnCable};
use crate::numeric::Rotation;
use core::f32::consts::PI;

/// Heaviest phalanx: beyond, products of two torques leave the range of f32.
const WEIGHT_RANGE: [f32; 2] = [0.0, 1e9];

/// How a finger hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Direction of gravity in the plane of motion, counterclockwise from phalanx 1 where its joint angle is zero, radian.
    pub gravity_rad: f32,
    /// What acts in that plane, over the stated weight: 1 where the plane is upright, 0 where it is level.
    pub share: f32,
}

/// The weight of a finger's phalanges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// M_j: the moment about its own joint, at right angles to gravity, of phalanx j and what it carries at its end, newton metre.
    moments_nm: [f32; LONGEST_FINGER],
    /// Components of gravity along phalanx 1 where its joint angle is zero, and across it, over the stated weight.
    down: [f32; 2],
}

/// What the weight of some phalanges does, newton metre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pull {
    /// Moment times the cosine of gravity's angle from the phalanx: what closing takes off the torque, by radian.
    pub(super) along: f32,
    /// Moment times its sine: the torque, closing positive.
    pub(super) across: f32,
}

impl Weight {
    /// From the phalanges' lengths, metre, and weights, newton, even along them.
    const fn of<const N: usize>(
        lengths_m: &[f32; N],
        weights_n: [f32; N],
        mounting: Mounting,
    ) -> Result<Self, ConfigError> {
        let [min, max] = WEIGHT_RANGE;
        let mut moments_nm = [0.0; LONGEST_FINGER];
        let (mut j, mut beyond_n) = (N, 0.0);
        while j > 0 {
            j -= 1;
            let parameter = Parameter::Weight {
                phalanx: j as u8 + 1,
            };
            let own_n = try_const!(check_range(parameter, weights_n[j], min, max));
            moments_nm[j] = lengths_m[j] * (0.5 * own_n + beyond_n);
            beyond_n += own_n;
        }
        let gravity_rad = mounting.gravity_rad;
        try_const!(check_range(
            Parameter::Gravity,
            gravity_rad,
            -2.0 * PI,
            2.0 * PI
        ));
        Ok(Self {
            moments_nm,
            down: mounting.down(),
        })
    }

    /// What each phalanx pulls with, newton metre, in a posture.
    pub(super) fn pulls<const N: usize>(&self, at: &Configuration<N>) -> [Pull; N] {
        let [along, across] = self.down;
        let mut pulls = [Pull::default(); N];
        let mut absolute = Rotation::NONE;
        for ((pull, turn), moment) in pulls.iter_mut().zip(at.turn()).zip(self.moments_nm) {
            absolute = absolute.then(turn);
            *pull = Pull {
                along: moment * (along * absolute.cos + across * absolute.sin),
                across: moment * (across * absolute.cos - along * absolute.sin),
            };
        }
        pulls
    }

    /// What each joint bears, newton metre: `across` is the torque g_i, `along` what dg/dtheta lacks of zero about this joint and
    /// any nearer to the base.
    pub(super) fn borne<const N: usize>(&self, at: &Configuration<N>) -> [Pull; N] {
        let mut borne = self.pulls(at);
        let mut beyond = Pull::default();
        for pull in borne.iter_mut().rev() {
            beyond.along += pull.along;
            beyond.across += pull.across;
            *pull = beyond;
        }
        borne
    }
}

impl Mounting {
    /// In a level plane no weight acts.
    pub const LEVEL: Self = Self {
        gravity_rad: 0.0,
        share: 0.0,
    };

    const fn down(self) -> [f32; 2] {
        let Rotation { cos, sin } = Rotation::by(self.gravity_rad);
        [self.share * cos, self.share * sin]
    }
}

/// A base of a finger whose weight is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted<B> {
    base: B,
    weight: Weight,
}

impl<B: BaseJoint> BaseJoint for Weighted<B> {
    const BASE: Base = B::BASE;
    const FIRST_TOUCHING: u8 = B::FIRST_TOUCHING;
    const HOLDS: bool = B::HOLDS;
    const WEIGHS: bool = true;
    const PINS_LEAVE: f32 = B::PINS_LEAVE;

    fn return_cable(&self) -> Option<&ReturnCable> {
        self.base.return_cable()
    }

    fn preload_nm(&self) -> Option<f32> {
        self.base.preload_nm()
    }

    fn weight(&self) -> Option<&Weight> {
        Some(&self.weight)
    }

    fn mounted(mut self, mounting: Mounting) -> Self {
        self.weight.down = mounting.down();
        self
    }
}

impl<const N: usize, T: Copy, B: BaseJoint> Finger<N, T, B> {
    /// The same finger with the weight of its phalanges, newton, even along them.
    ///
    /// # Errors
    /// A weight that is not within 0 and 1e9; a direction of gravity that is not within +-2 pi; no spring at joint 1 (within 1e-9 and
    /// 1e9) and no return cable: there the motor tells the weight.
    pub const fn weighted(
        self,
        weights_n: [f32; N],
        mounting: Mounting,
    ) -> Result<Finger<N, T, Weighted<B>>, ConfigError> {
        let Self {
            parameters,
            transmission,
            base,
            ..
        } = self;
        if !matches!(B::BASE, Base::ReturnCable) {
            let [min, max] = STIFFNESS_RANGE;
            let spring = Parameter::Stiffness { joint: 1 };
            try_const!(check_range(
                spring,
                parameters.stiffness_nm_per_rad[0],
                min,
                max
            ));
        }
        let weight = try_const!(Weight::of(&parameters.lengths_m, weights_n, mounting));
        Finger::assembled(parameters, transmission, Weighted { base, weight })
    }

    /// The same finger mounted otherwise; one whose weight is not stated stays as it is. With values that are not finite it has no
    /// posture.
    #[must_use]
    pub fn mounted(&self, mounting: Mounting) -> Self {
        Self {
            base: self.base.mounted(mounting),
            ..*self
        }
    }
}
