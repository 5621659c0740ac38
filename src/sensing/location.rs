//! From a measured tangent stiffness to places: the cable in series and a joint sensor, where a scene has them.
//!
//! Both are types: a scene without cable or sensor carries neither their numbers nor their code.

use crate::finger::error::check_range;
use crate::finger::{Candidate, ConfigError, Inverse, Mechanics, Parameter};

/// Limits of a cable's stiffness at the input link, newton metre per radian.
const CABLE_RANGE: [f32; 2] = [1e-6, 1e9];

/// What lies between the actuator and the input link: it adds to every measured compliance, C_measured = C + 1/K_t
/// (docs/MECHANICS.md#contact-stiffness).
pub trait Series: Copy + core::fmt::Debug {
    /// Whether it gives way at all: only then is there a cable to fit and to calibrate.
    const FLEXIBLE: bool;

    /// 1/K_t, radian per newton metre.
    fn compliance_rad_per_nm(&self) -> f32;
}

/// Nothing that gives way; no size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rigid;

impl Series for Rigid {
    const FLEXIBLE: bool = false;

    fn compliance_rad_per_nm(&self) -> f32 {
        0.0
    }
}

/// An elastic cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cable {
    compliance_rad_per_nm: f32,
}

impl Cable {
    /// A cable of rotational stiffness K_t at the input link, newton metre per radian.
    ///
    /// # Errors
    /// A stiffness that is not within 1e-6 and 1e9.
    pub fn new(stiffness_nm_per_rad: f32) -> Result<Self, ConfigError> {
        let [min, max] = CABLE_RANGE;
        let stiffness = check_range(Parameter::CableStiffness, stiffness_nm_per_rad, min, max)?;
        Ok(Self {
            compliance_rad_per_nm: 1.0 / stiffness,
        })
    }
}

impl Series for Cable {
    const FLEXIBLE: bool = true;

    fn compliance_rad_per_nm(&self) -> f32 {
        self.compliance_rad_per_nm
    }
}

/// Distinguishes the two sides of a phalanx's stiffest place. Below it the phalanx's own joint closes as the torque
/// rises, beyond it the joint opens (docs/MECHANICS.md#observability).
pub trait BranchSense: Copy + core::fmt::Debug {
    /// Whether the sensor's reading supports a candidate.
    fn allows(&self, candidate: &Candidate) -> bool;
}

/// No joint sensor: every candidate stays; no size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoJointSensor;

impl BranchSense for NoJointSensor {
    fn allows(&self, _: &Candidate) -> bool {
        true
    }
}

/// Change of theta_2 since contact by the optional Hall sensor, radian. It says nothing within its own noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTwo {
    /// Change of theta_2 since contact, closing positive.
    pub change_rad: f32,
    /// What of it may be noise.
    pub noise_rad: f32,
}

impl BranchSense for JointTwo {
    fn allows(&self, candidate: &Candidate) -> bool {
        // The sign is that of phalanx 2's own side; of phalanx 3 it says nothing certain.
        let says = candidate.phalanx == 2 && self.change_rad.abs() > self.noise_rad;
        !says || (self.change_rad < 0.0) == candidate.beyond_stiffest
    }
}

/// All places that explain a measured tangent compliance (docs/MECHANICS.md#contact-stiffness and
/// docs/MECHANICS.md#observability), series compliance taken off, with those left out
/// that a joint sensor contradicts.
///
/// A measurement stiffer than the series itself, by noise, is taken for rigid. Sensing that leaves no candidate at all
/// contradicts itself and is not followed.
pub fn places<M: Mechanics>(
    finger: &M,
    at: &M::Configuration,
    torque_nm: f32,
    measured_rad_per_nm: f32,
    series: &impl Series,
    sense: &impl BranchSense,
) -> Inverse {
    let own = measured_rad_per_nm - series.compliance_rad_per_nm();
    // `max` would turn a NaN into a rigid finger.
    let own = if own < 0.0 { 0.0 } else { own };
    finger
        .locate(at, torque_nm, own)
        .retaining(|candidate| sense.allows(candidate))
}
