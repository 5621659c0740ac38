//! What `drive` hands to `sensing` once a millisecond: the one type both rooms share.

/// How the bridge drove the motor during the sample: it decides what the current tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Drive {
    /// Driven and turning in the closing direction: the current tells friction plus load.
    Closing,
    /// Driven and turning in the opening direction.
    Opening,
    /// Braked, coasting, standing or within a reversal: the current tells nothing about the load.
    Idle,
}

/// One sample of the drivetrain, averaged over the sample period (1 ms), motor side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Sample {
    /// End of the averaging period, microseconds since boot.
    pub time_us: u64,
    /// Encoder position at `time_us`, counts from the opening stop once homed, closing positive; wraps.
    pub position_counts: i32,
    /// Mean motor current, ampere, positive when its torque closes, offset removed.
    pub current_a: f32,
    /// What the bridge did.
    pub drive: Drive,
}
