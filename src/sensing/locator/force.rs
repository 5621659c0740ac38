//! Posture and force of an estimate, from the contact path.

use super::model::Hold;
use super::prior::{K, ONSET, Scaling};
use super::{Data, Estimate, Free, Locator, Model, Prior, onset};
use crate::finger::{MAX_PHALANGES, Mechanics, PathPoint};
use crate::numeric::{exp, ln, sqrt};
use crate::sensing::{Calibration, SeriesElement};

/// Stride over the curve's points where only the end of a path is needed: longer on three phalanges, whose points cost twice as much.
/// Between strides of 1, 6 and 14 points forces there differ by less than 0.1 % of themselves on average (tried, no command).
const fn stride(phalanges: usize) -> usize {
    if phalanges > 2 { 14 } else { 6 }
}
/// Factor on the stride where only a deviation follows from the path.
const ROUGH: usize = 3;
/// Standard deviation of contact friction for a force: handbooks have 0.04 to 0.67 for engineering plastics (V2, CRC Handbook of
/// Materials Science). For a place the prior's counts: what rubs alike on pins and objects went into the torque factor with the
/// pins. Nothing calibrates a force.
const RUBBING: f32 = 0.2;
/// Variance of the springs' stiffness from the scene's, as a share: 10 %, uniform (R). A location does not depend on it, a
/// force does.
const SPRING_VARIANCE: f32 = 0.0034;
/// Share of it in the variance of the torque factor (efficiency over stiffness) before any calibration: this share of a
/// calibrated deviation is attributed to the springs.
const SPRING_SHARE: f32 = 0.25;

/// Deviation of a force's scale that a user has measured, as a share: the scale's reading, and the place of that contact (R, chosen).
const MEASURED: f32 = 0.03;

/// Force of a contact, newton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// Mean.
    pub force_n: f32,
    /// Standard deviation.
    pub sigma_n: f32,
}

/// The finger at an estimate.
#[derive(Clone, Copy, Debug)]
pub struct State<C> {
    /// Force of the contact.
    pub force: Force,
    /// The measured angle of the input link at the onset, radian, and the free finger there.
    pub onset_rad: f32,
    /// See `onset_rad`.
    pub onset: Free<C>,
    /// Change of the joints' angles since.
    pub joints_rad: [f32; MAX_PHALANGES],
    /// What the object's compliance of 1 m/N would add to the input link's rotation since, over that rotation, newton per metre.
    pub share_by_give_n_per_m: f32,
}

impl<F: Mechanics, X: SeriesElement> Locator<F, X> {
    /// Posture and force of an estimate at a measured angle, from the contact path.
    pub fn state(
        &self,
        estimate: &Estimate,
        finger: &F,
        data: &Data,
        prior: &Prior<X>,
        near: &F::Configuration,
        measured_rad: f32,
    ) -> Option<State<F::Configuration>> {
        let data = self.of_round(data);
        let scaling = Scaling::of::<F, X>(prior, estimate.length_m);
        // The onset is the same at every place.
        let onset_rad = scaling.values(&estimate.best)[ONSET];
        let onset = onset::at::<F, X>(finger, onset_rad, prior, near)?;
        let force_at = |k: f32, stride: usize| -> Option<(Force, PathPoint)> {
            let mut x = estimate.best;
            x[K] += k;
            scaling.hold(&mut x, K);
            let values = scaling.values(&x);
            let hold = Hold::Contact {
                phalanx: estimate.phalanx,
                radius_m: estimate.best_radius_m,
            };
            let mut model = Model::<F, X>::new(
                finger,
                (data.origin_rad, data.drivetrain),
                &values,
                prior,
                hold,
                &onset,
            )?;
            // Along the curve up to that angle, in strides, because the points between are not compared with anything.
            let mut last = data.points.first()?;
            for (index, point) in data.points.iter().enumerate() {
                if data.rad(point) > measured_rad {
                    break;
                }
                if index % stride == 0 {
                    model.next(finger, point)?;
                }
                last = point;
            }
            model.follow_to(finger, measured_rad, last)?;
            let beyond_n = model.force_sigma_n();
            let rubbing_n = RUBBING * model.force_by_friction_n();
            let force = Force {
                force_n: model.force_n(),
                sigma_n: sqrt(beyond_n * beyond_n + rubbing_n * rubbing_n),
            };
            Some((force, *model.end()))
        };
        let stride = const { stride(F::PHALANGES) };
        let (along, end) = force_at(0.0, stride)?;
        let force_n = along.force_n;
        let beside = estimate.k_sigma_m / estimate.length_m;
        let stride = ROUGH * stride;
        // Away from the nearer end, where the phalanx goes on.
        let inward = if estimate.best[K] > 0.5 {
            -beside
        } else {
            beside
        };
        let beside = force_at(inward, stride).or_else(|| force_at(-inward, stride));
        let moved_n = beside.map_or(0.0, |(other, _)| other.force_n - force_n);
        let [springs, sigma] = springs(&prior.calibration, prior.force_scale);
        let spring_n = sigma * force_n;
        let path_n2 = moved_n * moved_n + along.sigma_n * along.sigma_n;
        let sigma_n = sqrt(path_n2 * springs * springs + spring_n * spring_n);
        Some(State {
            force: Force {
                force_n: springs * force_n,
                sigma_n,
            },
            onset_rad,
            onset,
            joints_rad: end.joints_rad,
            share_by_give_n_per_m: if X::OBJECT_GIVES {
                end.rotation_by_give_rad_n_per_m / end.rotation_rad
            } else {
                0.0
            },
        })
    }
}

/// The springs' stiffness over the scene's with the standard deviation of a force by it: what a user has measured, or estimated from the
/// torque factor f that pins have told. A force with the scene's springs is in proportion to f, with the estimated ones to the power of f
/// that is not theirs. Without pins f tells of the motor alone.
pub(in crate::sensing) fn springs(calibration: &Calibration, measured: Option<f32>) -> [f32; 2] {
    if let Some(scale) = measured {
        // Without pins each curve has its own f, and the scale was measured with that of one.
        let own = if calibration.contacts > 0 {
            0.0
        } else {
            calibration.torque_factor_sigma
        };
        return [scale, scale * sqrt(MEASURED * MEASURED + own * own)];
    }
    let mean = if calibration.contacts > 0 {
        exp(-SPRING_SHARE * ln(calibration.torque_factor))
    } else {
        1.0
    };
    let sigma = (1.0 - SPRING_SHARE) * calibration.torque_factor_sigma;
    let variance = (1.0 - SPRING_SHARE) * SPRING_VARIANCE + sigma * sigma;
    [mean, mean * sqrt(variance)]
}
