//! Current loop. L/R is 10-30 us for the winding and some 70 us with the choke, about the control period, and the integral's time
//! constant is twenty of those: for it the plant is static. Feed-forward of R i, of the back-EMF and of what the bridge's dead time
//! takes does the work, the integral corrects what the model has wrong.
//!
//! No `idsp` filter here: the integral must stand still while the current does not flow the way that was asked for, which a
//! biquad's state cannot express.

use super::config::Config;
use super::demand::LimitsReached;
use super::io::DEAD_SHARE;
use super::limit::limit_magnitude;

/// Share of the remaining current error that the integral takes back in one period: a time constant of 20 periods
/// (1 ms) with a motor of nominal resistance, far from the stability limit of 1 whatever its resistance.
const INTEGRAL_GAIN: f32 = 0.05;
/// The integral never exceeds what a motor at the edge of its tolerances needs: 30 % of resistance (20 % spread and the
/// warm winding), 15 % of back-EMF, and the bridge's own drop. A faulty current sense therefore cannot wind it up to a harmful current.
const RESISTANCE_TRIM: f32 = 0.3;
const EMF_TRIM: f32 = 0.15;
const BRIDGE_TRIM_V: f32 = 0.3;
/// What the dead time takes of the supply: its share of it, and of the drop of two body diodes at 12 V (R: 0.9 V each).
const DEAD_FRACTION: f32 = DEAD_SHARE * (1.0 + 2.0 * 0.9 / 12.0);
/// Current, ampere, below which the dead time takes less: half of its ripple, which then comes to zero (docs/HARDWARE.md#bridge).
const RIPPLE_A: f32 = 4.5e-3;

/// A smaller EMF counts as 0, volt: at rest the observer's speed decays for seconds, down to denormal numbers.
const LEAST_EMF_V: f32 = 1e-9;

/// State of the current loop.
#[derive(Clone, Debug)]
pub struct CurrentLoop {
    cold_ohm: f32,
    choke_ohm: f32,
    resistance_ohm: f32,
    integral_v_per_a: f32,
    emf_v_per_speed: f32,
    duty_limit: f32,
    trim_v: f32,
    integral_v: f32,
}

impl CurrentLoop {
    /// For a motor whose back-EMF is `emf_v_per_speed` volt per count a period.
    pub fn new(config: &Config, emf_v_per_speed: f32) -> Self {
        Self {
            cold_ohm: config.motor.resistance_ohm,
            choke_ohm: config.motor.choke_ohm,
            resistance_ohm: config.motor.circuit_ohm(),
            integral_v_per_a: INTEGRAL_GAIN * config.motor.circuit_ohm(),
            emf_v_per_speed,
            duty_limit: config.limits.duty,
            trim_v: BRIDGE_TRIM_V,
            integral_v: 0.0,
        }
    }

    /// Once a millisecond: follows the winding's temperature, by its resistance relative to the configuration's, and bounds the
    /// integral by current and speed.
    pub fn adapt(&mut self, relative_resistance: f32, reference_a: f32, speed: f32) {
        self.resistance_ohm = self.cold_ohm * relative_resistance + self.choke_ohm;
        let resistive_v = self.resistance_ohm * reference_a;
        let emf_v = self.emf_v_per_speed * speed;
        self.trim_v = RESISTANCE_TRIM * resistive_v.abs() + EMF_TRIM * emf_v.abs() + BRIDGE_TRIM_V;
    }

    /// The motor's back-EMF, volt, closing positive, at a speed in counts a period: what the loop makes of the voltage beyond the winding's
    /// resistance and the dead time. The integral has what the motor's constants are off by.
    pub fn emf_v(&self, speed: f32) -> f32 {
        let emf_v = self.emf_v_per_speed * speed + self.integral_v;
        if emf_v.abs() < LEAST_EMF_V {
            0.0
        } else {
            emf_v
        }
    }

    /// Clears the integral: the bridge was off.
    pub fn reset(&mut self) {
        self.integral_v = 0.0;
    }

    /// Voltage, as a fraction of the supply, for a current, given the current measured in the last period (`None` where it did not
    /// flow the way that was asked for) and the speed in counts a period; says in `limited` if it had to clamp it at the largest duty.
    pub fn step(
        &mut self,
        reference_a: f32,
        measured_a: Option<f32>,
        speed: f32,
        per_supply_v: f32,
        limited: &mut LimitsReached,
    ) -> f32 {
        let resistive_v = self.resistance_ohm * reference_a;
        let emf_v = self.emf_v_per_speed * speed;
        let mut integral_v = self.integral_v;
        if let Some(measured_a) = measured_a {
            integral_v += self.integral_v_per_a * (reference_a - measured_a);
        }
        (integral_v, _) = limit_magnitude(integral_v, self.trim_v);
        // From the current, whichever way it flows.
        let (dead, _) = limit_magnitude(reference_a * (DEAD_FRACTION / RIPPLE_A), DEAD_FRACTION);
        let wanted = (resistive_v + emf_v + integral_v) * per_supply_v + dead;
        let (fraction, at_limit) = limit_magnitude(wanted, self.duty_limit);
        if at_limit {
            limited.duty = true;
        }
        // Anti-windup: a clamped voltage must not fill the integral further.
        if !at_limit || integral_v.abs() < self.integral_v.abs() {
            self.integral_v = integral_v;
        }
        fraction
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::config::tests::p70;

    #[test]
    fn the_emf_of_a_speed_that_has_decayed_is_zero() {
        let control = CurrentLoop::new(&p70(), 1.0);
        for speed in [1.4e-44f32, -1.4e-44, 1e-12, 0.0] {
            assert_eq!(control.emf_v(speed), 0.0, "{speed:e}");
        }
        for speed in [-3.0, -1e-6, 1e-6, 3.0] {
            assert_eq!(control.emf_v(speed), speed);
        }
    }

    /// One step from a supply, and what it says of limits.
    fn step(
        control: &mut CurrentLoop,
        reference_a: f32,
        measured_a: Option<f32>,
        speed: f32,
        supply_v: f32,
    ) -> (f32, LimitsReached) {
        let mut limited = LimitsReached::default();
        let fraction = control.step(reference_a, measured_a, speed, 1.0 / supply_v, &mut limited);
        (fraction, limited)
    }

    /// Current that a bridge with dead time makes flow.
    fn flowing_a(fraction: f32, supply_v: f32, emf_v: f32, ohm: f32) -> f32 {
        let free_v = fraction * supply_v - emf_v;
        let dead_v = DEAD_FRACTION * supply_v;
        free_v.signum() * (free_v.abs() - dead_v).max(0.0) / ohm
    }

    /// Current that flows after `periods`, in a motor whose parameters are off by these factors.
    fn settle(
        reference_a: f32,
        speed: f32,
        resistance: f32,
        emf: f32,
        periods: usize,
    ) -> (f32, f32) {
        let config = p70();
        let mut control = CurrentLoop::new(&config, 1.09);
        let supply_v = 12.0;
        let mut current_a = 0.0f32;
        let mut peak_a = 0.0f32;
        let mut fraction = 0.0f32;
        let ohm = config.motor.resistance_ohm * resistance + config.motor.choke_ohm;
        for period in 0..periods {
            if period % 20 == 0 {
                control.adapt(1.0, reference_a, speed);
            }
            let sensed = (fraction * reference_a > 0.0).then_some(if current_a * fraction > 0.0 {
                current_a
            } else {
                0.0
            });
            fraction = step(&mut control, reference_a, sensed, speed, supply_v).0;
            current_a = flowing_a(fraction, supply_v, 1.09 * emf * speed, ohm);
            peak_a = peak_a.max(current_a.abs());
        }
        (current_a, peak_a)
    }

    #[test]
    fn reaches_the_reference_in_motors_at_the_edge_of_their_tolerances() {
        for resistance in [0.8, 1.0, 1.2] {
            for emf in [0.9, 1.0, 1.1] {
                for speed in [-3.0, 0.0, 3.0] {
                    for reference_a in [0.02f32, 0.06, 0.12] {
                        let reference_a = reference_a * if speed < 0.0 { -1.0 } else { 1.0 };
                        let (current_a, peak_a) = settle(reference_a, speed, resistance, emf, 400);
                        assert!(
                            (current_a - reference_a).abs() < 2e-4,
                            "{reference_a} A wanted, {current_a} A, R x {resistance}, k x {emf}, speed {speed}"
                        );
                        // First step: what the model has wrong, at most 25 % of the current and 10 % of 3.3 V over 32 ohm.
                        assert!(peak_a < 1.25 * reference_a.abs() + 0.015, "{peak_a}");
                    }
                }
            }
        }
    }

    /// In brake and while the direction changes nothing is measured: the voltage is then as good as the model.
    #[test]
    fn without_a_reading_a_warm_winding_gets_the_voltage_that_it_needs() {
        let config = p70();
        let mut control = CurrentLoop::new(&config, 1.09);
        let warm = 1.0 + 0.00393 * 60.0;
        let current_a = |control: &mut CurrentLoop| {
            let (fraction, _) = step(control, 0.1, None, 0.0, 12.0);
            let ohm = config.motor.resistance_ohm * warm + config.motor.choke_ohm;
            flowing_a(fraction, 12.0, 0.0, ohm)
        };
        assert!(current_a(&mut control) < 0.085, "cold model");
        control.adapt(warm, 0.1, 0.0);
        assert!((current_a(&mut control) - 0.1).abs() < 1e-4);
    }

    #[test]
    fn dead_time_is_made_up_for() {
        let config = p70();
        for reference_a in [-0.06f32, -0.02, -0.005, 0.005, 0.02, 0.06] {
            let mut control = CurrentLoop::new(&config, 1.09);
            control.adapt(1.0, reference_a, 0.0);
            let (fraction, _) = step(&mut control, reference_a, None, 0.0, 12.0);
            let current_a = flowing_a(fraction, 12.0, 0.0, config.motor.circuit_ohm());
            assert!((current_a - reference_a).abs() < 1e-5, "{current_a}");
        }
        // Where the ripple comes to zero in every period there is less to make up for.
        let mut control = CurrentLoop::new(&config, 1.09);
        control.adapt(1.0, 0.0, 0.0);
        let (fraction, _) = step(&mut control, 0.0, None, 0.0, 12.0);
        assert_eq!(fraction, 0.0);
    }

    #[test]
    fn a_dead_sense_cannot_wind_the_current_up_to_the_trip() {
        let config = p70();
        let mut control = CurrentLoop::new(&config, 1.09);
        for _ in 0..100_000 {
            control.adapt(1.0, config.limits.current_a, 0.0);
            let (fraction, _) = step(&mut control, config.limits.current_a, Some(0.0), 0.0, 12.0);
            assert!(
                fraction * 12.0 / (0.8 * config.motor.resistance_ohm)
                    < config.limits.current_trip_a
            );
        }
    }

    #[test]
    fn saturation_leaves_no_windup() {
        let config = p70();
        let mut control = CurrentLoop::new(&config, 1.09);
        for _ in 0..10_000 {
            control.adapt(1.0, 0.12, 0.0);
            // 4 V of supply cannot push 120 mA.
            let (fraction, limited) = step(&mut control, 0.12, Some(0.08), 0.0, 4.0);
            assert!(limited.duty && fraction <= config.limits.duty);
        }
        let (fraction, limited) = step(&mut control, 0.12, Some(0.12), 0.0, 12.0);
        let current_a = flowing_a(fraction, 12.0, 0.0, config.motor.circuit_ohm());
        assert!((current_a - 0.12).abs() < 3e-3, "{current_a}");
        assert!(!limited.duty);
    }
}
