//! A second contact: where the slope of torque over angle jumps after the first (docs/SECOND_CONTACTS.md#telling-it).
//!
//! Independent of the [`Sensor`](super::Sensor): it takes the blocks of a closing after the sensor has reported a touch.
//! [`Follow`](super::Follow) does so in a scene with that option.
//!
//! With a single contact the slope of the curve changes smoothly, at a second one it jumps. The last blocks since the first contact are
//! compared three times with a curve that has a corner: as they are, against a parabola (a line, while they are few), and in pairs and
//! in fours, twice and four times as far back, against a cubic. Worm and wandering friction bend the curve too, but far less.

mod change;
mod corner;
mod later;
mod noise;
mod straight;
mod whitened;

pub use change::SlopeChange;
use corner::{Rule, Stretch};
pub use later::Later;
pub use noise::BlockNoise;
use straight::Straight;

/// Blocks as they are. The slope must grow by half (chosen): that of a single contact grows too, but over several windows. Over a stretch
/// too short to show a bend it must double: right after a touch near the tip of `tendon3` a single contact's slope grows by half.
const BLOCKS: Rule = Rule {
    after: &[3, 4, 6, 8],
    bends_from: 12,
    turns_from: usize::MAX,
    least_before: 4,
    ratio: 1.5,
    line_ratio: 2.0,
    sigmas: 8.0,
};
/// The same on three phalanges and more (chosen: of 1,007 single contacts of `tendon3` and `linkage3` no more make a corner than with 8,
/// nor of 34 others where the slope must double; of 429 of `p70` six more do, and there every second contact is told with 8).
const BLOCKS_OF_THREE: Rule = Rule {
    sigmas: 6.0,
    ..BLOCKS
};
/// Pairs of blocks: a cubic leaves so little of what a single contact bends that a quarter counts (chosen on drawn fingers of two
/// seeds, three scenes and two worlds: with a growth of 0.15 fourteen times as many single contacts made a corner as with 0.2, and second
/// contacts are told as well with 0.3), and 4.5 deviations (chosen: of 597 single contacts in `workshop` and `harsh` none is told as two).
const PAIRS: Rule = Rule {
    after: &[3, 4, 6, 8, 12],
    bends_from: 0,
    turns_from: 0,
    least_before: 8,
    ratio: 1.25,
    line_ratio: 1.25,
    sigmas: 4.5,
};
/// Pairs of pairs: a corner grows with the way, what wanders with its root (chosen: of 411 single contacts none has more than 3.1).
const FOURS: Rule = Rule {
    after: &[3, 4, 6, 8, 12],
    bends_from: 0,
    turns_from: 0,
    least_before: 8,
    ratio: 1.25,
    line_ratio: 1.25,
    sigmas: 3.5,
};
const SCALES: usize = 3;
/// Blocks before a break in the motion that may show the drive rather than the finger: it goes over to another current.
pub(super) const DOUBTFUL: usize = 2;

/// Looks for the second contact of a closing.
///
/// ```
/// use palpate::sensing::second::{BlockNoise, SecondContact};
///
/// // A first contact of 0.2 N m/rad at 0.6 rad, felt at 0.65; from 1.2 rad on something else holds, and only the cable of
/// // 1.2 N m/rad gives way.
/// let noise = BlockNoise { white_nm2: 1e-7, walk_nm2: 0.0, worm_turn_rad: 0.3, worm_error_rad: 0.0 };
/// let mut search = SecondContact::default();
/// let change = (0..200).find_map(|block| {
///     let theta_a_rad = 0.5 + 0.005 * block as f32;
///     let torque_nm = 0.2 * (theta_a_rad - 0.6).max(0.0) + (theta_a_rad - 1.2).max(0.0);
///     if theta_a_rad < 0.65 {
///         search.note(theta_a_rad, torque_nm);
///         return None;
///     }
///     search.begin(0.6, 0.0, 0.01);
///     search.push(theta_a_rad, torque_nm, &noise, false)
/// });
/// let change = change.expect("a second contact");
/// assert!((change.theta_a_rad - 1.2).abs() < 0.01 && change.is_rigid(1.0 / 1.2, 0.05));
/// ```
#[derive(Clone, Debug, Default)]
pub struct SecondContact {
    scales: [Scale; SCALES],
    /// A second contact's torque at least; none before the first contact.
    least_nm: Option<f32>,
    /// The likeliest by now, and what it was before each of the last blocks.
    best: [Option<Found>; 1 + DOUBTFUL],
    is_told: bool,
    straight: Straight,
}

/// The last stretch of the curve, in blocks or in means of some.
#[derive(Clone, Debug, Default)]
struct Scale {
    stretch: Stretch,
    /// First half of a point of the next scale.
    half: Option<[f32; 2]>,
}

/// A change of slope.
#[derive(Clone, Copy, Debug)]
struct Found {
    change: SlopeChange,
    /// Its deviations from a smooth curve.
    sigmas: f32,
    /// In which scale it was found.
    scale: usize,
}

impl SecondContact {
    /// Remembers a block of a closing in which nothing is felt yet: a contact is felt some blocks after it began.
    pub fn note(&mut self, theta_a_rad: f32, torque_nm: f32) {
        let mut point = Some([theta_a_rad, torque_nm]);
        for scale in &mut self.scales {
            let Some([theta, torque]) = point else {
                break;
            };
            scale.stretch.note([theta, torque]);
            point = match scale.half.take() {
                Some([before, below]) => Some([0.5 * (before + theta), 0.5 * (below + torque)]),
                None => {
                    scale.half = Some([theta, torque]);
                    None
                }
            };
        }
    }

    /// A contact is felt that began at `onset_rad`, where the torque was `level_nm`; once a closing, later calls change
    /// nothing. Below `least_nm` above that the first contact's own onset bends the curve.
    pub fn begin(&mut self, onset_rad: f32, level_nm: f32, least_nm: f32) {
        if self.least_nm.is_some() {
            return;
        }
        self.least_nm = Some(least_nm);
        for scale in &mut self.scales {
            scale.stretch.begin(onset_rad, level_nm);
            scale.half = None;
        }
    }

    /// Takes a block of the closing in contact: angle of the input link with the cable's twist, torque above friction, the torque's noise,
    /// and whether the finger moves on after a second contact, as one of three phalanges does. Returns the second contact, once, when the
    /// blocks after it fit a change of slope no better any more.
    pub fn push(
        &mut self,
        theta_a_rad: f32,
        torque_nm: f32,
        noise: &BlockNoise,
        moves_on: bool,
    ) -> Option<SlopeChange> {
        if !torque_nm.is_finite() {
            return None;
        }
        self.note(theta_a_rad, torque_nm);
        let least_nm = self.least_nm?;
        if self.is_told {
            return None;
        }
        let [last, ..] = self.best;
        let (mut best, mut noise) = (last, *noise);
        let (mut is_better, mut waits) = (false, false);
        let [blocks, pairs, _] = &self.scales;
        // A scale shows something new when its last point is complete; fours a block later, because more than two scales take too long.
        let is_pair = blocks.half.is_none();
        let is_new = [true, is_pair, !is_pair && pairs.half.is_none()];
        let single = if moves_on { &BLOCKS_OF_THREE } else { &BLOCKS };
        let rules: [_; SCALES] = [single, &PAIRS, &FOURS];
        for (index, (scale, rule)) in self.scales.iter().zip(rules).enumerate() {
            if !is_new.get(index).copied().unwrap_or(false) {
                waits |= best.is_some_and(|best| best.scale == index);
            } else if best.is_none_or(|best| best.scale >= index)
                && let Some((change, sigmas)) = scale.stretch.corner(rule, least_nm, &noise)
                && best.is_none_or(|best| best.scale > index || sigmas > best.sigmas)
            {
                is_better = true;
                best = Some(Found {
                    change,
                    sigmas,
                    scale: index,
                });
            }
            noise = noise.of_means(2.0);
        }
        // Shift all by one. `rotate_right` would do the same, but links 1.5 KB of `memmove`.
        let mut moved = best;
        for kept in &mut self.best {
            core::mem::swap(kept, &mut moved);
        }
        if is_better || waits {
            None
        } else {
            self.finish()
        }
    }

    /// The motion was interrupted: what the last blocks alone show does not count.
    pub fn interrupt(&mut self) {
        let [.., before] = self.best;
        self.best = [before; 1 + DOUBTFUL];
    }

    /// The motion is over, and no more blocks come: the second contact that they show, if it was not told.
    pub fn finish(&mut self) -> Option<SlopeChange> {
        let [best, ..] = self.best;
        let found = best.filter(|_| !self.is_told)?;
        self.is_told = true;
        Some(found.change)
    }

    /// The slope some blocks after a change that was told; `None` where too few have come since.
    pub fn later(&self, change: &SlopeChange, noise: &BlockNoise) -> Option<Later> {
        later::fit(&self.scales[0].stretch, change, noise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CABLE: f64 = 1.2;
    const QUIET: BlockNoise = BlockNoise {
        white_nm2: 1e-8,
        walk_nm2: 0.0,
        worm_turn_rad: 0.3,
        worm_error_rad: 0.0,
    };

    /// Pushes a curve, and returns what was told, where, and the search afterwards.
    fn told(torque: impl Fn(f64) -> f64, to_rad: f64) -> (Option<SlopeChange>, SecondContact) {
        told_with(&QUIET, torque, to_rad)
    }

    fn told_with(
        noise: &BlockNoise,
        torque: impl Fn(f64) -> f64,
        to_rad: f64,
    ) -> (Option<SlopeChange>, SecondContact) {
        let (mut search, mut found, mut theta) = (SecondContact::default(), None, 0.0);
        search.begin(0.0, 0.0, 0.01);
        while theta < to_rad {
            let change = search.push(theta as f32, torque(theta) as f32, noise, false);
            found = found.or(change);
            theta += 0.005;
        }
        (found, search)
    }

    /// A corner of a quarter is found in pairs of blocks, and a curve that only bends has none: that of one contact on a finger
    /// behind a cable, whose slope doubles on the way.
    #[test]
    fn small_corners_are_told_from_bends() {
        let bend = |theta: f64| 0.4 * theta + 0.35 * theta * theta;
        assert_eq!(told(bend, 0.9).0, None);
        let corner = |theta: f64| bend(theta) + 0.2 * (theta - 0.5).max(0.0);
        let change = told(corner, 0.9).0.expect("a corner");
        assert!((change.theta_a_rad - 0.5).abs() < 0.016, "{change:?}");
        assert!((change.after_nm_per_rad - 0.95).abs() < 0.1, "{change:?}");
    }

    /// The efficiency's wave over a turn of the worm bends the curve like a corner. A search that does not know the worm tells a
    /// corner, one that knows it tells none, and still tells a larger one.
    #[test]
    fn what_the_worm_does_is_no_corner() {
        let wave = |theta: f64| 1.0 + 0.02 * (std::f64::consts::TAU * theta / 0.3).sin();
        let curve = |theta: f64| 0.3 * theta * wave(theta);
        let unaware = BlockNoise {
            worm_turn_rad: 1e6,
            ..QUIET
        };
        takes_for_no_corner(curve, &unaware, &QUIET);
    }

    /// A curve that is taken for a corner by who does not know its noise and not by who does; a larger corner is still told.
    fn takes_for_no_corner(
        curve: impl Fn(f64) -> f64 + Copy,
        unaware: &BlockNoise,
        aware: &BlockNoise,
    ) {
        assert!(told_with(unaware, curve, 0.9).0.is_some());
        assert_eq!(told_with(aware, curve, 0.9).0, None);
        let corner = |theta: f64| curve(theta) + 0.6 * (theta - 0.5).max(0.0);
        let change = told_with(aware, corner, 0.9).0.expect("a corner");
        assert!((change.theta_a_rad - 0.5).abs() < 0.016, "{change:?}");
    }

    /// So does an error of the worm's angle: where it is stated, it makes no corner, and a larger one is still told.
    #[test]
    fn what_the_worm_is_off_by_is_no_corner() {
        let stated = BlockNoise {
            worm_error_rad: 8e-3,
            ..QUIET
        };
        let off_rad = |theta: f64| 16e-3 * (std::f64::consts::TAU * theta / 0.3).sin();
        let curve = |theta: f64| 0.3 * (theta + off_rad(theta));
        takes_for_no_corner(curve, &QUIET, &stated);
    }

    /// Friction that wanders hides a corner over the way that pairs see, and not over the way that fours see.
    #[test]
    fn a_corner_in_friction_that_wanders_is_told_farther_on() {
        let noise = BlockNoise {
            walk_nm2: 2e-7,
            ..QUIET
        };
        let curve = |theta: f64| 0.2 * theta + 0.3 * (theta - 0.7).max(0.0);
        let (change, search) = told_with(&noise, curve, 1.2);
        let change = change.expect("a corner");
        assert!((change.theta_a_rad - 0.7).abs() < 0.021, "{change:?}");
        let [Some(found), ..] = search.best else {
            panic!("nothing found");
        };
        assert_eq!(found.scale, 2);
    }

    /// Friction that wanders makes corners too: in 200 closings with steps of 0.5 mN m a block, hardly any where the steps are known.
    #[test]
    fn what_wanders_is_no_corner() {
        let mut state = 1u32;
        let mut counts = [0, 0];
        for _ in 0..200 {
            let mut walk = [0.0; 200];
            for block in 1..walk.len() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let step = if state >> 31 == 0 { 5e-4 } else { -5e-4 };
                walk[block] = walk[block - 1] + step;
            }
            let curve = |theta: f64| 0.3 * theta + walk[(theta / 0.005).round() as usize];
            for (count, walk_nm2) in counts.iter_mut().zip([0.0, 2.5e-7]) {
                let noise = BlockNoise { walk_nm2, ..QUIET };
                *count += u32::from(told_with(&noise, curve, 0.9).0.is_some());
            }
        }
        let [unaware, aware] = counts;
        println!("corners without knowing of it {unaware}, knowing {aware}");
        assert!(unaware > 20 && aware < 3, "{unaware} {aware}");
    }

    /// A finger that sticks after the corner shows the cable first; the slope some blocks later is its own.
    #[test]
    fn the_later_slope_is_that_of_a_finger_that_moves_again() {
        // 0.2 N m/rad, then the cable alone for five blocks, then 0.6.
        let curve = |theta: f64| {
            0.2 * theta + (CABLE - 0.2) * (theta - 0.3).max(0.0)
                - (CABLE - 0.6) * (theta - 0.325).max(0.0)
        };
        let (change, search) = told(curve, 0.401);
        let change = change.expect("a corner");
        let later = search.later(&change, &QUIET).expect("enough blocks");
        assert!((later.slope_nm_per_rad - 0.6).abs() < 0.01, "{later:?}");
        let there = curve(f64::from(later.theta_a_rad)) as f32;
        assert!((later.torque_nm - there).abs() < 1e-3, "{later:?} {there}");
        assert!(change.after_nm_per_rad > 0.75, "{change:?}");
        assert_eq!(
            search.later(
                &SlopeChange {
                    theta_a_rad: 0.39,
                    ..change
                },
                &QUIET
            ),
            None
        );
    }

    /// What only the last two blocks before a break show is the drive's doing; without a break it counts.
    #[test]
    fn a_step_before_a_break_is_no_corner() {
        let curve = |theta: f64| 0.2 * theta + (theta - 0.39).max(0.0);
        let (change, mut search) = told(curve, 0.402);
        assert_eq!(change, None);
        assert!(search.clone().finish().is_some());
        search.interrupt();
        assert_eq!(search.finish(), None);
    }

    /// A closing has one second contact, however the curve goes on.
    #[test]
    fn a_second_contact_is_told_once() {
        let curve = |theta: f64| 0.2 * theta + (theta - 0.3).max(0.0);
        let (change, mut search) = told(curve, 0.6);
        assert!(change.is_some());
        for block in 0..40 {
            let theta = 0.6 + 0.005 * f64::from(block);
            let torque = curve(theta) + 2.0 * (theta - 0.7).max(0.0);
            assert_eq!(
                search.push(theta as f32, torque as f32, &QUIET, false),
                None
            );
        }
        assert_eq!(search.finish(), None);
    }
}
