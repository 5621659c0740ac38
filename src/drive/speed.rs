//! Speed loop: proportional and integral on the observer's speed, with a limited acceleration of the reference.

use super::config::Config;
use super::convert::{PERIOD_S, Scale};
use super::demand::LimitsReached;
use super::limit::limit_magnitude;

/// Control periods a step: 5 kHz delay a loop of 33 Hz by less than two degrees.
pub const PERIODS_PER_STEP: u8 = 4;
const STEP_S: f32 = PERIODS_PER_STEP as f32 * PERIOD_S;
/// Bandwidth, radian per second: 32 Hz. Low, because sensing takes the current for the torque: the encoder's unevenness once a motor
/// turn (61 Hz at 0.3 rad/s) must not become current. High enough to hold the worm, whose friction falls with speed, in steady motion.
const BANDWIDTH_RAD_PER_S: f32 = 205.0;
/// The integral's corner. A torque that rises by r slows a rotor of inertia J down by r / (J x bandwidth x corner): the stiffest cable of
/// the experiments, 10 kN/m, by 2.8 % at 0.3 rad/s. More of it, and less bandwidth, would do the same with less unevenness and a
/// damping below 0.6.
const INTEGRAL_RAD_PER_S: f32 = 138.0;

/// State of the speed loop. Speeds in counts a control period.
#[derive(Clone, Debug)]
pub struct SpeedLoop {
    gain_a_per_speed: f32,
    integral_a_per_speed: f32,
    feed_forward_a_per_change: f32,
    limit: f32,
    change_limit: f32,
    reference: f32,
    integral_a: f32,
}

impl SpeedLoop {
    /// Gains from the rotor's inertia, which dominates everything behind it: 1/reduction^2 of the finger's counts.
    pub fn new(config: &Config, scale: &Scale) -> Self {
        let motor = &config.motor;
        // Motor radian per second of a count a period, by way of k_e.
        let rad_per_s = scale.emf_v_per_count_per_period() / motor.torque_constant_nm_per_a;
        let a_per_rad_per_s2 = motor.rotor_inertia_kg_m2 / motor.torque_constant_nm_per_a;
        let gain_a_per_speed = BANDWIDTH_RAD_PER_S * a_per_rad_per_s2 * rad_per_s;
        Self {
            gain_a_per_speed,
            integral_a_per_speed: gain_a_per_speed * (INTEGRAL_RAD_PER_S * STEP_S),
            feed_forward_a_per_change: a_per_rad_per_s2 * rad_per_s / STEP_S,
            limit: scale.counts_per_s(config.limits.speed_rad_per_s) * PERIOD_S,
            change_limit: scale.counts_per_s(config.limits.acceleration_rad_per_s2)
                * PERIOD_S
                * STEP_S,
            reference: 0.0,
            integral_a: 0.0,
        }
    }

    /// Starts from the present speed and current, so that the change of mode is smooth.
    pub fn preset(&mut self, speed: f32, current_a: f32) {
        self.reference = speed;
        self.integral_a = current_a;
    }

    /// Largest current towards positive and negative speed that keeps the configured speed: what bounds a current demand.
    pub fn current_bounds_a(&self, speed: f32) -> (f32, f32) {
        let up_a = self.gain_a_per_speed * (self.limit - speed);
        let down_a = self.gain_a_per_speed * (-self.limit - speed);
        (down_a, up_a)
    }

    /// Current reference, ampere, for a wanted speed, every [`PERIODS_PER_STEP`]; says in `limited` if it had to clamp either.
    pub fn step(
        &mut self,
        wanted: f32,
        speed: f32,
        current_limit_a: f32,
        limited: &mut LimitsReached,
    ) -> f32 {
        let (target, speed_limited) = limit_magnitude(wanted, self.limit);
        if speed_limited {
            limited.speed = true;
        }
        let (change, _) = limit_magnitude(target - self.reference, self.change_limit);
        self.reference += change;
        let error = self.reference - speed;
        let integral_a = self.integral_a + self.integral_a_per_speed * error;
        let free_a =
            self.gain_a_per_speed * error + integral_a + self.feed_forward_a_per_change * change;
        let (current_a, current_limited) = limit_magnitude(free_a, current_limit_a);
        if current_limited {
            limited.current = true;
        }
        // Anti-windup: while clamped the integral may only shrink.
        if !current_limited || integral_a.abs() < self.integral_a.abs() {
            self.integral_a = integral_a;
        }
        current_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::config::tests::p70;

    #[test]
    fn holds_a_speed_against_friction_without_offset() {
        let config = p70();
        let scale = Scale::of(&config);
        let mut control = SpeedLoop::new(&config, &scale);
        let rad_per_s_per_speed = 122.7f32;
        let mut speed = 0.0f32;
        let wanted = 3.13f32;
        let mut peak = 0.0f32;
        for _ in 0..10_000 {
            let current_a = control.step(wanted, speed, 0.12, &mut LimitsReached::default());
            let friction_nm = 0.13e-3 * if speed > 0.0 { 1.0 } else { 0.0 };
            speed += (8.9e-3 * current_a - friction_nm) / 1e-8 / rad_per_s_per_speed * STEP_S;
            peak = peak.max(speed);
        }
        assert!((speed - wanted).abs() < 1e-3, "{speed}");
        assert!(peak < 1.1 * wanted, "overshoot to {peak}");
    }

    #[test]
    fn clamps_and_says_so_and_leaves_no_windup() {
        let config = p70();
        let scale = Scale::of(&config);
        let mut control = SpeedLoop::new(&config, &scale);
        for _ in 0..40_000 {
            let mut limited = LimitsReached::default();
            assert!(control.step(100.0, 0.0, 0.05, &mut limited) <= 0.05);
            assert!(limited.speed && !limited.duty && !limited.position);
        }
        // Blocked for two seconds, then free: the integral must not hold more than the limit.
        control.preset(0.0, control.integral_a);
        assert!(control.step(0.0, 0.0, 0.12, &mut LimitsReached::default()) <= 0.06);
    }
}
