//! Reference rows, made from the 50-digit files when the crate is built.
//!
//! Random rows come from the files of the forward problem: a finger, a place, its compliance; the reduced data are rounded
//! to f32 and the places computed again from them in f64. Hard rows are f32-exact in their files, and so are their places.

// The numbers are printed with all their digits.
#![allow(
    clippy::excessive_precision,
    clippy::unreadable_literal,
    clippy::approx_constant
)]

use crate::function::{Angle, Equations};
use crate::step::{Rise, ThreeRow, TwoRow};
use crate::three::ThreePhalanges;
use crate::two::TwoPhalanges;

/// A row with its answer.
#[cfg(not(target_os = "none"))]
#[derive(Clone, Copy, Debug)]
pub struct Reference<I> {
    /// What candidates are given.
    pub input: I,
    /// Every physical place on the phalanx; NaN for those that are not there.
    pub roots: [f64; 2],
    /// From a file of hard cases.
    pub hard: bool,
}

include!(concat!(env!("OUT_DIR"), "/rows.rs"));
