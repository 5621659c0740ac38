//! The last stretch of a torque-angle curve, and whether it has a corner: a polynomial against one plus a hinge
//! (docs/MECHANICS.md#two-contacts).

use super::{BlockNoise, SlopeChange};
use crate::numeric::{Bounded, dot, sin_cos, solve, sqrt};
use crate::sensing::locator::WAVE_SHARE;
use core::f32::consts::TAU;
use heapless::Deque;

/// Points of a stretch at most. Motor turns of P70 are 5 mrad: some 120 mrad of the input link, or twice that in pairs.
pub(super) const WINDOW: usize = 24;
/// Points before the hinge at least.
const LEAST_BEFORE: usize = 4;
/// Terms of the curve: constant, slope, curvature, change of curvature, hinge.
const TERMS: usize = 5;
/// The last of them.
const HINGE: usize = TERMS - 1;
/// Each of the last two points must rise by this share of the slope after the hinge: a drive that goes over to another current
/// makes a step, and no slope.
const STEADY_SHARE: f32 = 0.4;

/// What counts as a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// Points after the hinge with which one is sought. What is found with few may be the best when the motion ends.
    pub(super) after: &'static [usize],
    /// Points before it from which on the curve may bend by itself, and from which on by more than a parabola: fewer do not show
    /// it.
    pub(super) bends_from: usize,
    pub(super) turns_from: usize,
    /// Points before the hinge at least.
    pub(super) least_before: usize,
    /// The slope must grow by this factor.
    pub(super) ratio: f32,
    /// And by this many standard deviations of the hinge.
    pub(super) sigmas: f32,
}

/// The last points of a curve: angle and torque.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretch(pub(super) Deque<[f32; 2], WINDOW>);

impl Stretch {
    pub(super) fn note(&mut self, point: [f32; 2]) {
        if self.0.is_full() {
            self.0.pop_front();
        }
        // There is room now.
        let _ = self.0.push_back(point);
    }

    /// Leaves out what lies before a contact, and takes what the level was off by.
    pub(super) fn begin(&mut self, onset_rad: f32, level_nm: f32) {
        for _ in 0..self.0.len() {
            if let Some([theta, torque]) = self.0.pop_front()
                && theta >= onset_rad
            {
                self.note([theta, torque - level_nm]);
            }
        }
    }

    /// The likeliest corner with its size in deviations; `None` where there is none or too few points before it.
    pub(super) fn corner(
        &self,
        rule: &Rule,
        least_nm: f32,
        noise: &BlockNoise,
    ) -> Option<(SlopeChange, f32)> {
        let mut best: Option<(SlopeChange, f32)> = None;
        for &after in rule.after {
            if let Some((change, sigmas)) = self.hinge(rule, after, noise)
                && change.torque_nm > least_nm
                && best.is_none_or(|(_, most)| sigmas > most)
            {
                best = Some((change, sigmas));
            }
        }
        best
    }

    /// The change of slope that the points show with so many after it.
    fn hinge(&self, rule: &Rule, after: usize, noise: &BlockNoise) -> Option<(SlopeChange, f32)> {
        let before = self.0.len().checked_sub(after)?;
        if before < rule.least_before.max(LEAST_BEFORE) {
            return None;
        }
        let [from, _] = *self.0.front()?;
        let [to, _] = *self.0.back()?;
        let [at, level] = *self.0.iter().nth(before)?;
        let scale = to - from;
        let closes = scale > 0.0;
        if !closes {
            return None;
        }
        let (bends, turns) = (before >= rule.bends_from, before >= rule.turns_from);
        // About the hinge and in units of the stretch: the terms have one size.
        let terms = |theta: f32| {
            let u = (theta - at) / scale;
            let bent = if bends { u * u } else { 0.0 };
            let turned = if turns { u * u * u } else { 0.0 };
            [1.0, u, bent, turned, u.at_least(0.0)]
        };
        let (mut normal, mut right) = ([[0.0f32; TERMS]; TERMS], [0.0f32; TERMS]);
        for [theta, torque] in &self.0 {
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
        // A term that is not there has the coefficient 0.
        if !bends {
            normal[2][2] = 1.0;
        }
        if !turns {
            normal[3][3] = 1.0;
        }
        let unit = |term: usize| core::array::from_fn(|i| if i == term { 1.0 } else { 0.0 });
        let [fit, by_slope, by_hinge] = solve(normal, [right, unit(1), unit(HINGE)])?;
        let squares: f32 = (self.0.iter())
            .map(|[theta, torque]| {
                let fitted: f32 = terms(*theta).iter().zip(fit).map(|(a, b)| a * b).sum();
                let off = torque - level - fitted;
                off * off
            })
            .sum();
        let unused = usize::from(!bends) + usize::from(!turns);
        let spare = (self.0.len() + unused).checked_sub(TERMS)?;
        // What scatters, or what is known to: the larger.
        let variance = (squares / spare as f32).at_least(noise.white_nm2);
        let [offset, slope, _, _, hinge] = fit;
        let rises = slope + hinge;
        let after_variance = by_slope[1] + 2.0 * by_slope[HINGE] + by_hinge[HINGE];
        let change = SlopeChange {
            theta_a_rad: at,
            torque_nm: level + offset,
            before_nm_per_rad: slope / scale,
            after_nm_per_rad: rises / scale,
            after_sigma_nm_per_rad: sqrt(variance * after_variance) / scale,
        };
        let own = variance * by_hinge[HINGE];
        let is_change =
            hinge > rule.sigmas * sqrt(own) && slope > 0.0 && rises > rule.ratio * slope;
        let is_steady = (self.0.iter().zip(self.0.iter().skip(1)))
            .skip(self.0.len() - 3)
            .all(|([a, below], [b, above])| {
                above - below > STEADY_SHARE * change.after_nm_per_rad * (b - a)
            });
        if !(is_change && is_steady) {
            return None;
        }
        // The slow part is computed last: few stretches pass the checks above.
        let slowly = self.slowly(noise, |theta| [theta - at, dot(&by_hinge, &terms(theta))]);
        let sigmas = hinge / sqrt(own + slowly);
        (sigmas > rule.sigmas).then_some((change, sigmas))
    }

    /// Returns the variance of a weighted sum of the torques due to slow disturbances: wandering friction, and the efficiency's
    /// wave over a turn of the worm, whose amplitude and phase are not known. `part` maps an angle to its distance from a fixed
    /// angle and to the weight of its torque.
    fn slowly(&self, noise: &BlockNoise, part: impl Fn(f32) -> [f32; 2]) -> f32 {
        let (mut rest, mut walked, mut wave) = (0.0, 0.0, [0.0; 2]);
        // A change of friction between two blocks stays in all later ones: the weights of those are added up from the end.
        for [theta, torque] in self.0.iter().rev() {
            let [from_rad, weight] = part(*theta);
            rest += weight;
            walked += rest * rest;
            let (sin, cos) = sin_cos(TAU / noise.worm_turn_rad * from_rad);
            let [of_sin, of_cos] = &mut wave;
            *of_sin += weight * torque * sin;
            *of_cos += weight * torque * cos;
        }
        noise.walk_nm2 * walked + WAVE_SHARE * WAVE_SHARE * dot(&wave, &wave)
    }
}
