//! Figures as SVG.

mod calibration;
mod mechanics;
mod simulated;

pub use calibration::calibration;
pub use mechanics::mechanics;
pub use simulated::simulated;
