//! From a measured tangent stiffness to places: the cable in series is taken off, a joint sensor decides between places.
//!
//! The cable is a type: a scene without one carries neither its numbers nor its code.

use crate::finger::error::check_range;
use crate::finger::{Candidate, ConfigError, Inverse, Mechanics, Parameter};
use crate::joint_sensor::Side;

/// Limits of a cable's stiffness at the input link, newton metre per radian.
const CABLE_RANGE: [f32; 2] = [1e-6, 1e9];

/// What lies between the actuator and the input link: it adds to every measured compliance, C_measured = C + 1/K_t
/// (docs/MECHANICS.md#contact-stiffness).
pub trait SeriesElement: Copy + core::fmt::Debug {
    /// Whether it is elastic: only then is there a cable to fit and to calibrate.
    const FLEXIBLE: bool;

    /// Whether the object may be soft: only then is its compliance fitted ([`SoftObject`]).
    const OBJECT_GIVES: bool = false;

    /// 1/K_t, radian per newton metre.
    fn compliance_rad_per_nm(&self) -> f32;
}

/// A rigid connection; no size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rigid;

impl SeriesElement for Rigid {
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

impl SeriesElement for Cable {
    const FLEXIBLE: bool = true;

    fn compliance_rad_per_nm(&self) -> f32 {
        self.compliance_rad_per_nm
    }
}

/// What lies in series where objects may be soft: `X`, and on the finger's other side the object itself
/// (docs/MECHANICS.md#soft-objects).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SoftObject<X>(pub X);

impl<X: SeriesElement> SeriesElement for SoftObject<X> {
    const FLEXIBLE: bool = X::FLEXIBLE;
    const OBJECT_GIVES: bool = true;

    fn compliance_rad_per_nm(&self) -> f32 {
        self.0.compliance_rad_per_nm()
    }
}

/// Whether what a sensor of joint 2 indicates, if there is one, supports a candidate. The side is that of phalanx 2's own
/// stiffest place; of another phalanx it says nothing certain.
pub(super) fn supports(side: Option<Side>, candidate: &Candidate) -> bool {
    match side {
        Some(Side::Below) => candidate.phalanx != 2 || !candidate.beyond_stiffest,
        Some(Side::Beyond) => candidate.phalanx != 2 || candidate.beyond_stiffest,
        Some(Side::Unclear) | None => true,
    }
}

/// All places that explain a measured tangent compliance (docs/MECHANICS.md#contact-stiffness and
/// docs/MECHANICS.md#observability), series compliance taken off, without those that
/// a joint sensor contradicts (`side`; `None` without one).
///
/// A measurement stiffer than the cable itself, because of noise, is taken as rigid. Where the sensor contradicts every
/// candidate, all of them stay.
pub fn places<M: Mechanics>(
    finger: &M,
    at: &M::Configuration,
    torque_nm: f32,
    measured_rad_per_nm: f32,
    series: &impl SeriesElement,
    side: Option<Side>,
) -> Inverse {
    let own = measured_rad_per_nm - series.compliance_rad_per_nm();
    // Not `max`, which would turn a NaN into a rigid finger.
    let own = if own < 0.0 { 0.0 } else { own };
    finger
        .locate(at, torque_nm, own)
        .retaining(|candidate| supports(side, candidate))
}
