//! Second contacts after one on phalanx 1, where the curve of that one is a straight line ([`HoldsTwice::STRAIGHT`]).
//!
//! Where a curve may bend by itself, a corner is hard to tell from friction that wanders; in a straight line it stands out. Which phalanx
//! was touched first is known only at the end of the closing, so what is found here waits for the last word on the first contact.
//!
//! [`HoldsTwice::STRAIGHT`]: crate::finger::HoldsTwice::STRAIGHT

use super::corner::Rule;
use super::{BlockNoise, FOURS, SecondContact, SlopeChange};

/// Fours where the curve of a single contact is a straight line (chosen: of 55 single contacts on phalanx 1 of `tendon3` none has more than
/// 2.9 deviations, of the second ones that the other rules miss most have more than 7).
const STRAIGHT: Rule = Rule {
    bends_from: usize::MAX,
    turns_from: usize::MAX,
    sigmas: 5.0,
    ..FOURS
};

/// The likeliest corner in a curve that is straight but for that.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Straight {
    best: Option<(SlopeChange, f32)>,
    /// Points farther on fit it no better.
    is_over: bool,
}

impl SecondContact {
    /// Looks for a corner in a curve that is straight but for that; to be called after every [`push`](Self::push), with the same noise.
    pub fn look_straight(&mut self, noise: &BlockNoise) {
        let [blocks, pairs, fours] = &self.scales;
        // In the update in which no other scale has a new point: every fourth.
        let is_idle = blocks.half.is_some() && pairs.half.is_some();
        let Some(least_nm) = self.least_nm.filter(|_| is_idle && !self.straight.is_over) else {
            return;
        };
        let found = (fours.stretch).corner(&STRAIGHT, least_nm, &noise.of_means(4.0));
        let most = self.straight.best.map_or(0.0, |(_, sigmas)| sigmas);
        match found {
            Some((_, sigmas)) if sigmas > most => self.straight.best = found,
            _ => self.straight.is_over = most > 0.0,
        }
    }

    /// The second contact that [`look_straight`](Self::look_straight) found, where nothing else was; once.
    pub fn take_straight(&mut self) -> Option<SlopeChange> {
        let best = self.straight.best.take();
        best.filter(|_| !self.is_told).map(|(change, _)| change)
    }

    /// The same, without taking it.
    pub fn straight(&self) -> Option<&SlopeChange> {
        self.straight.best.as_ref().map(|(change, _)| change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: BlockNoise = BlockNoise {
        white_nm2: 2e-6,
        walk_nm2: 2e-7,
        worm_turn_rad: 0.3,
        worm_error_rad: 0.0,
    };

    /// What both searches tell of a curve of so many blocks.
    fn told(torque: impl Fn(usize) -> f64, blocks: usize) -> [Option<SlopeChange>; 2] {
        let (mut search, mut found) = (SecondContact::default(), None);
        search.begin(0.0, 0.0, 0.01);
        for block in 0..blocks {
            let theta_a_rad = 0.005 * block as f32;
            let change = search.push(theta_a_rad, torque(block) as f32, &NOISE, true);
            search.look_straight(&NOISE);
            found = found.or(change);
        }
        found = found.or_else(|| search.finish());
        [found, search.take_straight()]
    }

    /// Torque that wanders by +-0.45 mN m a block, with +-1.4 mN m of white noise.
    fn noise(seed: u32) -> Vec<f64> {
        let mut state = seed;
        let mut sign = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 31 == 0 { 1.0 } else { -1.0 }
        };
        let mut walk = 0.0;
        (0..240)
            .map(|_| {
                walk += 4.5e-4 * sign();
                walk + 1.4e-3 * sign()
            })
            .collect()
    }

    /// A slope that triples 40 blocks before the end, in friction that wanders as far: in a curve that may bend it is seldom seen, in a
    /// straight one always, and where there is none none is told.
    #[test]
    fn a_corner_stands_out_of_a_straight_line() {
        let (mut of_any, mut of_straight, mut without) = (0, 0, 0);
        let mut worst_rad = 0.0f32;
        for seed in 1..=100 {
            let noise = noise(seed);
            let line = |block: usize| 5e-4 * block as f64 + noise[block];
            let corner = |block: usize| line(block) + 1e-3 * block.saturating_sub(200) as f64;
            let [any, straight] = told(corner, 240);
            of_any += u32::from(any.is_some());
            of_straight += u32::from(any.is_some() || straight.is_some());
            if let Some(change) = straight {
                worst_rad = worst_rad.max((change.theta_a_rad - 1.0).abs());
            }
            let [any, straight] = told(line, 240);
            without += u32::from(any.is_some() || straight.is_some());
        }
        println!(
            "told of 100: {of_any}, straight as well {of_straight}, without a corner {without}; off by {worst_rad:.3} rad"
        );
        assert!(of_any < 60 && of_straight > 90, "{of_any} {of_straight}");
        assert!(without < 2, "{without}");
        assert!(worst_rad < 0.1, "{worst_rad}");
    }

    /// What the other search tells is not told again, and what is taken is gone.
    #[test]
    fn a_corner_is_told_once() {
        let corner = |block: usize| 1e-3 * block as f64 + 1e-2 * block.saturating_sub(150) as f64;
        let [any, straight] = told(corner, 240);
        assert!(any.is_some() && straight.is_none(), "{any:?} {straight:?}");
        let mut search = SecondContact::default();
        search.straight.best = any.map(|change| (change, 6.0));
        assert_eq!(search.take_straight(), any);
        assert_eq!(search.take_straight(), None);
    }
}
