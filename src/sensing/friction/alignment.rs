//! Aligns a friction record that was taken with another zero of the encoder.
//!
//! A restart finds a new zero at the opening stop, some milliradians from the old one, and friction is periodic with the turn of
//! the worm: without a shift by the difference of the zeros the record leaves a residual that looks like a contact or like a soft
//! finger. The first free motion of a closing determines the shift. Several shifts are compared: for each, a Kalman filter with
//! the states wander and level whitens the residual (the level is a state because an offset is no shift), and the squares
//! together with the spread of homings give its posterior. Where friction is even the squares do not depend on the shift, and the
//! spread keeps it small. Its deviation enters the noise model of the closing that follows.
//!
//! If no shift explains the motion, it is not free or the record is unusable; this shows after some blocks, long before the
//! motor presses hard.

use super::Friction;
use super::wander::Wander;
use crate::numeric::{Bounded, exp, sqrt};
use crate::sensing::Drivetrain;
use crate::sensing::block::Block;

/// Largest shift compared, radian: two homings on the same stop differ by less than 25 mrad.
const REACH_RAD: f32 = 0.03;
/// Number of shifts compared.
const SHIFTS: usize = 25;
/// Standard deviation of the difference of two homings, radian (R, chosen: a third of what they differ by at most).
const SPREAD_RAD: f32 = 0.008;
/// Free motion that is compared, radian: most of a turn of the worm (0.3 rad).
const WAY_RAD: f32 = 0.2;
/// Sum of squares in variances a block, plus as many blocks more, above which the motion is not free or does not fit the record.
/// A free motion has one variance a block.
const UNLIKE: f32 = 4.0;
const MORE_BLOCKS: f32 = 6.0;

/// Result of the blocks so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aligned {
    /// Too few blocks.
    Pending,
    /// Add `counts` to a position to get the record's.
    By {
        /// Mean of the posterior, counts.
        counts: i32,
        /// Its standard deviation, counts.
        sigma_counts: f32,
    },
    /// The record fits at no shift.
    Nowhere {
        /// Standard deviation of the residual at the best shift, newton metre.
        misfit_nm: f32,
    },
}

/// Filter of the residual at one shift.
#[derive(Clone, Copy, Debug)]
struct Left {
    /// Wander and level, newton metre.
    states: [f32; 2],
    /// Sum of squared innovations, each over its variance.
    squares: f32,
}

/// A comparison under way.
#[derive(Clone, Debug)]
pub struct Alignment {
    blocks: u16,
    last_us: u64,
    /// Noise model, and the covariance of wander and level, the same for every shift: variance, covariance, variance.
    wander: Option<Wander>,
    covariance: [f32; 3],
    left: [Left; SHIFTS],
}

impl Default for Alignment {
    fn default() -> Self {
        Self {
            blocks: 0,
            last_us: 0,
            wander: None,
            covariance: [0.0; 3],
            left: const {
                [Left {
                    states: [0.0; 2],
                    squares: 0.0,
                }; SHIFTS]
            },
        }
    }
}

/// The shift of an index, radian.
fn shift_rad(index: f32) -> f32 {
    REACH_RAD * (index / (SHIFTS / 2) as f32 - 1.0)
}

/// The same, counts.
fn shift_counts(index: f32, drivetrain: &Drivetrain) -> i32 {
    (shift_rad(index) / drivetrain.rad_per_count) as i32
}

impl Alignment {
    /// Takes a block of a closing. A block that lies outside the record at any shift is ignored.
    #[inline(never)]
    pub fn push(&mut self, friction: &Friction, block: &Block, drivetrain: &Drivetrain) -> Aligned {
        let at = |index: usize| {
            let shift = shift_counts(index as f32, drivetrain);
            let known = friction.at(block.counts.wrapping_add(shift));
            known.map(|known| known.torque_nm)
        };
        // A record has no gap, so the first and last shift suffice.
        let known = at(0).is_some() && at(SHIFTS - 1).is_some();
        if !(known && block.drive_torque_nm.is_finite()) {
            return Aligned::Pending;
        }
        let width_counts = block.width_counts.max(1) as f32;
        let speed_rad_per_s = width_counts * drivetrain.rad_per_count / block.duration_s;
        let wander = *self.wander.get_or_insert_with(|| {
            let wander = friction.wander(speed_rad_per_s);
            let square = |x: f32| x * x;
            self.covariance = [square(wander.rms_nm), 0.0, square(wander.level_sigma_nm)];
            self.last_us = block.time_us;
            wander
        });
        let elapsed_us = block.time_us.saturating_sub(self.last_us).min(1_000_000);
        self.last_us = block.time_us;
        let phi = wander.correlation(elapsed_us as u32 as f32 * 1e-6);
        let stationary = wander.rms_nm * wander.rms_nm;
        let [a, b, d] = self.covariance;
        let (a, b) = (stationary + phi * phi * (a - stationary), phi * b);
        // Includes the record's own noise, which is that of the motion it was taken from.
        let noise_nm2 = 2.0 * friction.white_nm2(block.duration_s);
        let variance = a + 2.0 * b + d + noise_nm2;
        let gains = [(a + b) / variance, (b + d) / variance];
        self.covariance = [
            a - gains[0] * (a + b),
            b - gains[0] * (b + d),
            d - gains[1] * (b + d),
        ];
        self.blocks = self.blocks.saturating_add(1);
        for (index, left) in self.left.iter_mut().enumerate() {
            let Some(torque_nm) = at(index) else {
                continue;
            };
            let [wandered, level] = &mut left.states;
            *wandered *= phi;
            let innovation = block.drive_torque_nm - torque_nm - *wandered - *level;
            *wandered += gains[0] * innovation;
            *level += gains[1] * innovation;
            left.squares += innovation * innovation / variance;
        }
        let blocks = f32::from(self.blocks);
        let over = blocks * width_counts * drivetrain.rad_per_count >= WAY_RAD;
        self.judge(variance, blocks, over, drivetrain)
    }

    fn judge(&self, variance: f32, blocks: f32, over: bool, drivetrain: &Drivetrain) -> Aligned {
        // Minus twice the logarithm of the posterior, up to a constant.
        let cost = |index: usize| {
            let spreads = shift_rad(index as f32) / SPREAD_RAD;
            let left = self.left.get(index)?;
            Some(left.squares + spreads * spreads)
        };
        let least = (0..SHIFTS)
            .filter_map(cost)
            .fold(f32::INFINITY, |least, cost| least.at_most(cost));
        // In this form a NaN counts as well.
        let explained = least <= UNLIKE * (blocks + MORE_BLOCKS);
        if !explained {
            return Aligned::Nowhere {
                misfit_nm: sqrt(least * variance / blocks).at_most(f32::MAX),
            };
        }
        if !over {
            return Aligned::Pending;
        }
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (index, cost) in (0..SHIFTS).filter_map(|index| Some((index as f32, cost(index)?))) {
            let weight = exp(0.5 * (least - cost));
            sum += weight;
            mean += weight * index;
            square += weight * index * index;
        }
        // The likeliest has a weight of 1.
        mean /= sum;
        // Variance within a step of the grid: uniform between two shifts.
        let variance = (square / sum - mean * mean).at_least(0.0) + 1.0 / 12.0;
        let step_counts = REACH_RAD / (SHIFTS / 2) as f32 / drivetrain.rad_per_count;
        Aligned::By {
            counts: shift_counts(mean, drivetrain),
            sigma_counts: sqrt(variance) * step_counts,
        }
    }
}
