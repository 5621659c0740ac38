//! Figures as SVG and PNG.

pub mod canvas;
mod mechanics;

pub use mechanics::mechanics;
