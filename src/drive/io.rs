//! Interface between chip and control logic, exchanged once a control period.

/// Control rate: the ADC interrupt, a fifth of the PWM rate.
pub const CONTROL_HZ: u32 = 20_000;
/// Centre-aligned PWM rate. The motor's electrical time constant is 10-30 us: slower PWM would be ripple and heat.
pub const PWM_HZ: u32 = 100_000;
/// Duty at full scale: the timer's auto-reload at 170 MHz centre-aligned, 170e6 / (2 * 100e3).
pub const DUTY_FULL: u16 = 850;
/// Dead time of the bridge at each edge, second (R: DRV8876, docs/HARDWARE.md#bench-findings).
pub const DEAD_TIME_S: f32 = 300e-9;
/// The same as a share of the PWM's period.
pub const DEAD_SHARE: f32 = DEAD_TIME_S * PWM_HZ as f32;
/// Full scale of an [`AdcCode`]: the sum of 16 conversions of 12 bits (of 8, doubled, for the supply).
pub const ADC_FULL: u16 = 16 * 4095;

/// Raw reading: sum of 16 12-bit conversions, 0 to [`ADC_FULL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct AdcCode(pub u16);

/// Raw 16-bit quadrature counter (x4 edges); wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderCount(pub u16);

/// Compare value of the bridge's PWM, 0 to [`DUTY_FULL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Duty(pub u16);

/// Direction pin of the bridge (PH).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// Motor torque closes the finger (PH high).
    #[default]
    Closing,
    /// Motor torque opens the finger (PH low).
    Opening,
}

/// What the chip measured in the control period that just ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Motor current sense over a PWM period (docs/HARDWARE.md#bridge).
    pub current: AdcCode,
    /// What the second half of that period has more than the first, in codes of [`current`](Self::current).
    pub late_excess: i16,
    /// Supply voltage.
    pub supply: AdcCode,
    /// Encoder counter.
    pub encoder: EncoderCount,
    /// The bridge's nFAULT pin is low, or the timer's break latched since the outputs were last enabled.
    pub bridge_fault: bool,
    /// The previous control interrupt had not finished when this one was due.
    pub overrun: bool,
}

/// What the bridge does until the next control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outputs {
    /// Timer outputs off, nSLEEP low: coast.
    #[default]
    Off,
    /// nSLEEP high, timer outputs off: the bridge wakes up (1 ms at most, DRV8876 data sheet SLVSDS7B, t_WAKE) and may
    /// pull nFAULT low meanwhile.
    Wake,
    /// Awake, EN low: both low sides on.
    Brake,
    /// Awake and driving.
    Drive {
        /// Torque direction.
        direction: Direction,
        /// On-time.
        duty: Duty,
    },
}
