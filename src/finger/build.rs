//! A finger and its validated construction.

use super::error::within;
use super::{ConfigError, Configuration, Parameter, Transmission};
use core::f32::consts::PI;

/// Limits of a phalanx's length: any unit from kilometre to micrometre.
const LENGTH_RANGE: [f32; 2] = [1e-6, 1e6];
/// Limits of a spring's stiffness: beyond, products of two leave the range of f32.
const STIFFNESS_RANGE: [f32; 2] = [1e-9, 1e9];

/// Geometry and springs of a finger of N phalanges. A configuration: plain numbers, checked by [`Finger::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Parameters<const N: usize> {
    /// Lengths l_i of the phalanges, proximal first, metre.
    pub lengths_m: [f32; N],
    /// Stiffnesses K_i of the joints' springs, newton metre per radian. The first may be 0: joint 1 without a spring.
    pub stiffness_nm_per_rad: [f32; N],
    /// Rest angles of the springs, radian.
    pub rest_rad: [f32; N],
    /// Opening and closing stop of each joint, radian; the transmission must work between them.
    pub range_rad: [[f32; 2]; N],
}

/// A finger: immutable once built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Finger<const N: usize, T> {
    pub(crate) parameters: Parameters<N>,
    pub(crate) transmission: T,
    pub(crate) rest: Configuration<N>,
}

impl<const N: usize, T: Transmission<N>> Finger<N, T> {
    /// Checks parameters and transmission, limits included.
    ///
    /// # Errors
    /// The first parameter that is not finite or outside its range: a length (1e-6 to 1e6), a stiffness (1e-9 to 1e9, or
    /// 0 at joint 1), stops (within +-2 pi, in order), a rest angle (between its stops), or what the transmission
    /// rejects.
    pub fn new(parameters: Parameters<N>, design: T::Design) -> Result<Self, ConfigError> {
        for (i, joint) in (0..N).zip(1u8..) {
            within(
                Parameter::Length { phalanx: joint },
                parameters.lengths_m[i],
                LENGTH_RANGE[0],
                LENGTH_RANGE[1],
            )?;
            let stiffness = parameters.stiffness_nm_per_rad[i];
            if !(joint == 1 && stiffness == 0.0) {
                within(
                    Parameter::Stiffness { joint },
                    stiffness,
                    STIFFNESS_RANGE[0],
                    STIFFNESS_RANGE[1],
                )?;
            }
            let [low, high] = parameters.range_rad[i];
            within(Parameter::UpperStop { joint }, high, -2.0 * PI, 2.0 * PI)?;
            within(Parameter::LowerStop { joint }, low, -2.0 * PI, high)?;
            within(
                Parameter::RestAngle { joint },
                parameters.rest_rad[i],
                low,
                high,
            )?;
        }
        let transmission = T::build(design, &parameters)?;
        // The rest angles lie within two turns, just checked: the error below is for a joint angle that is not finite.
        let rest = posture(parameters.rest_rad)?;
        Ok(Self {
            parameters,
            transmission,
            rest,
        })
    }

    /// What the finger was built from.
    pub fn parameters(&self) -> &Parameters<N> {
        &self.parameters
    }

    /// The transmission.
    pub fn transmission(&self) -> &T {
        &self.transmission
    }

    /// A posture from joint angles, radian.
    ///
    /// # Errors
    /// An angle that is not finite or beyond its stops.
    pub fn configuration(&self, rad: [f32; N]) -> Result<Configuration<N>, ConfigError> {
        for (i, joint) in (0..N).zip(1u8..) {
            let [low, high] = self.parameters.range_rad[i];
            within(Parameter::JointAngle { joint }, rad[i], low, high)?;
        }
        posture(rad)
    }
}

fn posture<const N: usize>(rad: [f32; N]) -> Result<Configuration<N>, ConfigError> {
    let worst = rad
        .into_iter()
        .zip(1u8..)
        .find(|(a, _)| a.is_nan() || a.abs() > 4.0 * PI)
        .unwrap_or((0.0, 1));
    Configuration::of(rad).ok_or(ConfigError {
        parameter: Parameter::JointAngle { joint: worst.1 },
        value: worst.0,
        min: -4.0 * PI,
        max: 4.0 * PI,
    })
}
