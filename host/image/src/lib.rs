//! Looks into a linked firmware image: the memory it takes, its symbols, what a function uses, and what the control interrupt
//! can reach, which is a proof on the linked code, not on the source.

mod image;
mod paths;
mod reach;
mod sleeps;
mod thumb;
mod uses;

pub use image::{CCM, Footprint, Image, Symbol};
pub use reach::{Reach, Violation};
pub use sleeps::Sleeps;
