//! The torque-angle curve from shortly before the contact on, in fixed memory: means over a geometrically growing number of
//! blocks.
//!
//! Bins divide the angle, which is measured almost without noise: bins over the torque would sort points by their noise and so
//! bend the curve. Near the onset, where the slope changes, a bin is one block; later it is up to eight blocks, over which the
//! curve hardly bends.

use crate::numeric::{Bounded, sqrt};

/// Bins before the contact: they show level and wander of the friction.
const BEFORE: usize = 4;
/// Room for all points.
pub const POINTS: usize = BEFORE + 40;
/// Bins after which their width doubles.
const SAME_WIDTH: usize = 6;
/// How often the width may double.
const MOST_DOUBLINGS: usize = 3;

/// Smallest variance of a point: a micronewton metre squared, far below any noise.
const LEAST_VARIANCE_NM2: f32 = 1e-12;

/// Mean over a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Angle since the curve's origin, counts.
    pub counts: f32,
    /// Time since the curve's origin, second.
    pub time_s: f32,
    /// Torque at the input link above that of the free finger, nominal, newton metre.
    pub excess_nm: f32,
    /// Torque of the free finger at that angle, newton metre.
    pub free_nm: f32,
    /// The excess delayed by the time constant of the cable's creep, newton metre.
    pub late_nm: f32,
    /// Variance of the excess from the noise of its blocks, newton metre squared.
    pub variance_nm2: f32,
    /// Distance over which the mean is taken, counts.
    pub width_counts: f32,
    /// Blocks in the bin; 0 for none.
    pub blocks: u16,
}

impl Point {
    /// An empty point. A constant because arrays of it become a fill; a value would be copied in a loop.
    pub const EMPTY: Self = Self {
        counts: 0.0,
        time_s: 0.0,
        excess_nm: 0.0,
        free_nm: 0.0,
        late_nm: 0.0,
        variance_nm2: 0.0,
        width_counts: 0.0,
        blocks: 0,
    };

    /// Merges another bin.
    #[inline(never)]
    fn join(&mut self, other: &Self) {
        let blocks = self.blocks.saturating_add(other.blocks);
        if blocks == 0 {
            return;
        }
        let mine = f32::from(self.blocks) / f32::from(blocks);
        let others = 1.0 - mine;
        self.counts = mine * self.counts + others * other.counts;
        self.time_s = mine * self.time_s + others * other.time_s;
        self.excess_nm = mine * self.excess_nm + others * other.excess_nm;
        self.free_nm = mine * self.free_nm + others * other.free_nm;
        self.late_nm = mine * self.late_nm + others * other.late_nm;
        self.variance_nm2 = mine * mine * self.variance_nm2 + others * others * other.variance_nm2;
        self.width_counts += other.width_counts;
        self.blocks = blocks;
    }

    fn is_finite(&self) -> bool {
        // The sum is not finite if any of them is not.
        let sum = self.excess_nm + self.free_nm + self.late_nm + self.variance_nm2 + self.time_s;
        sum.is_finite()
    }
}

/// The curve. A complete point does not change any more, so a fit of the points so far may go on while new ones are added.
#[derive(Clone, Debug)]
pub struct Curve {
    origin_counts: i32,
    points: [Point; POINTS],
    /// Index of the first point in use: a short history fills fewer of those before the contact.
    first: usize,
    /// The point that is being filled.
    filling: usize,
}

impl Curve {
    /// An empty curve whose angles count from a position.
    pub fn new(origin_counts: i32) -> Self {
        Self {
            origin_counts,
            points: const { [Point::EMPTY; POINTS] },
            first: BEFORE,
            filling: BEFORE,
        }
    }

    /// Encoder position from which the curve's angles count.
    pub fn origin_counts(&self) -> i32 {
        self.origin_counts
    }

    /// Adds a block from before the origin, the `index`-th of `number`. A block with NaN is ignored.
    pub fn push_before(&mut self, index: usize, number: usize, counts: i32, block: Point) {
        let block = self.placed(counts, block);
        let bins = number.min(BEFORE);
        self.first = BEFORE - bins;
        let index = self.first + index * bins / number.max(1);
        if block.is_finite()
            && let Some(bin) = self.points.iter_mut().take(BEFORE).nth(index)
        {
            bin.join(&block);
        }
    }

    /// Adds a block at or after the origin; positions must rise. Ignored are an earlier block, one with NaN, and every block once
    /// all bins are full.
    pub fn push(&mut self, counts: i32, block: Point) {
        let block = self.placed(counts, block);
        if block.counts < 0.0 || !block.is_finite() {
            return;
        }
        let Some(bin) = self.points.get(self.filling) else {
            return;
        };
        let doublings = ((self.filling - BEFORE) / SAME_WIDTH).min(MOST_DOUBLINGS);
        if bin.blocks >= 1 << doublings {
            self.filling += 1;
        }
        if let Some(bin) = self.points.get_mut(self.filling) {
            bin.join(&block);
        }
    }

    /// Drops the points that reach beyond a position: something else acts there. Leaves all if fewer than `least` would be left.
    /// Returns whether it dropped any.
    pub fn cut(&mut self, counts: i32, least: usize) -> bool {
        let end = counts.wrapping_sub(self.origin_counts) as f32;
        let reaches = |point: &Point| point.counts + 0.5 * point.width_counts > end;
        let since = self.points.get(BEFORE..).unwrap_or_default();
        let kept = since
            .iter()
            .take_while(|p| p.blocks > 0 && !reaches(p))
            .count();
        let is_shorter = since.get(kept).is_some_and(|point| point.blocks > 0);
        if kept < least || !is_shorter {
            return false;
        }
        self.filling = BEFORE + kept;
        for point in self.points.iter_mut().skip(self.filling) {
            *point = Point::EMPTY;
        }
        true
    }

    fn placed(&self, counts: i32, block: Point) -> Point {
        Point {
            counts: counts.wrapping_sub(self.origin_counts) as f32,
            blocks: 1,
            ..block
        }
    }

    /// The complete points, by rising angle.
    pub fn complete(&self) -> &[Point] {
        self.up_to(self.filling)
    }

    /// All points, including the one that is being filled.
    pub fn points(&self) -> &[Point] {
        let filled = self.points.get(self.filling).is_some_and(|p| p.blocks > 0);
        self.up_to(self.filling + usize::from(filled))
    }

    fn up_to(&self, end: usize) -> &[Point] {
        self.points.get(self.first..end).unwrap_or(&self.points)
    }
}

/// Slope of angle over torque by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Angle over torque, counts per newton metre.
    pub counts_per_nm: f32,
    /// Its standard deviation from the torque's noise.
    pub sigma_counts_per_nm: f32,
}

/// Straight line through the points from the origin up to a share of the largest excess, with the cable's creep (share `creep`)
/// taken as part of the torque. Uses at least three points; None if there are fewer, or if the torque does not rise.
///
/// The torque is regressed on the angle, which has no noise, and the slope inverted: regressing the angle on the noisy torque
/// would flatten it.
pub fn slope(points: &[Point], share: f32, creep: f32) -> Option<Slope> {
    let since = |p: &&Point| p.time_s >= 0.0 && p.blocks > 0;
    let torque = |p: &Point| p.excess_nm + p.free_nm + creep * p.late_nm;
    let weight = |p: &Point| 1.0 / p.variance_nm2.at_least(LEAST_VARIANCE_NM2);
    let mut top_nm = 0.0f32;
    for p in points.iter().filter(since) {
        top_nm = p.excess_nm.at_least(top_nm);
    }
    // Number of points used, and where they end.
    let (mut number, mut end) = (0, 0);
    let mut steep = false;
    let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
    for (index, p) in points.iter().enumerate().filter(|(_, p)| since(p)) {
        steep |= p.excess_nm > share * top_nm;
        if steep && number >= 3 {
            break;
        }
        (number, end) = (number + 1, index + 1);
        sum += weight(p);
        x += weight(p) * p.counts;
        y += weight(p) * torque(p);
    }
    if number < 3 {
        return None;
    }
    // A second pass about the mean, so that nothing cancels.
    let (x, y) = (x / sum, y / sum);
    let (mut xx, mut xy) = (0.0, 0.0);
    for p in points.iter().take(end).filter(since) {
        xx += weight(p) * (p.counts - x) * (p.counts - x);
        xy += weight(p) * (p.counts - x) * (torque(p) - y);
    }
    let counts_per_nm = xx / xy;
    // In this form a NaN fails too.
    if !(counts_per_nm > 0.0 && counts_per_nm < f32::INFINITY) {
        return None;
    }
    Some(Slope {
        counts_per_nm,
        sigma_counts_per_nm: counts_per_nm * counts_per_nm / sqrt(xx),
    })
}
