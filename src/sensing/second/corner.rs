//! The last stretch of a torque-angle curve, and whether it has a corner: a polynomial against one plus a hinge
//! (docs/SECOND_CONTACTS.md#telling-it), by generalised least squares ([`Whitened`]).

use super::whitened::{BEND, HINGE, TERMS, TURN, WAVES, Whitened};
use super::{BlockNoise, SlopeChange};
use crate::numeric::{Bounded, dot, solve, sqrt};
use heapless::{Deque, Vec};

/// Points of a stretch at most. Motor turns of P70 are 5 mrad: some 120 mrad of the input link, and twice that in pairs, four times in fours.
pub(super) const WINDOW: usize = 24;
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
    /// The slope must grow by this factor, and by this one where the curve is taken for a line.
    pub(super) ratio: f32,
    pub(super) line_ratio: f32,
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
        let points = self.points();
        let mut white = Whitened::of(&points, noise)?;
        let mut best: Option<(SlopeChange, f32)> = None;
        for &after in rule.after {
            if let Some((change, sigmas)) = hinge(&points, rule, after, &mut white)
                && change.torque_nm > least_nm
                && best.is_none_or(|(_, most)| sigmas > most)
            {
                best = Some((change, sigmas));
            }
        }
        best
    }

    /// The points in one piece, the oldest first: loops over the queue itself are far larger.
    pub(super) fn points(&self) -> Vec<[f32; 2], WINDOW> {
        let mut points = Vec::new();
        for point in &self.0 {
            // As many as the queue has at most.
            let _ = points.push(*point);
        }
        points
    }
}

/// The change of slope that the points show with so many after it.
fn hinge(
    points: &[[f32; 2]],
    rule: &Rule,
    after: usize,
    white: &mut Whitened,
) -> Option<(SlopeChange, f32)> {
    let number = points.len();
    let before = number.checked_sub(after)?;
    if before < rule.least_before {
        return None;
    }
    let [theta_a_rad, _] = *points.get(before)?;
    let u = white.set_hinge(theta_a_rad);
    let (mut normal, mut right) = (white.normal, white.right);
    // The curve at the hinge by its coefficients, and its slope before and after.
    let mut there = [1.0, u, u * u, u * u * u, 0.0, 0.0, 0.0];
    let mut before_it = [0.0, 1.0, 2.0 * u, 3.0 * u * u, 0.0, 0.0, 0.0];
    // A term that is not there has the coefficient 0.
    let mut terms = HINGE;
    for (term, from) in [(BEND, rule.bends_from), (TURN, rule.turns_from)] {
        if before >= from {
            continue;
        }
        terms -= 1;
        for line in (normal.iter_mut()).chain([&mut right, &mut there, &mut before_it]) {
            if let Some(entry) = line.get_mut(term) {
                *entry = 0.0;
            }
        }
        if let Some(line) = normal.get_mut(term) {
            *line = unit(term);
        }
    }
    let mut after_it = before_it;
    after_it[HINGE] = 1.0;
    let [fit, by_after, by_hinge] = solve(normal, [right, after_it, unit(HINGE)])?;
    // The wave's two terms have a prior: they take no point's freedom.
    let spare = (number + WAVES).checked_sub(terms + 1)?;
    // What scatters, or what is known to: the larger.
    let scatter = (white.squares(&fit) / spare as f32).at_least(1.0);
    let [slope, rises] = [dot(&before_it, &fit), dot(&after_it, &fit)];
    let change = SlopeChange {
        theta_a_rad,
        torque_nm: white.level_nm + dot(&there, &fit),
        before_nm_per_rad: slope / white.scale_rad,
        after_nm_per_rad: rises / white.scale_rad,
        after_sigma_nm_per_rad: sqrt(scatter * dot(&after_it, &by_after)) / white.scale_rad,
        spacing_rad: 2.0 * white.scale_rad / (number - 1) as f32,
    };
    let sigmas = fit[HINGE] / sqrt(scatter * by_hinge[HINGE]);
    let ratio = if before < rule.bends_from {
        rule.line_ratio
    } else {
        rule.ratio
    };
    let is_change = sigmas > rule.sigmas && slope > 0.0 && rises > ratio * slope;
    let last = points.get(number.saturating_sub(3)..).unwrap_or_default();
    let is_steady = last.windows(2).all(|pair| match *pair {
        [[a, below], [b, above]] => {
            above - below > STEADY_SHARE * change.after_nm_per_rad * (b - a)
        }
        _ => true,
    });
    (is_change && is_steady).then_some((change, sigmas))
}

/// One at a term, zero elsewhere.
pub(super) fn unit(term: usize) -> [f32; TERMS] {
    core::array::from_fn(|i| if i == term { 1.0 } else { 0.0 })
}
