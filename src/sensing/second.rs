//! A second contact: where the slope of torque over angle jumps after the first (docs/MECHANICS.md#two-contacts).
//!
//! Independent of the [`Sensor`](super::Sensor): it takes the blocks of a closing after the sensor has reported a touch.
//! [`Follow`](super::Follow) does so in a scene with that option.
//!
//! With a single contact the slope of the curve changes smoothly, at a second one it jumps. Over the last blocks a parabola is
//! compared with a parabola plus a hinge. Worm and wandering friction bend the curve too, but slowly and far less.

use crate::numeric::{Bounded, solve, sqrt};
use heapless::Deque;

/// Blocks before the hinge and after it. Motor turns of P70 are 5 mrad: some 80 and 40 mrad of the input link.
const BEFORE: usize = 16;
const AFTER: usize = 8;
const WINDOW: usize = BEFORE + AFTER;
/// Terms of the curve: constant, slope, curvature, hinge.
const TERMS: usize = 4;
/// The slope must grow by this factor (chosen): that of a single contact grows too, but over several windows. If the first
/// contact leaves two thirds of the cable's stiffness, a second one changes the slope by exactly this factor.
const LEAST_RATIO: f32 = 1.5;
/// And by this many standard deviations of the hinge.
const LEAST_SIGMAS: f32 = 8.0;
/// Within this share of the cable's stiffness the finger counts as rigid.
const RIGID_SHARE: f32 = 0.25;

/// A second contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elbow {
    /// Angle of the input link there, the cable's twist included, radian.
    pub theta_a_rad: f32,
    /// Torque above friction there, newton metre.
    pub torque_nm: f32,
    /// Slope of torque over angle before it, cable included, newton metre per radian.
    pub before_nm_per_rad: f32,
    /// The same after it.
    pub after_nm_per_rad: f32,
    /// Standard deviation of `after_nm_per_rad`.
    pub after_sigma_nm_per_rad: f32,
}

impl Elbow {
    /// Compliance of the finger after the second contact and its deviation, the cable's taken off; radian per newton metre.
    /// For [`second_places`](crate::finger::Finger::second_places). At least 0.
    pub fn compliance(&self, cable_rad_per_nm: f32, cable_sigma_rad_per_nm: f32) -> (f32, f32) {
        let together = 1.0 / self.after_nm_per_rad;
        let share = together * together * self.after_sigma_nm_per_rad;
        (
            (together - cable_rad_per_nm).at_least(0.0),
            sqrt(share * share + cable_sigma_rad_per_nm * cable_sigma_rad_per_nm),
        )
    }

    /// Whether nothing but the cable gives way: the object is held between the phalanges, enveloped. Two phalanges that
    /// both touch are always so.
    pub fn is_rigid(&self, cable_rad_per_nm: f32, cable_sigma_rad_per_nm: f32) -> bool {
        let (left, sigma) = self.compliance(cable_rad_per_nm, cable_sigma_rad_per_nm);
        left <= RIGID_SHARE * cable_rad_per_nm + 2.0 * sigma
    }
}

/// Looks for the second contact of a closing.
///
/// ```
/// use palpate::sensing::second::SecondContact;
///
/// // A first contact of 0.2 N m/rad; from 1.2 rad on something else holds, and only the cable of 1.2 N m/rad gives way.
/// let mut search = SecondContact::new(2.0);
/// let elbow = (0..200).find_map(|block| {
///     let theta_a_rad = 0.7 + 0.005 * block as f32;
///     let torque_nm = 0.2 * (theta_a_rad - 0.6) + (theta_a_rad - 1.2).max(0.0);
///     search.push(theta_a_rad, torque_nm, 1e-7)
/// });
/// let elbow = elbow.expect("a second contact");
/// assert!((elbow.theta_a_rad - 1.2).abs() < 0.01 && elbow.is_rigid(1.0 / 1.2, 0.05));
/// ```
#[derive(Clone, Debug)]
pub struct SecondContact {
    points: Deque<[f32; 2], WINDOW>,
    /// Angle from which on the stop holds, radian.
    stop_rad: f32,
    /// The likeliest so far, with its deviations from a smooth curve.
    best: Option<(Elbow, f32)>,
    is_told: bool,
}

impl SecondContact {
    /// From a touch on. Beyond `stop_rad`, the closing stop as the cable's twist included has it, the cable alone gives way
    /// whatever is touched, and nothing is told.
    pub fn new(stop_rad: f32) -> Self {
        Self {
            points: Deque::new(),
            stop_rad,
            best: None,
            is_told: false,
        }
    }

    /// Takes a block of the closing: angle of the input link with the cable's twist, torque above friction, and the variance
    /// of its white noise. Returns the second contact, once, when the blocks after it fit an elbow no better any more.
    pub fn push(&mut self, theta_a_rad: f32, torque_nm: f32, variance_nm2: f32) -> Option<Elbow> {
        let usable = theta_a_rad < self.stop_rad && torque_nm.is_finite();
        if self.is_told || !usable {
            return None;
        }
        if self.points.is_full() {
            self.points.pop_front();
        }
        // There is room now.
        let _ = self.points.push_back([theta_a_rad, torque_nm]);
        let found = self.hinge(variance_nm2);
        match (found, self.best) {
            (Some((elbow, sigmas)), best) if best.is_none_or(|(_, most)| sigmas > most) => {
                self.best = Some((elbow, sigmas));
                None
            }
            (_, Some((elbow, _))) => {
                self.is_told = true;
                Some(elbow)
            }
            _ => None,
        }
    }

    /// The elbow that the window shows, with its size in deviations; `None` where there is none or too few blocks.
    fn hinge(&self, variance_nm2: f32) -> Option<(Elbow, f32)> {
        if !self.points.is_full() {
            return None;
        }
        let [from, _] = *self.points.front()?;
        let [to, _] = *self.points.back()?;
        let [at, level] = *self.points.iter().nth(BEFORE)?;
        let scale = to - from;
        let closes = scale > 0.0;
        if !closes {
            return None;
        }
        // About the hinge and in units of the window: the terms have one size.
        let terms = |theta: f32| {
            let u = (theta - at) / scale;
            [1.0, u, u * u, u.at_least(0.0)]
        };
        let (mut normal, mut right) = ([[0.0f32; TERMS]; TERMS], [0.0f32; TERMS]);
        for [theta, torque] in &self.points {
            let row = terms(*theta);
            for (line, a) in normal.iter_mut().zip(row) {
                for (entry, b) in line.iter_mut().zip(row) {
                    *entry += a * b;
                }
            }
            for (sum, a) in right.iter_mut().zip(row) {
                *sum += a * (torque - level);
            }
        }
        let unit = |term: usize| core::array::from_fn(|i| if i == term { 1.0 } else { 0.0 });
        let [fit, by_slope, by_hinge] = solve(normal, [right, unit(1), unit(3)])?;
        let squares: f32 = (self.points.iter())
            .map(|[theta, torque]| {
                let fitted: f32 = terms(*theta).iter().zip(fit).map(|(a, b)| a * b).sum();
                let off = torque - level - fitted;
                off * off
            })
            .sum();
        // What scatters, or what is known to: the larger.
        let variance = (squares / (WINDOW - TERMS) as f32).at_least(variance_nm2);
        let [offset, slope, _, hinge] = fit;
        let sigmas = hinge / sqrt(variance * by_hinge[3]);
        let after = slope + hinge;
        let after_variance = by_slope[1] + 2.0 * by_slope[3] + by_hinge[3];
        let elbow = Elbow {
            theta_a_rad: at,
            torque_nm: level + offset,
            before_nm_per_rad: slope / scale,
            after_nm_per_rad: after / scale,
            after_sigma_nm_per_rad: sqrt(variance * after_variance) / scale,
        };
        let is_elbow = sigmas > LEAST_SIGMAS && slope > 0.0 && after > LEAST_RATIO * slope;
        is_elbow.then_some((elbow, sigmas))
    }
}
