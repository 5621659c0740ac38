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
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Nothing. A constant, as arrays of it are: they are filled, where a value would be copied in a loop.
    pub const EMPTY: Self = Self {
        counts: 0.0,
        torque_nm: 0.0,
        late_nm: 0.0,
        inertia_nm: 0.0,
        variance_nm2: 0.0,
        blocks: 0,
    };

    /// Takes another bin in.
    #[inline(never)]
    fn join(&mut self, other: &Self) {
        let blocks = self.blocks.saturating_add(other.blocks);
        if blocks == 0 {
            return;
        }
        let mine = f32::from(self.blocks) / f32::from(blocks);
        let others = 1.0 - mine;
        self.counts = mine * self.counts + others * other.counts;
        self.torque_nm = mine * self.torque_nm + others * other.torque_nm;
        self.late_nm = mine * self.late_nm + others * other.late_nm;
        self.inertia_nm = mine * self.inertia_nm + others * other.inertia_nm;
        self.variance_nm2 = mine * mine * self.variance_nm2 + others * others * other.variance_nm2;
        self.blocks = blocks;
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
            bins: const { [Point::EMPTY; BINS] },
        }
    }

    /// Where the curve's angles count from.
    pub fn origin_counts(&self) -> i32 {
        self.origin_counts
    }

    /// Takes the means of a block at a position. One before the origin, or that is not a number, is ignored.
    pub fn push(&mut self, counts: i32, block: Point) {
        let way_counts = counts.wrapping_sub(self.origin_counts);
        // Not finite as soon as one of them is not.
        let sum = block.torque_nm + block.late_nm + block.inertia_nm + block.variance_nm2;
        if way_counts < 0 || !sum.is_finite() {
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
            bin.join(&point);
        }
    }

    /// Neighbours become one, twice as wide. In place: no bin is written before it has been read.
    fn halve(&mut self) {
        for to in 0..BINS / 2 {
            let mut pair = self.bins[2 * to];
            pair.join(&self.bins[2 * to + 1]);
            self.bins[to] = pair;
        }
        if let Some(upper) = self.bins.last_chunk_mut() {
            *upper = const { [Point::EMPTY; BINS / 2] };
        }
        self.width_counts *= 2.0;
    }

    /// All bins by rising angle, the empty ones among them.
    pub fn bins(&self) -> &[Point] {
        &self.bins
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

/// Weighted sums over points, coordinates taken from a centre.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    points: u16,
    weight: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
}

impl Moments {
    /// Over the points of [`slope`] about the centre (counts, torque).
    // Not inlined: wanted twice.
    #[inline(never)]
    fn about(center: (f32, f32), points: &[Point], from_nm: f32, creep: f32) -> Self {
        let mut sums = Self::default();
        for p in points {
            if p.blocks == 0 || p.torque_nm < from_nm {
                continue;
            }
            let weight = 1.0 / p.variance_nm2.at_least(LEAST_VARIANCE_NM2);
            let x = p.counts - center.0;
            let y = p.torque_nm + creep * p.late_nm - center.1;
            sums.points = sums.points.saturating_add(1);
            sums.weight += weight;
            sums.x += weight * x;
            sums.y += weight * y;
            sums.xx += weight * x * x;
            sums.xy += weight * x * y;
        }
        sums
    }
}

/// Straight line through the points above a torque, the cable's creep of a share `creep` taken as part of the torque.
/// Empty bins do not count. None with fewer than three, or where the torque does not vary.
///
/// The torque is regressed on the angle, which is the one without noise, and the slope inverted: the other way round the
/// noise would flatten it.
pub fn slope(points: &[Point], from_nm: f32, creep: f32) -> Option<Slope> {
    let all = Moments::about((0.0, 0.0), points, from_nm, creep);
    if all.points < 3 {
        return None;
    }
    let (x, y) = (all.x / all.weight, all.y / all.weight);
    // Again about the mean, where nothing cancels.
    let Moments { xx, xy, .. } = Moments::about((x, y), points, from_nm, creep);
    let counts_per_nm = xx / xy;
    // Written so that a NaN fails.
    if !(counts_per_nm > 0.0 && counts_per_nm < f32::INFINITY) {
        return None;
    }
    Some(Slope {
        counts_per_nm,
        sigma_counts_per_nm: counts_per_nm * counts_per_nm / crate::numeric::sqrt(xx),
        onset_counts: x - y * counts_per_nm,
        points: all.points,
    })
}
