//! A second contact: where the slope of torque over angle jumps after the first (docs/MECHANICS.md#two-contacts).
//!
//! Independent of the [`Sensor`](super::Sensor): it takes the blocks of a closing after the sensor has reported a touch.
//! [`Follow`](super::Follow) does so in a scene with that option.
//!
//! With a single contact the slope of the curve changes smoothly, at a second one it jumps. Over the last blocks since the first
//! contact a parabola (a line, while they are few) is compared with one plus a hinge. Worm and wandering friction bend the curve
//! too, but slowly and far less.

use crate::numeric::{Bounded, solve, sqrt};
use heapless::Deque;

/// Blocks of the curve at most. Motor turns of P70 are 5 mrad: some 120 mrad of the input link.
const WINDOW: usize = 24;
/// Blocks before the hinge at least, and from how many on the curve may bend by itself: fewer do not show a curvature.
const LEAST_BEFORE: usize = 4;
const BENDS_FROM: usize = 12;
/// Blocks after the hinge with which one is sought. What is found with few may be the best when the motion ends.
const AFTER: [usize; 4] = [3, 4, 6, 8];
/// Terms of the curve: constant, slope, curvature, hinge.
const TERMS: usize = 4;
/// The slope must grow by this factor (chosen): that of a single contact grows too, but over several windows. If the first
/// contact leaves two thirds of the cable's stiffness, a second one changes the slope by exactly this factor.
const LEAST_RATIO: f32 = 1.5;
/// And by this many standard deviations of the hinge.
const LEAST_SIGMAS: f32 = 8.0;
/// Within this share of the cable's stiffness the finger counts as rigid.
const RIGID_SHARE: f32 = 0.25;
/// Each of the last two blocks must rise by this share of the slope after the hinge: a drive that goes over to another current
/// makes a step, and no slope.
const STEADY_SHARE: f32 = 0.4;

/// A second contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeChange {
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

impl SlopeChange {
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
/// // A first contact of 0.2 N m/rad at 0.6 rad, felt at 0.65; from 1.2 rad on something else holds, and only the cable of
/// // 1.2 N m/rad gives way.
/// let mut search = SecondContact::default();
/// let change = (0..200).find_map(|block| {
///     let theta_a_rad = 0.5 + 0.005 * block as f32;
///     let torque_nm = 0.2 * (theta_a_rad - 0.6).max(0.0) + (theta_a_rad - 1.2).max(0.0);
///     if theta_a_rad < 0.65 {
///         search.note(theta_a_rad, torque_nm);
///         return None;
///     }
///     search.begin(0.6, 0.0, 0.01);
///     search.push(theta_a_rad, torque_nm, 1e-7)
/// });
/// let change = change.expect("a second contact");
/// assert!((change.theta_a_rad - 1.2).abs() < 0.01 && change.is_rigid(1.0 / 1.2, 0.05));
/// ```
#[derive(Clone, Debug, Default)]
pub struct SecondContact {
    points: Deque<[f32; 2], WINDOW>,
    /// A second contact's torque at least; none before the first contact.
    least_nm: Option<f32>,
    /// The likeliest so far, with its deviations from a smooth curve.
    best: Option<(SlopeChange, f32)>,
    is_told: bool,
}

impl SecondContact {
    /// Remembers a block of a closing in which nothing is felt yet: a contact is felt some blocks after it began.
    pub fn note(&mut self, theta_a_rad: f32, torque_nm: f32) {
        if self.points.is_full() {
            self.points.pop_front();
        }
        // There is room now.
        let _ = self.points.push_back([theta_a_rad, torque_nm]);
    }

    /// A contact is felt that began at `onset_rad`, where the torque was `level_nm`; once a closing, later calls change
    /// nothing. Below `least_nm` above that the first contact's own onset bends the curve.
    pub fn begin(&mut self, onset_rad: f32, level_nm: f32, least_nm: f32) {
        if self.least_nm.replace(least_nm).is_some() {
            return;
        }
        for _ in 0..self.points.len() {
            if let Some([theta, torque]) = self.points.pop_front()
                && theta >= onset_rad
            {
                self.note(theta, torque - level_nm);
            }
        }
    }

    /// Takes a block of the closing in contact: angle of the input link with the cable's twist, torque above friction, and
    /// the variance of its white noise. Returns the second contact, once, when the blocks after it fit a change of slope no better any
    /// more.
    pub fn push(
        &mut self,
        theta_a_rad: f32,
        torque_nm: f32,
        variance_nm2: f32,
    ) -> Option<SlopeChange> {
        if self.is_told || !torque_nm.is_finite() {
            return None;
        }
        self.note(theta_a_rad, torque_nm);
        let mut is_better = false;
        for after in AFTER {
            if let Some((change, sigmas)) = self.hinge(after, variance_nm2)
                && self.best.is_none_or(|(_, most)| sigmas > most)
            {
                self.best = Some((change, sigmas));
                is_better = true;
            }
        }
        if is_better { None } else { self.finish() }
    }

    /// The motion is over, and no more blocks come: the second contact that they show, if it was not told.
    pub fn finish(&mut self) -> Option<SlopeChange> {
        let (change, _) = self.best.filter(|_| !self.is_told)?;
        self.is_told = true;
        Some(change)
    }

    /// The change of slope that the blocks show with so many after it, with its size in deviations; `None` where there is none or too
    /// few blocks before it.
    fn hinge(&self, after: usize, variance_nm2: f32) -> Option<(SlopeChange, f32)> {
        let before = self.points.len().checked_sub(after)?;
        if before < LEAST_BEFORE {
            return None;
        }
        let [from, _] = *self.points.front()?;
        let [to, _] = *self.points.back()?;
        let [at, level] = *self.points.iter().nth(before)?;
        let scale = to - from;
        let closes = scale > 0.0;
        if !closes {
            return None;
        }
        let bends = before >= BENDS_FROM;
        // About the hinge and in units of the window: the terms have one size.
        let terms = |theta: f32| {
            let u = (theta - at) / scale;
            [1.0, u, if bends { u * u } else { 0.0 }, u.at_least(0.0)]
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
        if !bends {
            // The term is not there: its coefficient is 0.
            normal[2][2] = 1.0;
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
        let spare = self.points.len() + usize::from(!bends) - TERMS;
        // What scatters, or what is known to: the larger.
        let variance = (squares / spare as f32).at_least(variance_nm2);
        let [offset, slope, _, hinge] = fit;
        let sigmas = hinge / sqrt(variance * by_hinge[3]);
        let rises = slope + hinge;
        let after_variance = by_slope[1] + 2.0 * by_slope[3] + by_hinge[3];
        let change = SlopeChange {
            theta_a_rad: at,
            torque_nm: level + offset,
            before_nm_per_rad: slope / scale,
            after_nm_per_rad: rises / scale,
            after_sigma_nm_per_rad: sqrt(variance * after_variance) / scale,
        };
        let is_change = sigmas > LEAST_SIGMAS
            && slope > 0.0
            && rises > LEAST_RATIO * slope
            && change.torque_nm > self.least_nm?;
        let is_steady = (self.points.iter().zip(self.points.iter().skip(1)))
            .skip(self.points.len() - 3)
            .all(|([a, below], [b, above])| {
                above - below > STEADY_SHARE * change.after_nm_per_rad * (b - a)
            });
        (is_change && is_steady).then_some((change, sigmas))
    }
}
