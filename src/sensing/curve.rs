//! The torque-angle curve since contact, in fixed memory: bins over the angle, whose width doubles when they are used up.
//!
//! Bins divide the angle, which is measured almost without noise; bins over the torque would sort its noise and so bend
//! the curve.

use crate::numeric::Bounded;

/// Number of bins.
pub const BINS: usize = 24;

/// Least variance that a point weighs by: a micronewton metre squared, far below any noise.
const LEAST_VARIANCE_NM2: f32 = 1e-12;

/// Mean over a bin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Angle since the curve's origin, counts.
    pub counts: f32,
    /// Torque at the input link, newton metre.
    pub torque_nm: f32,
    /// Torque above that of the contact as the cable's creep feels it, delayed by its time constant, newton metre.
    pub late_nm: f32,
    /// Of the torque, what was taken for the change of speed, newton metre.
    pub inertia_nm: f32,
    /// Variance of the torque's mean, newton metre squared.
    pub variance_nm2: f32,
    /// Blocks in the bin; 0 for none.
    pub blocks: u16,
}

impl Point {
    /// Both bins as one.
    #[inline(never)]
    fn with(self, other: Self) -> Self {
        let blocks = self.blocks.saturating_add(other.blocks);
        if blocks == 0 {
            return self;
        }
        let mine = f32::from(self.blocks) / f32::from(blocks);
        let others = 1.0 - mine;
        Self {
            counts: mine * self.counts + others * other.counts,
            torque_nm: mine * self.torque_nm + others * other.torque_nm,
            late_nm: mine * self.late_nm + others * other.late_nm,
            inertia_nm: mine * self.inertia_nm + others * other.inertia_nm,
            variance_nm2: mine * mine * self.variance_nm2 + others * others * other.variance_nm2,
            blocks,
        }
    }
}

/// The curve.
#[derive(Clone, Debug)]
pub struct Curve {
    origin_counts: i32,
    width_counts: f32,
    bins: [Point; BINS],
}

impl Curve {
    /// An empty curve from a position on, with bins of some first width, counts.
    pub fn new(origin_counts: i32, width_counts: u32) -> Self {
        Self {
            origin_counts,
            width_counts: width_counts.max(1) as f32,
            bins: [Point::default(); BINS],
        }
    }

    /// Where the curve's angles count from.
    pub fn origin_counts(&self) -> i32 {
        self.origin_counts
    }

    /// Takes the means of a block at a position. One before the origin, or that is not a number, is ignored.
    pub fn push(&mut self, counts: i32, block: Point) {
        let way_counts = counts.wrapping_sub(self.origin_counts);
        let sound = block.torque_nm.is_finite()
            && block.late_nm.is_finite()
            && block.inertia_nm.is_finite()
            && block.variance_nm2.is_finite();
        if way_counts < 0 || !sound {
            return;
        }
        let point = Point {
            counts: way_counts as f32,
            blocks: 1,
            ..block
        };
        while point.counts >= self.width_counts * BINS as f32 {
            self.halve();
        }
        let index = (point.counts / self.width_counts) as usize;
        if let Some(bin) = self.bins.get_mut(index) {
            *bin = bin.with(point);
        }
    }

    /// Neighbours become one, twice as wide. In place: no bin is written before it has been read.
    fn halve(&mut self) {
        for to in 0..BINS {
            let pair = [2 * to, 2 * to + 1].map(|from| self.bins.get(from).copied());
            let [first, second] = pair.map(Option::unwrap_or_default);
            self.bins[to] = first.with(second);
        }
        self.width_counts *= 2.0;
    }

    /// The bins that hold anything, by rising angle.
    pub fn points(&self) -> impl Iterator<Item = &Point> + Clone {
        self.bins.iter().filter(|bin| bin.blocks > 0)
    }

    /// The last of them.
    pub fn last(&self) -> Option<&Point> {
        self.bins.iter().rev().find(|bin| bin.blocks > 0)
    }
}

/// Slope of angle over torque by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Angle over torque, counts per newton metre.
    pub counts_per_nm: f32,
    /// Its standard deviation from the torque's noise.
    pub sigma_counts_per_nm: f32,
    /// Angle where the torque is zero, counts.
    pub onset_counts: f32,
    /// Points used.
    pub points: u16,
}

/// Straight line through the points above a torque, the cable's creep of a share `creep` taken as part of the torque. None with fewer than three, or where the torque does not vary.
///
/// The torque is regressed on the angle, which is the one without noise, and the slope inverted: the other way round the
/// noise would flatten it.
pub fn slope<'a>(
    points: impl Iterator<Item = &'a Point> + Clone,
    from_nm: f32,
    creep: f32,
) -> Option<Slope> {
    let chosen = points.filter(|p| p.torque_nm >= from_nm);
    let (mut weight, mut x, mut y, mut count) = (0.0, 0.0, 0.0, 0u16);
    for p in chosen.clone() {
        let w = 1.0 / p.variance_nm2.at_least(LEAST_VARIANCE_NM2);
        weight += w;
        x += w * p.counts;
        y += w * (p.torque_nm + creep * p.late_nm);
        count = count.saturating_add(1);
    }
    if count < 3 {
        return None;
    }
    let (x, y) = (x / weight, y / weight);
    let (mut xx, mut xy) = (0.0, 0.0);
    for p in chosen {
        let w = 1.0 / p.variance_nm2.at_least(LEAST_VARIANCE_NM2);
        xx += w * (p.counts - x) * (p.counts - x);
        xy += w * (p.counts - x) * (p.torque_nm + creep * p.late_nm - y);
    }
    let stiffness = xy / xx;
    if !(stiffness.is_finite() && stiffness > 0.0 && xx > 0.0) {
        return None;
    }
    let counts_per_nm = 1.0 / stiffness;
    Some(Slope {
        counts_per_nm,
        sigma_counts_per_nm: counts_per_nm * counts_per_nm / crate::numeric::sqrt(xx),
        onset_counts: x - y * counts_per_nm,
        points: count,
    })
}
