//! The slope some blocks after a second contact: at once the finger may stick (docs/SECOND_CONTACTS.md#sticking).

use super::corner::Stretch;
use super::{BlockNoise, SlopeChange};
use crate::numeric::{Bounded, sin_cos, sqrt};
use crate::sensing::locator::{WAVE_SHARE, waves_nm};
use core::f32::consts::TAU;

/// Blocks after the corner that are left out, and the share of all where they are few: the finger may stick in them.
const SKIPPED: usize = 8;
const SKIPPED_OF: usize = 3;
/// Blocks that are left at least.
const LEAST: usize = 5;
/// The slope of a line through `n` evenly spaced values of a random walk has `6/5 n/L^2` of its variance a step, with `L` the length: times
/// the sum of squares about the middle, `n L^2/12`, that is a tenth of `n^2` (within 4 % from 5 values on).
const WALK_SHARE: f32 = 0.1;

/// The curve some way after a change of slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Later {
    /// Angle of the input link there, the cable's twist included, radian.
    pub theta_a_rad: f32,
    /// Torque above friction there, newton metre.
    pub torque_nm: f32,
    /// Slope of torque over angle there, cable included, newton metre per radian.
    pub slope_nm_per_rad: f32,
    /// Standard deviation of the slope, with what friction wanders and what efficiency waves meanwhile.
    pub sigma_nm_per_rad: f32,
}

/// The line through the blocks after a change, but for the first.
pub(super) fn fit(stretch: &Stretch, change: &SlopeChange, noise: &BlockNoise) -> Option<Later> {
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
    let (mut squares, mut products, mut waves) = (0.0, 0.0, 0.0);
    for [theta, above] in points {
        let from = theta - at;
        squares += from * from;
        products += from * (above - torque);
        // A wave's even part has no slope about the middle.
        let (sin, _) = sin_cos(TAU / noise.worm_turn_rad * from);
        waves += from * sin;
    }
    let slope = products / squares;
    let mut scatter = 0.0;
    for [theta, above] in points {
        let off = above - torque - slope * (theta - at);
        scatter += off * off;
    }
    let walk = WALK_SHARE * number * number * noise.walk_nm2;
    let white = (scatter / (number - 2.0)).at_least(noise.white_nm2);
    let wave = WAVE_SHARE * waves_nm(torque, noise.worm_error_rad, slope) * waves;
    let variance = white + walk + 0.5 * wave * wave / squares;
    let later = Later {
        theta_a_rad: at,
        torque_nm: torque,
        slope_nm_per_rad: slope,
        sigma_nm_per_rad: sqrt(variance / squares),
    };
    (slope > 0.0 && later.sigma_nm_per_rad.is_finite()).then_some(later)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rms error of the slope over its deviation, of 400 lines of 0.2 N m/rad with what a block adds to the torque.
    fn off(noise: &BlockNoise, mut error_nm: impl FnMut(u32, f32) -> f32) -> f32 {
        let mut squares = 0.0;
        for line in 0..400 {
            let mut stretch = Stretch::default();
            stretch.begin(0.0, 0.0);
            for block in 0..24 {
                let theta_a_rad = 0.005 * (1 + block) as f32;
                stretch.note([theta_a_rad, 0.2 * theta_a_rad + error_nm(line, theta_a_rad)]);
            }
            let corner = SlopeChange {
                theta_a_rad: 0.0,
                torque_nm: 0.0,
                before_nm_per_rad: 0.1,
                after_nm_per_rad: 0.2,
                after_sigma_nm_per_rad: 0.1,
                spacing_rad: 0.005,
            };
            let later = fit(&stretch, &corner, noise).expect("a slope");
            let z = (later.slope_nm_per_rad - 0.2) / later.sigma_nm_per_rad;
            squares += z * z / 400.0;
        }
        sqrt(squares)
    }

    /// White noise, friction that wanders, and the efficiency's wave with any phase each make the slope as wrong as it says.
    #[test]
    fn the_slope_s_deviation_is_that_of_its_errors() {
        let mut state = 1u32;
        let mut sign = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 31 == 0 { 1.0 } else { -1.0 }
        };
        let quiet = BlockNoise {
            white_nm2: 1e-12,
            walk_nm2: 0.0,
            // No wave.
            worm_turn_rad: 1e6,
            worm_error_rad: 0.0,
        };
        let white = off(
            &BlockNoise {
                white_nm2: 1e-8,
                ..quiet
            },
            |_, _| 1e-4 * sign(),
        );
        let (mut walk, mut before) = (0.0, u32::MAX);
        let wandering = off(
            &BlockNoise {
                walk_nm2: 1e-8,
                ..quiet
            },
            |line, _| {
                walk = if line == before {
                    walk + 1e-4 * sign()
                } else {
                    0.0
                };
                before = line;
                walk
            },
        );
        let waving = off(
            &BlockNoise {
                worm_turn_rad: 0.3,
                ..quiet
            },
            |line, theta| {
                let (sin, _) = sin_cos(TAU * (theta / 0.3 + 0.01 * (line % 100) as f32));
                WAVE_SHARE * 0.2 * theta * sin
            },
        );
        // One of the angle has as large an amplitude wherever it is, with a phase of its own.
        let erring = off(
            &BlockNoise {
                worm_turn_rad: 0.3,
                worm_error_rad: 2e-3,
                ..quiet
            },
            |line, theta| {
                let (sin, _) = sin_cos(TAU * (theta / 0.3 + 0.01 * (line % 100) as f32));
                2e-3 * 0.2 * sin
            },
        );
        println!(
            "white {white:.2}, wandering {wandering:.2}, waving {waving:.2}, erring {erring:.2} deviations"
        );
        assert!((0.85..1.1).contains(&white), "{white}");
        assert!((0.85..1.1).contains(&wandering), "{wandering}");
        assert!((0.9..1.2).contains(&waving), "{waving}");
        assert!((0.8..1.2).contains(&erring), "{erring}");
    }
}
