//! Threshold, two torques, and the secant of the stiffness between them.

use palpate::sample::Sample;

use super::place::invert;
use super::turns::{MotorTurn, steady};
use super::{Model, PaperResult, break_away};

/// Margin of the threshold over the largest torque of the free closing.
const MARGIN: f64 = 1.1;
/// Steps of torque that are tried, newton metre; the paper does not tell its own.
pub const STEPS_NM: [f64; 7] = [0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2];
/// Turns in each mean of the two-level rule.
pub(super) const LEVEL_TURNS: usize = 3;

/// Between which two torques the secant is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// From the first turn above the threshold to the first one this much higher, newton metre.
    Rise(f64),
    /// From the first turns above the threshold to the last ones of the closing, means of several at either level.
    TwoLevels,
}

/// A torque that a free closing does not exceed: threshold of contact and friction at once, as in the paper's Fig 12.
///
/// `None` where the samples hold no closing motion.
#[must_use]
pub fn friction_threshold(model: &Model, free_closing: &[Sample]) -> Option<f64> {
    steady(model, free_closing)
        .iter()
        .map(|turn| turn.excess_nm)
        .max_by(f64::total_cmp)
        .map(|largest| MARGIN * largest)
}

/// Mean torque and angle of some turns.
pub(super) fn level(turns: &[MotorTurn]) -> Option<(f64, f64)> {
    let count = turns.len() as f64;
    (count > 0.0).then(|| {
        let torque = turns.iter().map(|turn| turn.torque_nm).sum::<f64>() / count;
        let angle = turns.iter().map(|turn| turn.angle_rad).sum::<f64>() / count;
        (torque, angle)
    })
}

/// The algorithm on one closing, with the threshold of a free one.
#[must_use]
pub fn locate(model: &Model, threshold_nm: f64, samples: &[Sample], rule: Rule) -> PaperResult {
    let turns = steady(model, samples);
    let Some(touch) = turns.iter().position(|turn| turn.excess_nm > threshold_nm) else {
        return PaperResult::NoContact;
    };
    if let Some(stopped) = model.stopped {
        return break_away::locate(model, stopped, &turns, touch, rule);
    }
    let pressed = &turns[touch..];
    let time_us = pressed[0].time_us;
    let levels = match rule {
        Rule::Rise(step_nm) => {
            let wanted = pressed[0].torque_nm + step_nm;
            let above = pressed.iter().position(|turn| turn.torque_nm >= wanted);
            above.and_then(|above| Some((level(&pressed[..1])?, level(&pressed[above..=above])?)))
        }
        // The levels must not meet.
        Rule::TwoLevels if pressed.len() > 2 * LEVEL_TURNS => {
            level(&pressed[..LEVEL_TURNS]).zip(level(&pressed[pressed.len() - LEVEL_TURNS..]))
        }
        Rule::TwoLevels => None,
    };
    let Some(((low_nm, low_rad), (high_nm, high_rad))) = levels else {
        return PaperResult::Touched { time_us };
    };
    let measured = (high_rad - low_rad) / (high_nm - low_nm);
    let contact_nm = low_nm - threshold_nm;
    invert(
        model,
        contact_nm,
        measured - model.cable_rad_per_nm,
        time_us,
    )
}
