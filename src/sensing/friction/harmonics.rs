//! Friction periodic with the turn of the worm.

use crate::numeric::sin_cos;
use core::f32::consts::TAU;

/// Harmonics of the worm's turn.
pub const HARMONICS: usize = 4;

/// Cosines and sines of a worm's angle and its multiples, in pairs.
pub(super) fn waves(counts: f32, worm_counts: u32) -> [f32; 2 * HARMONICS] {
    if worm_counts == 0 {
        return [0.0; 2 * HARMONICS];
    }
    let turns = counts / worm_counts as f32;
    let (sin, cos) = sin_cos(TAU * (turns - turns as i32 as f32));
    let mut waves = [0.0; 2 * HARMONICS];
    let (mut real, mut imaginary) = (cos, sin);
    for pair in waves.as_chunks_mut().0 {
        *pair = [real, imaginary];
        (real, imaginary) = (real * cos - imaginary * sin, real * sin + imaginary * cos);
    }
    waves
}

/// The sum of waves with some amplitudes.
pub(super) fn sum(amplitudes: &[f32; 2 * HARMONICS], waves: &[f32; 2 * HARMONICS]) -> f32 {
    amplitudes.iter().zip(waves).map(|(a, w)| a * w).sum()
}
