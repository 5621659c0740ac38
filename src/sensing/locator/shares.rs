//! How much of the curve one contact explains: second contacts, flat faces and soft objects change its later part
//! (docs/BOUNDS.md#estimation-from-recordings).
//!
//! A finger of three phalanges goes on turning after its first contact, and in many grasps a second phalanx meets the object
//! before the probing ends. The fit gives way to that: place, radius and friction bend until the whole curve is explained,
//! badly, and the place is off by several of its deviations. So a longer part of the curve must explain the points that it has
//! more than a shorter one: what they add to the cost (squared residuals and what the priors gave way) is compared with what
//! their noise allows.

use super::posterior::allowed;
use super::{Data, LEAST_POINTS, Locator};
use crate::finger::Mechanics;
use crate::numeric::Bounded;
use crate::sensing::SeriesElement;

/// Shares of the rise to which the curve is shortened.
const SHARES: [f32; 5] = [1.0, 0.6, 0.35, 0.2, 0.12];

/// A part of the curve that one contact explains, and that a shorter part may explain better.
#[derive(Clone, Copy, Debug)]
pub(super) struct Longer {
    share: usize,
    points: usize,
    cost: f32,
}

/// Number of points up to a share of the rise, and whether they are enough for a fit.
pub(super) fn points(data: &Data, share: usize) -> (usize, bool) {
    let top_nm = (data.points.iter()).fold(0.0f32, |top, point| point.excess_nm.at_least(top));
    let limit_nm = SHARES.get(share).copied().unwrap_or(1.0) * top_nm;
    let (mut number, mut since) = (0, 0);
    for point in data.points {
        since += usize::from(point.time_s >= 0.0);
        if point.excess_nm > limit_nm && since > LEAST_POINTS {
            break;
        }
        number += 1;
    }
    (number, since >= LEAST_POINTS && top_nm > 0.0)
}

impl<F: Mechanics, X: SeriesElement> Locator<F, X> {
    /// Whether the verdict of a final round stands; if not, another round follows on a share of the curve that has been chosen. Where it
    /// is late no shorter part is tried, but the longest that is explained is gone back to.
    pub fn stands(&mut self, data: &Data, is_late: bool) -> bool {
        let explained = self.explains() && !self.leans_on_its_end();
        if !F::MOVES_ON {
            return explained || !self.shorten();
        }
        if self.compared {
            return true;
        }
        let own = Longer {
            share: self.share,
            points: self.number,
            cost: self.chi_square(),
        };
        // Stay with the longer part, unless this one is explained and the longer one's further points are not.
        let found = match self.longer {
            Some(longer) if !explained || longer.explains_beyond(&own) => longer,
            _ if explained => own,
            _ => return is_late || !self.shorten(),
        };
        self.longer = Some(found);
        let (fewer, _) = points(data, self.share + 1);
        // Stop where even a perfect fit of the next shorter part would show nothing.
        let hopeless = found.cost <= allowed(found.points.saturating_sub(fewer) as f32);
        if !hopeless && !is_late && self.shorten() {
            return false;
        }
        self.compared = true;
        let stands = found.share == self.share;
        self.share = found.share;
        stands
    }

    /// Begins with the whole curve again, because it is another.
    pub fn forget_shares(&mut self) {
        self.share = 0;
        self.longer = None;
        self.compared = false;
    }

    /// The same for a contact at a known place, which learns from the part before a second phalanx touched. With two phalanges the whole
    /// curve counts: a pin that both touch is a misfit.
    pub fn teaches(&mut self, data: &Data) -> bool {
        !F::MOVES_ON || self.stands(data, false)
    }

    /// Whether the end of the curve may be that of two contacts, between which the force is then divided. Never with two
    /// phalanges.
    pub fn may_be_shared(&self) -> bool {
        F::MOVES_ON && self.share > 0
    }

    /// Shortens the curve at its end; false if it cannot be shortened further.
    fn shorten(&mut self) -> bool {
        let shorter = self.share + 1 < SHARES.len();
        self.share += usize::from(shorter);
        shorter
    }
}

impl Longer {
    /// Whether the points that it has more than a shorter part are explained.
    fn explains_beyond(&self, shorter: &Self) -> bool {
        let more = self.points.saturating_sub(shorter.points) as f32;
        self.cost - shorter.cost <= allowed(more)
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::*;
    use crate::scene::{P70, Scene};
    use crate::sensing::curve::Point;

    fn straight(count: usize) -> Vec<Point> {
        let point = |i: usize| Point {
            excess_nm: 0.01 * i as f32,
            time_s: 0.01 * i as f32,
            blocks: 1,
            ..Point::EMPTY
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn a_shorter_share_has_fewer_points_but_enough() {
        let drivetrain = P70::drivetrain(&P70::MECHANISM);
        let curve = straight(42);
        let data = Data {
            points: &curve,
            origin_rad: 0.0,
            drivetrain: &drivetrain,
        };
        let found: Vec<_> = (0..SHARES.len()).map(|i| points(&data, i)).collect();
        assert_eq!(
            found,
            [(42, true), (25, true), (15, true), (9, true), (5, true)]
        );
        let few = straight(4);
        let data = Data {
            points: &few,
            ..data
        };
        assert!(!points(&data, 0).1);
    }

    /// A curve that is cut is judged as a whole again, and its shares are compared with its own.
    #[test]
    fn what_was_chosen_of_another_curve_is_forgotten() {
        let mut locator = Locator::<<P70 as Scene>::Finger, crate::sensing::Cable> {
            share: 2,
            compared: true,
            longer: Some(Longer {
                share: 1,
                points: 40,
                cost: 900.0,
            }),
            ..Locator::default()
        };
        locator.forget_shares();
        assert!(locator.share == 0 && !locator.compared && locator.longer.is_none());
    }

    #[test]
    fn what_a_longer_part_adds_may_cost_what_its_noise_allows() {
        let part = |points, cost| Longer {
            share: 0,
            points,
            cost,
        };
        let shorter = part(30, 20.0);
        // 8 points: 8 + 3 sqrt(16) = 20.
        assert!(part(38, 39.9).explains_beyond(&shorter));
        assert!(!part(38, 40.1).explains_beyond(&shorter));
        // The priors gave way, without another point.
        assert!(!part(30, 21.0).explains_beyond(&shorter));
    }
}
