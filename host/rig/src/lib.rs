//! The fast simulation: the library's controller and slow loop against the plant, without the chip between them.

mod board;

pub use board::{Board, PERIOD_S};
