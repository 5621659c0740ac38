//! Figures as SVG and PNG.

pub mod canvas;
mod mechanics;
mod simulated;

pub use mechanics::mechanics;
pub use simulated::simulated;
