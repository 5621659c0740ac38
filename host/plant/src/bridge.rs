//! H-bridge, winding and current sense.

use crate::Pins;
use crate::parameters::Parameters;

/// Result of a step of the bridge.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BridgeOutput {
    /// Mean winding current over the step, ampere, closing positive.
    pub mean_a: f64,
    /// Current drawn from the supply, ampere.
    pub drawn_a: f64,
    /// Whether its chopping limited the current or its supply is too low.
    pub fault: bool,
}

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct Bridge {
    parameters: Parameters,
    inductance: f64,
    /// Winding current at the end of the last step, ampere.
    pub current_a: f64,
    awake_for: f64,
    winding_rise: f64,
    housing_rise: f64,
    /// Decay factors of the last step's length and resistance.
    decay: Decay,
}

#[derive(Clone, Copy, Debug, Default)]
struct Decay {
    resistance: f64,
    dt: f64,
    end: f64,
    mean: f64,
}

impl Bridge {
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            parameters: parameters.clone(),
            inductance: parameters.motor.resistance_ohm
                * parameters.motor.electrical_time_constant_s,
            current_a: 0.0,
            awake_for: 0.0,
            winding_rise: 0.0,
            housing_rise: 0.0,
            decay: Decay::default(),
        }
    }

    /// Winding temperature, degree Celsius.
    pub fn winding_c(&self) -> f64 {
        self.parameters.motor.ambient_c + self.winding_rise
    }

    /// Torque constant relative to that of cold magnets: they sit in the housing.
    pub fn magnets(&self) -> f64 {
        1.0 + self.parameters.motor.magnet_temperature_coefficient_per_k * self.housing_rise
    }

    /// Whether outputs follow EN and PH: awake for long enough and supplied.
    fn ready(&self, supply_v: f64) -> bool {
        self.awake_for >= self.parameters.bridge.wake_s
            && supply_v >= self.parameters.bridge.undervoltage_v
    }

    /// One step at a supply voltage, with the back-EMF voltage of the turning motor; `short` scales the winding resistance.
    pub fn step(
        &mut self,
        pins: &Pins,
        supply_v: f64,
        back_emf_v: f64,
        short: f64,
        dt: f64,
    ) -> BridgeOutput {
        let motor = &self.parameters.motor;
        self.awake_for = if pins.awake { self.awake_for + dt } else { 0.0 };
        let low = pins.awake && supply_v < self.parameters.bridge.undervoltage_v;
        let duty = pins.drive();
        let mut step = BridgeOutput {
            fault: low,
            ..BridgeOutput::default()
        };
        if self.ready(supply_v) {
            let copper = motor.resistance_ohm * short;
            let warm =
                copper * (1.0 + motor.copper_temperature_coefficient_per_k * self.winding_rise);
            let resistance = warm + self.parameters.bridge.on_resistance_ohm;
            // Both low switches conduct in the off time (slow decay), so the winding sees the mean voltage.
            let ideal_v = duty * supply_v - back_emf_v;
            // In the dead time the current flows on through a diode, whichever way that makes the voltage.
            let bridge = &self.parameters.bridge;
            let dead_v = bridge.dead_time_s * bridge.pwm_hz * supply_v;
            let lost_v = if duty == 0.0 {
                0.0
            } else {
                ideal_v.clamp(-dead_v, dead_v)
            };
            let target = (ideal_v - lost_v) / resistance;
            if (self.decay.resistance, self.decay.dt) != (resistance, dt) {
                let tau = self.inductance / resistance;
                let end = (-dt / tau).exp();
                self.decay = Decay {
                    resistance,
                    dt,
                    end,
                    mean: tau / dt * (1.0 - end),
                };
            }
            step.mean_a = target + (self.current_a - target) * self.decay.mean;
            self.current_a = target + (self.current_a - target) * self.decay.end;
            let limit = self.parameters.bridge.chop_current_a;
            if self.current_a.abs() > limit {
                step.fault = true;
                self.current_a = self.current_a.clamp(-limit, limit);
                step.mean_a = step.mean_a.clamp(-limit, limit);
            }
            step.drawn_a = duty * step.mean_a;
        } else {
            // Off: the body diodes empty the inductance within the step, and block below the supply voltage.
            self.current_a = 0.0;
        }
        self.warm_up(step.mean_a * step.mean_a * motor.resistance_ohm * short, dt);
        step
    }

    fn warm_up(&mut self, loss_w: f64, dt: f64) {
        let motor = &self.parameters.motor;
        let across = self.winding_rise - self.housing_rise;
        let flow = across / motor.winding_thermal_resistance_k_per_w;
        let winding_j_per_k =
            motor.winding_thermal_time_constant_s / motor.winding_thermal_resistance_k_per_w;
        let housing_j_per_k =
            motor.housing_thermal_time_constant_s / motor.housing_thermal_resistance_k_per_w;
        self.winding_rise += dt * (loss_w - flow) / winding_j_per_k;
        let lost = self.housing_rise / motor.housing_thermal_resistance_k_per_w;
        self.housing_rise += dt * (flow - lost) / housing_j_per_k;
    }

    /// Mean motor current at the sense output over the window of a control period, ampere without noise; unsigned, zero while the
    /// bridge is off. A current that opposes the drive shows only in the off part of the PWM, while the low sides carry it round.
    pub fn sensed_a(&self, pins: &Pins, supply_v: f64) -> f64 {
        let Parameters { sense, bridge, .. } = &self.parameters;
        let duty = pins.drive();
        if !self.ready(supply_v) {
            return 0.0;
        }
        let magnitude = self.current_a.abs();
        let off = 1.0 - duty.abs();
        if self.current_a * duty < 0.0 {
            return sense.opposing_share * off * magnitude;
        }
        let full_scale_a = sense.full_scale_v / (sense.resistor_ohm * sense.mirror_a_per_a);
        let bent = sense.nonlinearity * magnitude / full_scale_a;
        // The mirror follows each edge with a delay, so a larger share of a short on-time is missed.
        let late = sense.settling_s * bridge.pwm_hz * off;
        magnitude * (1.0 + bent) * (1.0 - late).max(0.0)
    }

    /// Whether the sense amplifier is on, so that its offset is measured.
    pub fn senses(&self, supply_v: f64) -> bool {
        self.ready(supply_v)
    }
}
