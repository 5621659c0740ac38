//! Inputs from outside: the chip's levels, and faults.

use crate::EncoderFault;

/// What the chip puts on the bridge's pins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pins {
    /// The timer drives EN; else EN is pulled low.
    pub outputs_enabled: bool,
    /// nSLEEP.
    pub awake: bool,
    /// Share of time that EN is high, 0 to 1; beyond, it is clamped.
    pub duty: f64,
    /// PH.
    pub closing: bool,
}

impl Pins {
    /// A bridge that is awake and closes the finger.
    #[must_use]
    pub fn closing(duty: f64) -> Self {
        Self {
            outputs_enabled: true,
            awake: true,
            duty,
            closing: true,
        }
    }

    /// Share of the supply voltage at the motor, closing positive.
    pub(crate) fn drive(&self) -> f64 {
        if !self.outputs_enabled || self.duty.is_nan() {
            return 0.0;
        }
        let duty = self.duty.clamp(0.0, 1.0);
        if self.closing { duty } else { -duty }
    }
}

/// What is broken; all of it can change from one step to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// Wires of the encoder.
    pub encoder: EncoderFault,
    /// The rotor does not turn.
    pub rotor_locked: bool,
    /// Supply voltage instead of the parameter's.
    pub supply_v: Option<f64>,
    /// Further offset of the current sense, ampere at the motor.
    pub sense_offset_a: f64,
    /// Share of the winding that is left by a short circuit, above 0; 1 is healthy.
    pub winding_left: f64,
    /// The stops of the input link are broken off, and those of joint 1: nothing ends the motion.
    pub stops_missing: bool,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            encoder: EncoderFault::default(),
            rotor_locked: false,
            supply_v: None,
            sense_offset_a: 0.0,
            winding_left: 1.0,
            stops_missing: false,
        }
    }
}
