//! What a recording is, however it was made.

mod emf;
mod read;
mod resample;
mod stream;

pub use emf::{Supply, back_emf_from_duty};
pub use read::{Findings, ReadError, read};
pub use resample::{Gap, PERIOD_US, Resampled, resample};
pub use stream::{Streamed, stream};

/// One row of a recording, motor side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time, second; any origin.
    pub time_s: f64,
    /// Encoder position, counts, closing positive.
    pub encoder_counts: i64,
    /// Motor current, ampere, positive when its torque closes.
    pub current_a: f64,
    /// Duty of the bridge, closing positive, or its sign alone, where it was recorded.
    pub duty: Option<f64>,
    /// Back-EMF, volt, closing positive, where it was recorded.
    pub emf_v: Option<f64>,
}
