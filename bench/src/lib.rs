//! Every candidate method for the places of the firmware where speed and error compete, as plain functions that run on a
//! PC and on the chip alike, and the inputs for comparing them.
//!
//! Errors are measured on the PC over all reference rows, costs on the core over a part of the same rows; the two meet in
//! `cargo xtask report`. rustc never fuses a multiplication with an addition and square roots are exact, so the results
//! are the same bits on both; the chip sends a checksum of its results that shows it.
#![no_std]
#![forbid(unsafe_code)]

pub mod arithmetic;
pub mod candidate;
pub mod function;
pub mod published;
pub mod rows;
mod solver;
pub mod step;
pub mod task;
pub mod three;
pub mod two;
