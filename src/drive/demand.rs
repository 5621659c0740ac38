//! What the sequence demands of the control interrupt, and the status that it reports back.

use super::fault::Fault;

/// What the motor is to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Setpoint {
    /// Bridge off: coast. The worm locks by itself.
    #[default]
    Off,
    /// Both low sides on.
    Brake,
    /// Brake, and average the current sense for its offset once the motor stands still.
    MeasureOffset,
    /// Hold a motor current.
    Current {
        /// Ampere, closing positive; clamped to the configured limit.
        a: f32,
    },
    /// Hold a speed.
    Speed {
        /// Encoder counts per second, closing positive; clamped to the configured limit.
        counts_per_s: f32,
        /// Largest current magnitude the speed loop may ask for, ampere.
        current_limit_a: f32,
    },
}

/// Everything the control interrupt is asked for, as levels: a reader that misses an intermediate value loses
/// nothing, so one shared cell is enough and no queue can overflow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// What the motor is to do.
    pub setpoint: Setpoint,
    /// Changing this makes the position `zero_at_counts` the new zero; [`Status::zero`] echoes it.
    pub zero: u8,
    /// Position, in the counts of before the change, that becomes zero.
    pub zero_at_counts: i32,
    /// Changing this clears a latched fault; [`Status::clear`] echoes it.
    pub clear: u8,
}

impl Demand {
    /// Bridge off and no requests: in force before the first demand.
    pub const REST: Self = Self {
        setpoint: Setpoint::Off,
        zero: 0,
        zero_at_counts: 0,
        clear: 0,
    };
}

impl From<Setpoint> for Demand {
    fn from(setpoint: Setpoint) -> Self {
        Self {
            setpoint,
            ..Self::default()
        }
    }
}

/// Limits that are in force: the demand was clamped, the motor goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LimitsReached {
    /// Current at the demanded or configured limit.
    pub current: bool,
    /// Duty at its maximum: the supply does not suffice.
    pub duty: bool,
    /// Speed at the configured maximum.
    pub speed: bool,
    /// At an end of the travel, motion outward suppressed.
    pub position: bool,
}

/// Where the offset of the current sense comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OffsetState {
    /// Not measured since start: taken as zero.
    #[default]
    Unknown,
    /// Being averaged.
    Measuring,
    /// OffsetReading and within range.
    Known,
}

/// The state of the motor: faults, the offset and what answers a demand as of the last control period, the rest as of the last
/// sample (1 ms).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Status {
    /// End of the last sample, microseconds of control periods since start.
    pub time_us: u64,
    /// Encoder position, counts, closing positive; from the opening stop once homed; wraps.
    pub position_counts: i32,
    /// Speed, counts per second, closing positive.
    pub speed_counts_per_s: f32,
    /// Motor current averaged over the last sample period (1 ms), ampere, closing positive, offset removed.
    pub current_a: f32,
    /// Motor voltage applied in the last control period of the sample, volt, closing positive.
    pub applied_v: f32,
    /// Supply voltage, volt.
    pub supply_v: f32,
    /// Winding temperature by the thermal model, degree Celsius.
    pub winding_c: f32,
    /// Housing temperature by the thermal model, degree Celsius.
    pub housing_c: f32,
    /// Limits in force at any time since the last sample.
    pub limited: LimitsReached,
    /// First fault since the last clear: the bridge is off and stays off until cleared.
    pub fault: Option<Fault>,
    /// A fault whose cause is there now, latched or not: clearing would lead to it at once, or with the next motion.
    pub present: Option<Fault>,
    /// State of the current sense's offset.
    pub offset: OffsetState,
    /// The last offset measured, ampere.
    pub offset_a: f32,
    /// Position counts from the opening stop.
    pub homed: bool,
    /// Echo of [`Demand::zero`].
    pub zero: u8,
    /// Echo of [`Demand::clear`].
    pub clear: u8,
}
