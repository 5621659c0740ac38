//! The model: the contact path through the curve's points, and how far they lie from it.

use super::unknowns::{K, Values};
use super::{Hypothesis, Place, Prior, UNKNOWNS};
use crate::finger::{Contact, Free, MAX_PHALANGES, Mechanics, PathPoint};
use crate::numeric::ln;
use crate::sensing::Drivetrain;
use crate::sensing::curve::{BINS, Point};

/// Deviation of a measured angle from any model, radian: four counts of the encoder's periodic error and as much again.
const ANGLE_SIGMA_RAD: f32 = 4e-5;
/// What the model does not know of the cable, as a share of the twist (R, chosen).
const TWIST_SHARE: f32 = 0.001;
/// Wobble of the gears' efficiency, as a share of the torque (R, chosen).
const TORQUE_SHARE: f32 = 0.002;
/// What a point beyond the end of a path counts for: three standard deviations.
const UNREACHED: f32 = 9.0;

/// The curve with what turns its numbers into a model's.
#[derive(Clone, Copy, Debug)]
pub struct Data<'a> {
    /// Points, by rising angle.
    pub points: &'a [Point],
    /// Angle theta_a at the curve's origin, radian.
    pub origin_rad: f32,
    /// The drivetrain.
    pub drivetrain: &'a Drivetrain,
}

/// One pass over the points.
pub(super) struct Pass {
    pub(super) rotation: [f32; BINS],
    pub(super) compliance: [f32; BINS],
    pub(super) reached: usize,
    pub(super) end: PathPoint,
}

impl Pass {
    const NONE: Self = Self {
        rotation: [0.0; BINS],
        compliance: [0.0; BINS],
        reached: 0,
        end: PathPoint {
            rotation_rad: 0.0,
            compliance_rad_per_nm: 0.0,
            k_now_m: 0.0,
            force_n: 0.0,
            joints_rad: [0.0; MAX_PHALANGES],
        },
    };
}

impl Hypothesis {
    /// Follows the path through the points.
    pub(super) fn follow<F: Mechanics>(
        &self,
        finger: &F,
        onset: &Free<F::Configuration>,
        values: &Values,
        points: &[Point],
    ) -> Pass {
        let mut pass = Pass::NONE;
        let contact = Contact {
            phalanx: self.phalanx,
            k_m: if self.is_proximal() {
                0.5 * finger.phalanx_length_m(1).unwrap_or(0.0)
            } else {
                values.k_m
            },
            radius_m: if self.is_proximal() {
                0.0
            } else {
                values.radius_m
            },
        };
        let at_onset = if self.is_proximal() {
            finger.proximal_compliance(&onset.configuration, onset.torque_nm)
        } else {
            finger.contact_compliance(
                &onset.configuration,
                onset.torque_nm,
                self.phalanx,
                values.k_m,
            )
        };
        let (Some(mut path), Some(at_onset)) = (
            finger.path(&onset.configuration, onset.torque_nm, contact),
            at_onset,
        ) else {
            return pass;
        };
        for ((point, rotation), compliance) in points
            .iter()
            .zip(&mut pass.rotation)
            .zip(&mut pass.compliance)
        {
            let torque_nm = values.factor * values.torque_nm(point);
            if torque_nm <= onset.torque_nm {
                // Noise took the torque below that of the contact: the path's tangent goes on.
                *rotation = at_onset * (torque_nm - onset.torque_nm);
                *compliance = at_onset;
            } else {
                let Some(end) = finger.follow(&mut path, torque_nm - onset.torque_nm) else {
                    break;
                };
                *rotation = end.rotation_rad;
                *compliance = end.compliance_rad_per_nm;
                pass.end = end;
            }
            pass.reached += 1;
        }
        pass
    }

    /// Residual of a point, its variance, and the slope of the model's angle over the nominal torque.
    pub(super) fn residual(
        data: &Data,
        point: &Point,
        values: &Values,
        contact_torque_nm: f32,
        rotation: f32,
        compliance: f32,
    ) -> (f32, f32, f32) {
        let excess = values.torque_nm(point) - contact_torque_nm / values.factor;
        let twist = values.cable * (excess + values.creep * point.late_nm);
        let slope = values.factor * compliance + values.cable;
        let measured =
            data.origin_rad - values.onset_rad + point.counts * data.drivetrain.rad_per_count;
        let wobble = TORQUE_SHARE * excess;
        let torque_variance = point.variance_nm2 + wobble * wobble;
        let model = TWIST_SHARE * twist;
        let variance =
            slope * slope * torque_variance + ANGLE_SIGMA_RAD * ANGLE_SIGMA_RAD + model * model;
        (measured - rotation - twist, variance, slope)
    }

    /// Sum of squares with priors and logarithms; sum of squares alone.
    pub(super) fn cost(
        &self,
        x: &[f32; UNKNOWNS],
        data: &Data,
        values: &Values,
        contact_torque_nm: f32,
        pass: &Pass,
        prior: &Prior,
    ) -> (f32, f32) {
        let mut squares = 0.0;
        let mut logarithms = 0.0;
        let mut last = 0.0;
        for (index, point) in data.points.iter().enumerate() {
            let (Some(&rotation), Some(&compliance)) =
                (pass.rotation.get(index), pass.compliance.get(index))
            else {
                break;
            };
            if index >= pass.reached {
                squares += UNREACHED;
                logarithms += last;
                continue;
            }
            let (residual, variance, _) =
                Self::residual(data, point, values, contact_torque_nm, rotation, compliance);
            squares += residual * residual / variance;
            last = ln(variance);
            logarithms += last;
        }
        let mut priors = 0.0;
        for (unknown, value) in x.iter().enumerate() {
            if unknown != K || matches!(prior.place, Place::Known { .. }) {
                priors += value * value;
            }
        }
        (squares + logarithms + priors, squares)
    }
}
