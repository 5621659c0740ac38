//! The model: the contact path through the curve's points, and how far they lie from it.

use super::Hypothesis;
use super::rows::Rows;
use super::unknowns::{CABLE, CREEP, FACTOR, K, ONSET, RADIUS, Values, torque_nm};
use crate::finger::{Contact, Free, Mechanics, PathPoint};
use crate::numeric::ln;
use crate::sensing::Drivetrain;
use crate::sensing::curve::Point;
use crate::sensing::location::Series;

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
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pass {
    /// Points that the path reached.
    pub(super) reached: usize,
    /// Sum of squared residuals over their variances.
    pub(super) squares: f32,
    /// Sum of the variances' logarithms.
    pub(super) logarithms: f32,
    /// End of the path.
    pub(super) end: PathPoint,
}

/// The model at one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// Torque without offset and error of the inertia, newton metre.
    pub(super) torque_nm: f32,
    /// What of it is above that of the contact, newton metre.
    pub(super) excess_nm: f32,
    /// Rotation of the input link since contact, and its derivatives.
    pub(super) path: PathPoint,
    /// Measured less model, radian.
    pub(super) residual_rad: f32,
    /// Its variance, radian squared.
    pub(super) variance_rad2: f32,
    /// Slope of the model's angle over the nominal torque, radian per newton metre.
    pub(super) slope_rad_per_nm: f32,
}

impl Local {
    fn new(
        data: &Data,
        point: &Point,
        values: &Values,
        contact_torque_nm: f32,
        path: PathPoint,
    ) -> Self {
        let torque_nm = torque_nm(values, point);
        let excess = torque_nm - contact_torque_nm / values[FACTOR];
        let twist = values[CABLE] * (excess + values[CREEP] * point.late_nm);
        let slope = values[FACTOR] * path.compliance_rad_per_nm + values[CABLE];
        let measured =
            data.origin_rad - values[ONSET] + point.counts * data.drivetrain.rad_per_count;
        let wobble = TORQUE_SHARE * excess;
        let torque_variance = point.variance_nm2 + wobble * wobble;
        let model = TWIST_SHARE * twist;
        Self {
            torque_nm,
            excess_nm: excess,
            residual_rad: measured - path.rotation_rad - twist,
            variance_rad2: slope * slope * torque_variance
                + ANGLE_SIGMA_RAD * ANGLE_SIGMA_RAD
                + model * model,
            slope_rad_per_nm: slope,
            path,
        }
    }
}

impl Hypothesis {
    /// Follows the path from the onset through the points, and adds each that it reaches to the normal equations, if they
    /// are asked for.
    // A symbol of its own, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub(super) fn follow<F: Mechanics, X: Series>(
        &self,
        finger: &F,
        onset: &Free<F::Configuration>,
        values: &Values,
        data: &Data,
        mut rows: Option<&mut Rows<X>>,
    ) -> Pass {
        let mut pass = Pass::default();
        let (contact, at_onset) = if self.is_proximal() {
            let contact = Contact {
                phalanx: self.phalanx,
                k_m: 0.5 * self.length_m,
                radius_m: 0.0,
            };
            let compliance = finger.proximal_compliance(&onset.configuration, onset.torque_nm);
            (contact, compliance)
        } else {
            let contact = Contact {
                phalanx: self.phalanx,
                k_m: values[K],
                radius_m: values[RADIUS],
            };
            (contact, self.compliance(finger, onset, values[K]))
        };
        let (Some(mut path), Some(at_onset)) = (
            finger.path(&onset.configuration, onset.torque_nm, contact),
            at_onset,
        ) else {
            return pass;
        };
        let mut last_logarithm = 0.0;
        for point in data.points {
            let rise_nm = values[FACTOR] * torque_nm(values, point) - onset.torque_nm;
            let reached = if rise_nm <= 0.0 {
                // Noise took the torque below that of the contact: the path's tangent goes on.
                PathPoint {
                    rotation_rad: at_onset * rise_nm,
                    compliance_rad_per_nm: at_onset,
                    ..PathPoint::default()
                }
            } else {
                let Some(end) = finger.follow(&mut path, rise_nm) else {
                    break;
                };
                pass.end = end;
                end
            };
            pass.reached += 1;
            let local = Local::new(data, point, values, onset.torque_nm, reached);
            pass.squares += local.residual_rad * local.residual_rad / local.variance_rad2;
            last_logarithm = ln(local.variance_rad2);
            pass.logarithms += last_logarithm;
            if let Some(rows) = &mut rows {
                rows.add(point, values, onset.torque_nm, &local);
            }
        }
        let unreached = data.points.len().saturating_sub(pass.reached) as f32;
        pass.squares += unreached * UNREACHED;
        pass.logarithms += unreached * last_logarithm;
        pass
    }

    fn compliance<F: Mechanics>(
        &self,
        finger: &F,
        onset: &Free<F::Configuration>,
        k_m: f32,
    ) -> Option<f32> {
        finger.contact_compliance(&onset.configuration, onset.torque_nm, self.phalanx, k_m)
    }
}
