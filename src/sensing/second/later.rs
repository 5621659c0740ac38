//! The slope some blocks after a second contact: at once the finger may stick (docs/MECHANICS.md#two-contacts).

use super::SlopeChange;
use super::corner::Stretch;
use crate::numeric::{Bounded, sqrt};

/// Blocks after the corner that are left out, and the share of all where they are few: the finger may stick in them.
const SKIPPED: usize = 8;
const SKIPPED_OF: usize = 3;
/// Blocks that are left at least.
const LEAST: usize = 5;

/// The curve some way after a change of slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Later {
    /// Angle of the input link there, the cable's twist included, radian.
    pub theta_a_rad: f32,
    /// Torque above friction there, newton metre.
    pub torque_nm: f32,
    /// Slope of torque over angle there, cable included, newton metre per radian.
    pub slope_nm_per_rad: f32,
    /// Standard deviation of the slope.
    pub sigma_nm_per_rad: f32,
}

/// The line through the blocks after a change, but for the first.
pub(super) fn fit(stretch: &Stretch, change: &SlopeChange, variance_nm2: f32) -> Option<Later> {
    let points = stretch.points();
    let before = (points.iter())
        .take_while(|[theta, _]| *theta <= change.theta_a_rad)
        .count();
    let after = points.get(before..)?;
    let skipped = SKIPPED.min(after.len() / SKIPPED_OF);
    let points = after.get(skipped..)?;
    if points.len() < LEAST {
        return None;
    }
    let number = points.len() as f32;
    let [at, torque] = points.iter().fold([0.0; 2], |[a, b], [theta, torque]| {
        [a + theta / number, b + torque / number]
    });
    let (mut squares, mut products) = (0.0, 0.0);
    for [theta, above] in points {
        squares += (theta - at) * (theta - at);
        products += (theta - at) * (above - torque);
    }
    let slope = products / squares;
    let mut scatter = 0.0;
    for [theta, above] in points {
        let off = above - torque - slope * (theta - at);
        scatter += off * off;
    }
    let variance = (scatter / (number - 2.0)).at_least(variance_nm2);
    let later = Later {
        theta_a_rad: at,
        torque_nm: torque,
        slope_nm_per_rad: slope,
        sigma_nm_per_rad: sqrt(variance / squares),
    };
    (slope > 0.0 && later.sigma_nm_per_rad.is_finite()).then_some(later)
}
