//! A finger with a motor at every joint: T* is the identity, and every actuator has its own K_a and K_c
//! (docs/FINGERS.md#fully-actuated-fingers).

use super::error::{ConfigError, check_range};
use super::quadratic::roots_of;
use super::statics::contact_arms;
use super::{Base, Configuration, Parameter, Parameters};
use crate::numeric::{Bounded, clamp, sqrt};
use core::array::from_fn;

/// Gauss-Newton steps of the place: from the best root three are enough.
const STEPS: u8 = 8;

/// A place of a contact, told by all actuators together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatedPlace {
    /// Phalanx in contact: that of the outermost joint that has become stiffer, 1 for the first.
    pub phalanx: u8,
    /// Distance of the contact from the phalanx's joint, metre; `None` on phalanx 1, whose joint is blocked wherever the
    /// contact lies, and where no place on the phalanx explains the stiffness.
    pub k_m: Option<f32>,
    /// Standard deviation of `k_m`, metre.
    pub sigma_m: f32,
    /// Sum of squares of what the place leaves unexplained, over the deviations.
    pub chi2: f32,
}

/// A finger with a motor at every joint, each behind a spring of the joint (or the stiffness of its controller).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatedFinger<const N: usize> {
    parameters: Parameters<N>,
}

impl<const N: usize> ActuatedFinger<N> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// As [`super::Finger::new`]; also where joint 1 has no stiffness.
    pub const fn new(parameters: Parameters<N>) -> Result<Self, ConfigError> {
        if let Err(error) = parameters.check(Base::Any) {
            return Err(error);
        }
        let first = Parameter::Stiffness { joint: 1 };
        if N > 0
            && let Err(error) = check_range(first, parameters.stiffness_nm_per_rad[0], 1e-9, 1e9)
        {
            return Err(error);
        }
        Ok(Self { parameters })
    }

    /// What the finger was built from.
    pub fn parameters(&self) -> &Parameters<N> {
        &self.parameters
    }

    /// Posture without contact under the actuators' torques, newton metre: each spring by itself (6). `None` where a value
    /// is not finite or a joint would turn beyond two turns.
    pub fn free_at_torques(&self, torques_nm: [f32; N]) -> Option<Configuration<N>> {
        let Parameters {
            stiffness_nm_per_rad,
            rest_rad,
            ..
        } = &self.parameters;
        Configuration::of(from_fn(|j| {
            rest_rad[j] + torques_nm[j] / stiffness_nm_per_rad[j]
        }))
    }

    /// K_a of each actuator (7), newton metre per radian: the joints' stiffness.
    pub fn expected_k_a(&self) -> [f32; N] {
        self.parameters.stiffness_nm_per_rad
    }

    /// Moment arms of a contact at k = 0 on a phalanx; `None` for a phalanx that the finger does not have.
    fn arms_at_joint(&self, at: &Configuration<N>, phalanx: u8) -> Option<(usize, [f32; N])> {
        let tip = usize::from(phalanx).checked_sub(1).filter(|i| *i < N)?;
        let arms = contact_arms(&self.parameters.lengths_m, &at.turn(), tip, 0.0);
        Some((tip, arms))
    }

    /// Compliance 1/K_c of each actuator with a contact at `k_m` on a phalanx while the others keep their torque,
    /// radian per newton metre, and its derivative by k. The joints beyond the contact keep theirs.
    fn compliances(&self, tip: usize, d: &[f32; N], k_m: f32) -> [[f32; N]; 2] {
        let springs = &self.parameters.stiffness_nm_per_rad;
        let (mut sum, mut sum_by_k) = (0.0, 0.0);
        for j in 0..=tip {
            let arm = d[j] + k_m;
            sum += arm * arm / springs[j];
            sum_by_k += 2.0 * arm / springs[j];
        }
        let (mut c, mut by_k) = (springs.map(|k| 1.0 / k), [0.0; N]);
        for m in 0..=tip {
            let turned = (d[m] + k_m) / springs[m];
            // The other joints' share, not a difference: near the stiffest place of this joint it keeps its digits.
            let others = (0..=tip).filter(|j| *j != m).fold(0.0, |rest, j| {
                let arm = d[j] + k_m;
                rest + arm * arm / springs[j]
            });
            c[m] = others / (sum * springs[m]);
            by_k[m] = turned / sum * (turned * sum_by_k / sum - 2.0 / springs[m]);
        }
        [c, by_k]
    }

    /// Compliance 1/K_c of each actuator (18) with a contact at `k_m` on a phalanx, while the other actuators keep their
    /// torque; radian per newton metre. `None` for a place that is not on the finger.
    ///
    /// ```
    /// use palpate::finger::{ActuatedFinger, Parameters};
    ///
    /// let finger = ActuatedFinger::new(Parameters {
    ///     lengths_m: [0.060, 0.040],
    ///     stiffness_nm_per_rad: [0.4, 0.2],
    ///     rest_rad: [0.0, 0.0],
    ///     range_rad: [[-0.5, 2.0]; 2],
    /// })?;
    /// let at = finger.free_at_torques([0.2, 0.1]).expect("a posture");
    /// let felt = finger.contact_compliance(&at, 2, 0.030).expect("on the finger");
    /// // Measured with 1 % of noise, both actuators together tell the place.
    /// let sigma = felt.map(|c| 0.01 * c);
    /// let place = finger.locate(&at, felt, sigma).expect("a contact");
    /// assert!(place.phalanx == 2 && place.k_m.is_some_and(|k| (k - 0.030).abs() < 1e-6));
    /// # Ok::<(), palpate::finger::ConfigError>(())
    /// ```
    pub fn contact_compliance(
        &self,
        at: &Configuration<N>,
        phalanx: u8,
        k_m: f32,
    ) -> Option<[f32; N]> {
        let (tip, d) = self.arms_at_joint(at, phalanx)?;
        let on_it = k_m > 0.0 && k_m <= self.parameters.lengths_m[tip];
        let [c, _] = self.compliances(tip, &d, k_m);
        (on_it && c.iter().all(|c| c.is_finite())).then_some(c)
    }

    /// The place of a contact from the compliance of each actuator with its standard deviation, radian per newton metre.
    ///
    /// The phalanx is that of the outermost joint stiffer than K_a by more than three deviations. Its place is the one that
    /// fits all actuators best: the roots of each one's quadratic are where Gauss and Newton start. `None` without a contact
    /// or for values that are not finite and positive.
    pub fn locate(
        &self,
        at: &Configuration<N>,
        compliance_rad_per_nm: [f32; N],
        sigma_rad_per_nm: [f32; N],
    ) -> Option<ActuatedPlace> {
        let springs = &self.parameters.stiffness_nm_per_rad;
        let valid = (0..N).all(|j| {
            compliance_rad_per_nm[j].is_finite()
                && sigma_rad_per_nm[j].is_normal()
                && sigma_rad_per_nm[j] > 0.0
        });
        if !valid {
            return None;
        }
        let is_stiffer =
            |j: &usize| 1.0 / springs[*j] - compliance_rad_per_nm[*j] > 3.0 * sigma_rad_per_nm[*j];
        let tip = (0..N).rev().find(is_stiffer)?;
        let phalanx = tip as u8 + 1;
        let (_, d) = self.arms_at_joint(at, phalanx)?;
        let length = self.parameters.lengths_m[tip];
        // Sum of squares, and the normal equation of a Gauss-Newton step.
        let misfit = |k: f32| {
            let [c, by_k] = self.compliances(tip, &d, k);
            let (mut chi2, mut normal, mut gradient) = (0.0, 0.0, 0.0);
            for j in 0..N {
                let weight = 1.0 / sigma_rad_per_nm[j];
                let (off, slope) = (weight * (compliance_rad_per_nm[j] - c[j]), weight * by_k[j]);
                chi2 += off * off;
                normal += slope * slope;
                gradient += slope * off;
            }
            (chi2, normal, gradient)
        };
        let mut best: Option<(f32, f32)> = None;
        if tip > 0 {
            for start in (0..=tip).flat_map(|m| self.roots(tip, m, &d, compliance_rad_per_nm[m])) {
                let mut k = clamp(start, 1e-3 * length, length);
                for _ in 0..STEPS {
                    let (_, normal, gradient) = misfit(k);
                    let step = gradient / normal;
                    if !step.is_finite() {
                        break;
                    }
                    let stride = clamp(step, -0.2 * length, 0.2 * length);
                    k = clamp(k + stride, 1e-3 * length, length);
                }
                let (chi2, ..) = misfit(k);
                if best.is_none_or(|(_, least)| chi2 < least) {
                    best = Some((k, chi2));
                }
            }
        }
        let (sigma_m, chi2) = best.map_or((f32::INFINITY, misfit(length).0), |(k, chi2)| {
            (1.0 / sqrt(misfit(k).1), chi2)
        });
        Some(ActuatedPlace {
            phalanx,
            k_m: best.map(|(k, _)| k),
            sigma_m,
            chi2,
        })
    }

    /// Where one actuator alone would have the contact: p_m^2 = (1/K_m - C_m) K_m^2 sum p_j^2/K_j, a quadratic in k; its
    /// vertex where noise leaves no root.
    fn roots(&self, tip: usize, m: usize, d: &[f32; N], compliance: f32) -> [f32; 2] {
        let springs = &self.parameters.stiffness_nm_per_rad;
        let share = (1.0 - compliance * springs[m]) * springs[m];
        let (mut q0, mut q1, mut q2) = (d[m] * d[m], d[m], 1.0);
        for j in 0..=tip {
            let weight = share / springs[j];
            q0 -= weight * d[j] * d[j];
            q1 -= weight * d[j];
            q2 -= weight;
        }
        let square = (q1 * q1 - q0 * q2).at_least(0.0);
        roots_of([q0, q1, q2], square).map(|k| if k.is_finite() { k } else { 0.0 })
    }
}
