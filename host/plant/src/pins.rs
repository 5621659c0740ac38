//! Inputs of the plant: levels from the chip, and injected faults.

use crate::EncoderFault;

/// Levels that the chip applies to the bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pins {
    /// Whether the timer drives EN; otherwise EN is low.
    pub outputs_enabled: bool,
    /// nSLEEP.
    pub awake: bool,
    /// Share of time in which EN is high, clamped to 0 to 1.
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

/// Injected faults; they can change from one step to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// Fault of the encoder's wires.
    pub encoder: EncoderFault,
    /// Whether the rotor is blocked.
    pub rotor_locked: bool,
    /// Supply voltage instead of the parameter's.
    pub supply_v: Option<f64>,
    /// Additional offset of the current sense, ampere at the motor.
    pub sense_offset_a: f64,
    /// Share of the winding resistance that a short circuit leaves, > 0; 1 without a fault.
    pub winding_left: f64,
    /// Whether the stops of input link and joint 1 are missing, so that nothing ends a motion.
    pub stops_missing: bool,
    /// Share of their stiffness that the springs of the joints have left, 0 to 1; 1 without a fault.
    pub springs_left: f64,
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
            springs_left: 1.0,
        }
    }
}
