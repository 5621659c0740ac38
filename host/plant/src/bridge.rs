//! H-bridge, winding and current sense.

use crate::Pins;
use crate::converter::{Pin, Switching};
use crate::parameters::Parameters;
use crate::switching::{Circuit, Constants, Period, Periods, Sense, Winding};
use std::sync::Arc;

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
    /// Winding and sense at the end of the last step.
    winding: Winding,
    /// The last step's, and the recent periods of the PWM.
    circuit: Circuit,
    periods: Periods,
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
                * parameters.motor.electrical_time_constant_s
                + parameters.choke.inductance_h,
            winding: Winding::default(),
            circuit: Circuit::default(),
            periods: Periods::default(),
            awake_for: 0.0,
            winding_rise: 0.0,
            housing_rise: 0.0,
            decay: Decay::default(),
        }
    }

    /// Winding current at the end of the last step, ampere, closing positive.
    pub fn current_a(&self) -> f64 {
        self.winding.current_a
    }

    /// The timer of the PWM counts zero: the middle of the on-time.
    pub fn align(&mut self) {
        self.winding.phase_s = 0.0;
    }

    /// Winding temperature, degree Celsius.
    pub fn winding_c(&self) -> f64 {
        self.parameters.motor.ambient_c + self.winding_rise
    }

    /// Torque constant relative to the stated one: the magnets sit in the housing.
    pub fn magnets(&self) -> f64 {
        (self.parameters.motor).magnets(self.housing_rise)
    }

    /// Whether outputs follow EN and PH: awake for long enough and supplied.
    fn ready(&self, supply_v: f64) -> bool {
        self.awake_for >= self.parameters.bridge.wake_s
            && supply_v >= self.parameters.bridge.undervoltage_v
    }

    /// One step at a supply voltage, with the back-EMF voltage of the turning motor; `short` scales the winding resistance,
    /// `offset_a` is the sense's.
    pub fn step(
        &mut self,
        pins: &Pins,
        [supply_v, back_emf_v]: [f64; 2],
        short: f64,
        offset_a: f64,
        dt: f64,
    ) -> BridgeOutput {
        let motor = &self.parameters.motor;
        let bridge = &self.parameters.bridge;
        self.awake_for = if pins.awake { self.awake_for + dt } else { 0.0 };
        let low = pins.awake && supply_v < bridge.undervoltage_v;
        let copper = motor.resistance_ohm * short;
        let warm = copper * motor.copper(self.winding_rise);
        let now_ohm = warm + bridge.on_resistance_ohm + self.parameters.choke.resistance_ohm;
        let before = self.circuit.constants;
        // With edges a resistance that is hardly another keeps what was computed of the one before.
        let same = (now_ohm - before.resistance_ohm).abs() < 1e-5 * now_ohm;
        let constants = if same && self.parameters.has_edges() {
            before
        } else {
            Constants::new(now_ohm, self.inductance / now_ohm, self.lag_s())
        };
        self.circuit = Circuit {
            sign: if pins.closing { 1.0 } else { -1.0 },
            supply_v,
            back_emf_v,
            constants,
            diode_v: bridge.diode_v,
            chop_a: bridge.chop_current_a,
            sense: self.sense(offset_a),
        };
        let mut step = BridgeOutput::default();
        let mut square_a2 = 0.0;
        if !self.ready(supply_v) {
            // Off: the body diodes empty the inductance within the step, and block below the supply voltage.
            self.winding.idle(1.0 / bridge.pwm_hz, dt);
        } else if self.parameters.has_edges() {
            let period = self.period_of(pins);
            self.periods.keep(&period);
            let totals = self.winding.advance(&self.circuit, &period, dt);
            step.mean_a = totals.charge / dt;
            step.drawn_a = totals.drawn / dt;
            step.fault = totals.chopped;
            square_a2 = totals.square / dt;
        } else {
            step = self.step_by_means(pins, dt);
            square_a2 = step.mean_a * step.mean_a;
        }
        if pins.awake {
            step.drawn_a += self.parameters.bridge.quiescent_a;
        }
        step.fault |= low;
        self.warm_up(square_a2 * copper, dt);
        step
    }

    /// The period of the PWM that these levels make, computed anew unless it is among the recent ones.
    fn period_of(&self, pins: &Pins) -> Arc<Period> {
        let bridge = &self.parameters.bridge;
        let (duty, period_s) = (pins.drive().abs(), 1.0 / bridge.pwm_hz);
        self.periods
            .of(duty, period_s, bridge.dead_time_s, &self.circuit)
    }

    /// The sense with this offset.
    fn sense(&self, offset_a: f64) -> Sense {
        let sense = &self.parameters.sense;
        let nominal = sense.volt_per_a();
        Sense {
            signed: sense.is_shunt(),
            volt_per_a: nominal * (1.0 + sense.gain_error),
            offset_v: sense.zero_v() + nominal * offset_a,
        }
    }

    /// Time constant of mirror and pin together, second. Two lags in a row delay by their sum; the longer one, at the pin, is what is
    /// seen of their shape.
    fn lag_s(&self) -> f64 {
        let sense = &self.parameters.sense;
        (sense.settling_s + sense.pin_ohm() * sense.pin_f).max(1e-9)
    }

    /// Without edges: the winding sees the mean voltage, since both low switches conduct in the off time (slow decay).
    fn step_by_means(&mut self, pins: &Pins, dt: f64) -> BridgeOutput {
        let Circuit {
            supply_v,
            back_emf_v,
            constants,
            ..
        } = self.circuit;
        let resistance = constants.resistance_ohm;
        let duty = pins.drive();
        let mut step = BridgeOutput::default();
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
        let current_a = self.winding.current_a;
        step.mean_a = target + (current_a - target) * self.decay.mean;
        self.winding.current_a = target + (current_a - target) * self.decay.end;
        let limit = bridge.chop_current_a;
        if self.winding.current_a.abs() > limit {
            step.fault = true;
            self.winding.current_a = self.winding.current_a.clamp(-limit, limit);
            step.mean_a = step.mean_a.clamp(-limit, limit);
        }
        step.drawn_a = duty * step.mean_a;
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

    /// The pin of the sense from now on with these levels, if the bridge is on and its current has edges.
    pub fn pin(&self, pins: &Pins, noise_v: [f64; 2]) -> Option<Pin> {
        if !self.parameters.has_edges() || !self.senses(self.circuit.supply_v) {
            return None;
        }
        let mut circuit = self.circuit;
        circuit.sign = if pins.closing { 1.0 } else { -1.0 };
        let sense = &self.parameters.sense;
        let bent_per_v = if circuit.sense.signed {
            0.0
        } else {
            sense.nonlinearity / sense.full_scale_v
        };
        Some(Pin::Switching(Switching {
            winding: self.winding,
            circuit,
            period: self.period_of(pins),
            reached_s: 0.0,
            noise_v,
            bent_per_v,
            full_scale_v: sense.full_scale_v,
        }))
    }

    /// Motor current at the sense output without edges, ampere without noise; unsigned, zero while the bridge is off. A current
    /// that opposes the drive shows only in the off part of the PWM, while the low sides carry it round.
    pub fn sensed_a(&self, pins: &Pins, supply_v: f64) -> f64 {
        let Parameters { sense, bridge, .. } = &self.parameters;
        let duty = pins.drive();
        if !self.ready(supply_v) {
            return 0.0;
        }
        let magnitude = self.winding.current_a.abs();
        let off = 1.0 - duty.abs();
        if self.winding.current_a * duty < 0.0 {
            return sense.opposing_share * off * magnitude;
        }
        let bent = sense.nonlinearity * magnitude / sense.full_scale_a();
        // The mirror follows each edge with a delay, so a larger share of a short on-time is missed.
        let late = sense.settling_s * bridge.pwm_hz * off;
        magnitude * (1.0 + bent) * (1.0 - late).max(0.0)
    }

    /// Whether the sense amplifier is on, so that its offset is measured.
    pub fn senses(&self, supply_v: f64) -> bool {
        self.ready(supply_v)
    }
}
