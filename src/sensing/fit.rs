//! Where is the contact, and how round the object: the whole torque-angle curve against the finger's exact path (MATH 7).
//!
//! For a hypothesis (a phalanx) eight numbers are fitted, each with a prior: the location k, the effective contact radius
//! R, an offset q of the torque (misfit of the friction record), the onset angle o, and what calibration has left open of
//! the torque factor f, the cable's twist c, the share g of it that creeps
//! and the rotor's inertia j, which counts while a stiff contact slows the motor down. With the nominal torque T of each point, corrected by j, the model is
//!
//! angle = o + rotation(f (T - q); k, R) + c (T - q - T_c / f + g L),
//!
//! L being the torque delayed by the creep's time constant, and rotation the contact path from the torque T_c of the free finger at the onset. The residual is taken in angle,
//! which stays bounded where the finger is rigid (e_2); its variance is that of the torque times the slope squared.
//! Everything unknown is a parameter with a prior, so the deviation of k that comes out holds noise, friction misfit,
//! radius and calibration together.

use crate::finger::{Contact, Free, Mechanics, PathPoint};
use crate::numeric::{ln, sqrt};
use crate::sensing::curve::{BINS, Point};
use crate::sensing::normal::{Factor, Normal};
use crate::sensing::{Calibration, Drivetrain};

/// Number of unknowns.
pub const UNKNOWNS: usize = 8;
const K: usize = 0;
const RADIUS: usize = 1;
const OFFSET: usize = 2;
const ONSET: usize = 3;
const FACTOR: usize = 4;
const CABLE: usize = 5;
const CREEP: usize = 6;
const INERTIA: usize = 7;

/// Deviation of a measured angle from any model, radian: four counts of the encoder's periodic error and as much again.
const ANGLE_SIGMA_RAD: f32 = 4e-5;
/// What the model does not know of the cable, as a share of the twist (R, chosen).
const TWIST_SHARE: f32 = 0.001;
/// Wobble of the gears' efficiency, as a share of the torque (R, chosen).
const TORQUE_SHARE: f32 = 0.002;
/// Largest effective contact radius thought of, metre.
const RADIUS_MAX_M: f32 = 0.045;
/// What a point beyond the end of a path counts for: three standard deviations.
const UNREACHED: f32 = 9.0;
/// Nearer to a joint than this share of the phalanx, a contact is one on the joint.
const JOINT_SHARE: f32 = 0.02;
/// Fewest points that make a fit.
pub const LEAST_POINTS: usize = 5;

/// Prior of the location.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Anywhere on the phalanx, uniformly.
    Anywhere,
    /// Known, with a standard deviation, metre.
    Known {
        /// Phalanx, from 2.
        phalanx: u8,
        /// Distance from the joint, metre.
        k_m: f32,
        /// Standard deviation, metre.
        sigma_m: f32,
    },
}

/// What is known before the fit, the same for every hypothesis.
#[derive(Clone, Copy, Debug)]
pub struct Prior {
    /// Location.
    pub place: Place,
    /// Effective contact radius: mean and deviation, metre.
    pub radius_m: (f32, f32),
    /// Deviation of the torque's offset, newton metre.
    pub offset_sigma_nm: f32,
    /// Onset angle theta_a: mean and deviation, radian.
    pub onset_rad: (f32, f32),
    /// Torque factor and cable.
    pub calibration: Calibration,
    /// Share of the cable's twist that creeps: mean and deviation.
    pub creep: [f32; 2],
    /// Deviation of the rotor's inertia, as a share of it.
    pub inertia_share: f32,
}

/// Posture and torque of the free finger at an angle measured before the cable: the torque that holds the finger twists
/// it. `near` is where the search starts.
pub fn free_behind_cable<F: Mechanics>(
    finger: &F,
    measured_rad: f32,
    calibration: &Calibration,
    creep: f32,
    near: &F::Configuration,
) -> Option<Free<F::Configuration>> {
    let twist_rad_per_nm = calibration.cable_rad_per_nm * (1.0 + creep) / calibration.torque_factor;
    let mut free = finger.free_at_angle(measured_rad, near)?;
    // The twist is small beside the angle: each round takes the error down by the cable's share of the compliance.
    for _ in 0..3 {
        if free.torque_nm == 0.0 {
            break;
        }
        let angle_rad = measured_rad - twist_rad_per_nm * free.torque_nm;
        free = finger.free_at_angle(angle_rad, &free.configuration)?;
    }
    Some(free)
}

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

/// Result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Location at first contact, metre.
    pub k_m: f32,
    /// Its standard deviation, metre.
    pub k_sigma_m: f32,
    /// Effective contact radius, metre.
    pub radius_m: f32,
    /// Its standard deviation, metre.
    pub radius_sigma_m: f32,
    /// Angle of the input link at the onset, radian.
    pub onset_rad: f32,
    /// Torque factor.
    pub torque_factor: f32,
    /// Cable's twist, radian per newton metre of nominal torque.
    pub cable_rad_per_nm: f32,
    /// Offset of the torque, newton metre.
    pub offset_nm: f32,
    /// Sum of squared residuals over their variances.
    pub chi_square: f32,
    /// Points that the path reached.
    pub reached: usize,
    /// End of the path.
    pub end: PathPoint,
}

/// One explanation of the curve, refined step by step.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    phalanx: u8,
    /// Unknowns, whitened by the prior (location: in phalanx lengths).
    x: [f32; UNKNOWNS],
    /// Location of `best` in phalanx lengths.
    share: f32,
    damping: f32,
    steps: u16,
    settled_steps: u8,
    best: Option<Estimate>,
    /// Inverse covariance, factored.
    factor: Option<Factor<UNKNOWNS>>,
    /// Sum of squares, priors and logarithms of variances.
    cost: f32,
}

/// One pass over the points.
struct Pass {
    rotation: [f32; BINS],
    compliance: [f32; BINS],
    reached: usize,
    end: PathPoint,
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
            joints_rad: [0.0; crate::finger::MAX_PHALANGES],
        },
    };
}

/// Physical values of the unknowns.
#[derive(Clone, Copy, Debug)]
struct Values {
    k_m: f32,
    radius_m: f32,
    offset_nm: f32,
    onset_rad: f32,
    factor: f32,
    cable: f32,
    creep: f32,
    inertia: f32,
}

impl Values {
    /// Torque of a point without offset and error of the inertia, newton metre.
    fn torque_nm(&self, point: &Point) -> f32 {
        point.torque_nm - self.offset_nm - self.inertia * point.inertia_nm
    }
}

impl Hypothesis {
    /// A contact on a phalanx, starting at a location. On phalanx 1 location and radius mean nothing and stay.
    pub fn new(phalanx: u8, k_m: f32, length_m: f32, prior: &Prior) -> Self {
        let mut x = [0.0; UNKNOWNS];
        x[K] = match prior.place {
            Place::Anywhere => (k_m / length_m).clamp(Self::LEAST, 1.0),
            Place::Known { .. } => 0.0,
        };
        Self {
            phalanx,
            x,
            share: 1.0,
            damping: 0.0,
            steps: 0,
            settled_steps: 0,
            best: None,
            factor: None,
            cost: f32::INFINITY,
        }
    }

    /// Least k/l thought of: nearer to the joint a contact is a proximal one for all that the curve tells.
    const LEAST: f32 = 0.004;

    /// The phalanx.
    pub fn phalanx(&self) -> u8 {
        self.phalanx
    }

    /// Result so far; None before the first step, or where no path fits the curve at all.
    pub fn estimate(&self) -> Option<&Estimate> {
        self.best.as_ref()
    }

    /// Steps made.
    pub fn steps(&self) -> u16 {
        self.steps
    }

    /// Whether the last steps changed nothing that matters.
    pub fn has_converged(&self) -> bool {
        self.settled_steps >= 2
    }

    /// New points have come.
    pub fn refresh(&mut self) {
        self.settled_steps = 0;
    }

    /// Whether the place lies on the very joint of phalanx 2: as compliant as a contact anywhere on phalanx 1 (MATH 5), and
    /// nearer to the joint than either phalanx is thick.
    pub fn is_on_first_joint(&self) -> bool {
        self.phalanx == 2 && self.share < JOINT_SHARE
    }

    fn is_proximal(&self) -> bool {
        self.phalanx <= 1
    }

    fn values<F: Mechanics>(&self, x: &[f32; UNKNOWNS], finger: &F, prior: &Prior) -> Values {
        let length = finger.phalanx_length_m(self.phalanx).unwrap_or(0.0);
        let (radius, radius_sigma) = prior.radius_m;
        let calibration = &prior.calibration;
        let rest = sqrt((1.0 - calibration.correlation * calibration.correlation).max(0.0));
        Values {
            k_m: match prior.place {
                Place::Anywhere => x[K] * length,
                Place::Known { k_m, sigma_m, .. } => k_m + sigma_m * x[K],
            },
            radius_m: radius + radius_sigma * x[RADIUS],
            offset_nm: prior.offset_sigma_nm * x[OFFSET],
            onset_rad: prior.onset_rad.0 + prior.onset_rad.1 * x[ONSET],
            factor: calibration.torque_factor * (1.0 + calibration.torque_factor_sigma * x[FACTOR]),
            cable: calibration.cable_rad_per_nm
                + calibration.cable_sigma_rad_per_nm
                    * (calibration.correlation * x[FACTOR] + rest * x[CABLE]),
            creep: prior.creep[0] + prior.creep[1] * x[CREEP],
            inertia: prior.inertia_share * x[INERTIA],
        }
    }

    /// Keeps the unknowns where they mean something. (With computed bounds `clamp` would panic on a NaN.)
    fn clamp<F: Mechanics>(&self, x: &mut [f32; UNKNOWNS], finger: &F, prior: &Prior) {
        let length = finger.phalanx_length_m(self.phalanx).unwrap_or(0.0);
        x[K] = match prior.place {
            Place::Anywhere => x[K].clamp(Self::LEAST, 1.0),
            Place::Known { k_m, sigma_m, .. } => {
                let sigma = sigma_m.max(f32::MIN_POSITIVE);
                let low = (Self::LEAST * length - k_m) / sigma;
                x[K].max(low).min(((length - k_m) / sigma).max(low))
            }
        };
        let (radius, radius_sigma) = prior.radius_m;
        let sigma = radius_sigma.max(f32::MIN_POSITIVE);
        let low = -radius.max(0.0) / sigma;
        x[RADIUS] = x[RADIUS]
            .max(low)
            .min(((RADIUS_MAX_M - radius) / sigma).max(low));
        for unknown in [OFFSET, ONSET, FACTOR, CABLE, CREEP, INERTIA] {
            x[unknown] = x[unknown].clamp(-6.0, 6.0);
        }
        // A factor near zero would be a motor that does nothing.
        let sigma = prior.calibration.torque_factor_sigma.max(f32::MIN_POSITIVE);
        x[FACTOR] = x[FACTOR].max(-0.8 / sigma);
    }

    fn onset<F: Mechanics>(
        finger: &F,
        onset_rad: f32,
        prior: &Prior,
        near: &F::Configuration,
    ) -> Option<Free<F::Configuration>> {
        free_behind_cable(finger, onset_rad, &prior.calibration, prior.creep[0], near)
    }

    /// Follows the path through the points.
    fn follow<F: Mechanics>(
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
    fn residual(
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
    fn cost(
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

    /// One step of Levenberg and Marquardt: four paths, about 16 points each. `near` is a posture near the onset.
    pub fn refine<F: Mechanics>(
        &mut self,
        finger: &F,
        data: &Data,
        prior: &Prior,
        near: &F::Configuration,
    ) {
        self.steps = self.steps.saturating_add(1);
        let points = data.points.get(..BINS).unwrap_or(data.points);
        let data = Data { points, ..*data };
        let x = self.x;
        let values = self.values(&x, finger, prior);
        let Some(onset) = Self::onset(finger, values.onset_rad, prior, near) else {
            self.fail();
            return;
        };
        let here = self.follow(finger, &onset, &values, points);
        if here.reached < LEAST_POINTS {
            self.retreat(prior);
            return;
        }
        let (cost, chi_square) = self.cost(&x, &data, &values, onset.torque_nm, &here, prior);
        let Some(normal) = self.linearise(finger, &data, prior, &onset, &values, &here) else {
            self.fail();
            return;
        };
        self.cost = cost;
        self.factor = normal.factor(0.0);
        self.share = values.k_m / finger.phalanx_length_m(self.phalanx).unwrap_or(values.k_m);
        self.best = self.report(finger, prior, &values, chi_square, &here);
        let Some(factor) = normal.factor(self.damping) else {
            self.fail();
            return;
        };
        let mut trial = x;
        for (value, step) in trial.iter_mut().zip(normal.step(&factor)) {
            *value += step;
        }
        self.clamp(&mut trial, finger, prior);
        let trial_values = self.values(&trial, finger, prior);
        let trial_cost = Self::onset(finger, trial_values.onset_rad, prior, near).map(|onset| {
            let pass = self.follow(finger, &onset, &trial_values, points);
            self.cost(&trial, &data, &trial_values, onset.torque_nm, &pass, prior)
                .0
        });
        match trial_cost {
            Some(trial_cost) if trial_cost < cost => {
                self.x = trial;
                self.damping *= 0.2;
                if self.damping < 1e-4 {
                    self.damping = 0.0;
                }
                self.settled_steps = if cost - trial_cost < 0.05 {
                    self.settled_steps.saturating_add(1)
                } else {
                    0
                };
            }
            _ => {
                self.damping = (10.0 * self.damping).max(0.01);
                // Nothing better even close by: this is the minimum.
                if self.damping > 10.0 {
                    self.settled_steps = self.settled_steps.saturating_add(1);
                    self.damping = 1.0;
                }
            }
        }
    }

    /// Normal equations at the present values.
    fn linearise<F: Mechanics>(
        &self,
        finger: &F,
        data: &Data,
        prior: &Prior,
        onset: &Free<F::Configuration>,
        values: &Values,
        here: &Pass,
    ) -> Option<Normal<UNKNOWNS>> {
        let length = finger.phalanx_length_m(self.phalanx)?;
        let calibration = &prior.calibration;
        let rest = sqrt((1.0 - calibration.correlation * calibration.correlation).max(0.0));
        let (k_scale, known) = match prior.place {
            Place::Anywhere => (length, false),
            Place::Known { sigma_m, .. } => (sigma_m, true),
        };
        // Differences towards the inside, so that both ends of a step exist.
        let k_step = if values.k_m > 0.5 * length {
            -0.006
        } else {
            0.006
        } * length;
        let radius_step = if values.radius_m > 0.5 * RADIUS_MAX_M {
            -0.001
        } else {
            0.001
        };
        let (by_k, by_radius) = if self.is_proximal() {
            (None, None)
        } else {
            let moved = Values {
                k_m: values.k_m + k_step,
                ..*values
            };
            let by_k = self.follow(finger, onset, &moved, data.points);
            let moved = Values {
                radius_m: values.radius_m + radius_step,
                ..*values
            };
            (
                Some(by_k),
                Some(self.follow(finger, onset, &moved, data.points)),
            )
        };
        let reached = [by_k.as_ref(), by_radius.as_ref()]
            .into_iter()
            .flatten()
            .fold(here.reached, |least, pass| least.min(pass.reached));
        let mut normal = Normal::EMPTY;
        for (index, point) in data.points.iter().enumerate().take(reached) {
            let (Some(&rotation), Some(&compliance)) =
                (here.rotation.get(index), here.compliance.get(index))
            else {
                break;
            };
            let (residual, variance, slope) =
                Self::residual(data, point, values, onset.torque_nm, rotation, compliance);
            let torque = values.torque_nm(point);
            let excess = torque - onset.torque_nm / values.factor;
            let derivative = |pass: &Option<Pass>, step: f32| {
                pass.as_ref()
                    .and_then(|pass| pass.rotation.get(index))
                    .map_or(0.0, |moved| (moved - rotation) / step)
            };
            let by_factor = torque * compliance
                + values.cable * onset.torque_nm / (values.factor * values.factor);
            let mut slopes = [0.0; UNKNOWNS];
            slopes[K] = derivative(&by_k, k_step) * k_scale;
            slopes[RADIUS] = derivative(&by_radius, radius_step) * prior.radius_m.1;
            slopes[OFFSET] = -slope * prior.offset_sigma_nm;
            slopes[ONSET] = prior.onset_rad.1;
            let cable_sigma = calibration.cable_sigma_rad_per_nm;
            slopes[FACTOR] = by_factor
                * calibration.torque_factor
                * calibration.torque_factor_sigma
                + (excess + values.creep * point.late_nm) * cable_sigma * calibration.correlation;
            let late = values.creep * point.late_nm;
            slopes[CABLE] = (excess + late) * cable_sigma * rest;
            slopes[INERTIA] = -slope * point.inertia_nm * prior.inertia_share;
            slopes[CREEP] = values.cable * point.late_nm * prior.creep[1];
            normal.add(residual, &slopes, 1.0 / variance);
        }
        for (unknown, &value) in self.x.iter().enumerate() {
            let weight = if unknown != K || known {
                1.0
            } else if self.is_proximal() {
                12.0
            } else {
                // A uniform prior has a variance of 1/12; as a slope it says nothing.
                1e-3
            };
            let value = if unknown == K && !known { 0.0 } else { value };
            normal.add_prior(unknown, value, weight);
        }
        Some(normal)
    }

    /// Nothing explains the curve from here.
    fn fail(&mut self) {
        self.best = None;
        self.factor = None;
        self.cost = f32::INFINITY;
        self.settled_steps = self.settled_steps.saturating_add(1);
    }

    /// The path ends before the curve: try nearer to the middle of the phalanx.
    fn retreat(&mut self, prior: &Prior) {
        self.fail();
        if prior.place == Place::Anywhere {
            self.x[K] += 0.25 * (0.5 - self.x[K]);
        }
    }

    fn report<F: Mechanics>(
        &self,
        finger: &F,
        prior: &Prior,
        values: &Values,
        chi_square: f32,
        pass: &Pass,
    ) -> Option<Estimate> {
        let factor = self.factor.as_ref()?;
        let length = finger.phalanx_length_m(self.phalanx)?;
        let k_scale = match prior.place {
            Place::Anywhere => length,
            Place::Known { sigma_m, .. } => sigma_m,
        };
        let deviation = |unknown: usize| {
            let variance = factor
                .covariance(unknown)
                .get(unknown)
                .copied()
                .unwrap_or(0.0);
            sqrt(variance.max(0.0))
        };
        Some(Estimate {
            k_m: values.k_m,
            k_sigma_m: k_scale * deviation(K),
            radius_m: values.radius_m,
            radius_sigma_m: prior.radius_m.1 * deviation(RADIUS),
            onset_rad: values.onset_rad,
            torque_factor: values.factor,
            cable_rad_per_nm: values.cable,
            offset_nm: values.offset_nm,
            chi_square,
            reached: pass.reached,
            end: pass.end,
        })
    }

    /// Logarithm of how well the hypothesis explains the curve, all values of its unknowns together (Laplace's
    /// approximation of the evidence): what has more freedom pays for it. `spread` is by how much the residuals of the
    /// best hypothesis exceed what was expected; it makes all of them less sure.
    pub fn ln_evidence(&self, spread: f32) -> f32 {
        let Some(factor) = &self.factor else {
            return f32::NEG_INFINITY;
        };
        let mut determinant = factor.ln_determinant();
        let mut flat = 0.0;
        if self.is_proximal() {
            // The unknown that it does not have.
            determinant -= ln(12.0);
        } else {
            flat = 0.5 * ln(core::f32::consts::TAU);
        }
        -0.5 * self.cost / spread.max(1.0) - 0.5 * determinant + flat
    }

    /// What a fit at a known place teaches: torque factor and cable, with their covariance.
    pub fn learned(&self, prior: &Prior) -> Option<Calibration> {
        let estimate = self.best.as_ref()?;
        let factor = self.factor.as_ref()?;
        let before = &prior.calibration;
        let rest = sqrt((1.0 - before.correlation * before.correlation).max(0.0));
        let by_factor = factor.covariance(FACTOR);
        let by_cable = factor.covariance(CABLE);
        let (ff, fc, cc) = (by_factor[FACTOR], by_factor[CABLE], by_cable[CABLE]);
        let r = before.correlation;
        let cable_variance = r * r * ff + 2.0 * r * rest * fc + rest * rest * cc;
        let covariance = r * ff + rest * fc;
        let (sf, sc) = (sqrt(ff.max(0.0)), sqrt(cable_variance.max(0.0)));
        let correlation = covariance / (sf * sc);
        Some(Calibration {
            torque_factor: estimate.torque_factor,
            // Kept relative to the new value.
            torque_factor_sigma: before.torque_factor_sigma * sf * before.torque_factor
                / estimate.torque_factor,
            cable_rad_per_nm: estimate.cable_rad_per_nm.max(0.0),
            cable_sigma_rad_per_nm: before.cable_sigma_rad_per_nm * sc,
            correlation: if correlation.is_finite() {
                correlation.clamp(-0.999, 0.999)
            } else {
                0.0
            },
            ..*before
        })
    }
}
