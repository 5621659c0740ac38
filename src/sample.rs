//! What `drive` hands to `sensing` once a millisecond: the one type both rooms share.

/// How the bridge drove the motor during the sample: it decides what the current measures.
///
/// Counted from one, so that the `None` of an `Option<Sample>` is zero: a static one then takes no flash for its image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Driven and turning in the closing direction: the current measures friction plus load.
    Closing = 1,
    /// Driven and turning in the opening direction.
    Opening,
    /// Braked, coasting, standing or within a reversal: the current says nothing about the load.
    Idle,
}

/// One sample of the drivetrain, averaged over the sample period (1 ms), motor side. `J` is what a sensor of joint 2 reads;
/// without one it has no size.
///
/// ```
/// use palpate::sample::{Drive, Sample};
///
/// let sample = Sample {
///     time_us: 1_000,
///     position_counts: 12,
///     current_a: 0.015,
///     emf_v: 3.4,
///     drive: Drive::Closing,
///     joint: (),
/// };
/// // The same with what a sensor of joint 2 reads, radian.
/// assert_eq!(sample.with_joint(0.4).joint, 0.4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<J = ()> {
    /// End of the averaging period, microseconds since boot.
    pub time_us: u64,
    /// Encoder position at `time_us`, counts from the opening stop once homed, closing positive; wraps.
    pub position_counts: i32,
    /// Mean motor current, ampere, positive when its torque closes, offset removed.
    pub current_a: f32,
    /// Back-EMF of the motor, volt, positive when it closes: the voltage at its terminals less what the current takes of it in the winding.
    /// NaN where it is not known.
    pub emf_v: f32,
    /// What the bridge did.
    pub drive: Drive,
    /// Reading of the optional sensor at joint 2.
    pub joint: J,
}

impl<J> Sample<J> {
    /// The same sample with another reading of joint 2.
    pub fn with_joint<K>(self, joint: K) -> Sample<K> {
        Sample {
            time_us: self.time_us,
            position_counts: self.position_counts,
            current_a: self.current_a,
            emf_v: self.emf_v,
            drive: self.drive,
            joint,
        }
    }
}
