//! Figures as SVG.

mod calibration;
pub mod canvas;
mod mechanics;
mod simulated;

pub use calibration::calibration;
pub use mechanics::mechanics;
pub use simulated::simulated;
