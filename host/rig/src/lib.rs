//! The fast simulation: the library's controller and slow loop against the plant, without the chip between them.

mod board;
mod machine;

pub use board::{Board, PERIOD_S};
pub use machine::{Machine, SlowLoop};
