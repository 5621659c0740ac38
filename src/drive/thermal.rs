//! Winding temperature from the current: an I2t model with two bodies, winding and housing.

use super::config::Motor;
use crate::numeric::Bounded;

/// Resistance of copper grows by this a kelvin; the resistance in the configuration is that at 25 degrees.
pub(super) const COPPER_PER_K: f32 = 0.00393;
pub(super) const COLD_C: f32 = 25.0;

/// Share of the allowed rise that is assumed after a power cut at most: some of it must be left to move with.
const ASSUMED_SHARE: f32 = 0.8;

/// Temperatures of a motor, degree Celsius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temperatures {
    /// Winding.
    pub winding_c: f32,
    /// Housing.
    pub housing_c: f32,
}

impl Temperatures {
    /// A motor that has not run for long.
    pub fn ambient(motor: &Motor) -> Self {
        Self {
            winding_c: motor.thermal.ambient_c,
            housing_c: motor.thermal.ambient_c,
        }
    }

    /// What is assumed where the temperatures are not known, after a power cut: those of a motor that has run at this current
    /// for long. Otherwise switching off and on would take the protection away.
    pub fn after_continuous(motor: &Motor, current_a: f32) -> Self {
        let thermal = &motor.thermal;
        let cold_w = current_a * current_a * motor.resistance_ohm;
        let k_per_w = thermal.winding_k_per_w + thermal.housing_k_per_w;
        // Rise = loss * resistance, the loss with the copper's resistance at that rise: the fixed point.
        let growth = (1.0 - cold_w * k_per_w * COPPER_PER_K).at_least(0.1);
        let most_k = ASSUMED_SHARE * (thermal.limit_c - thermal.ambient_c);
        let rise_k = (cold_w * k_per_w / growth).at_most(most_k);
        Self {
            winding_c: thermal.ambient_c + rise_k,
            housing_c: thermal.ambient_c + rise_k * thermal.housing_k_per_w / k_per_w,
        }
    }

    /// The warmer of both, each body for itself.
    pub fn warmest(self, other: Self) -> Self {
        Self {
            winding_c: self.winding_c.at_least(other.winding_c),
            housing_c: self.housing_c.at_least(other.housing_c),
        }
    }

    /// Whether a motor can have them.
    pub fn is_plausible(&self) -> bool {
        (-50.0..=300.0).contains(&self.winding_c) && (-50.0..=300.0).contains(&self.housing_c)
    }
}

/// Thermal model of one motor.
#[derive(Clone, Debug)]
pub struct Winding {
    ambient_c: f32,
    limit_c: f32,
    resistance_ohm: f32,
    winding_w_per_k: f32,
    housing_w_per_k: f32,
    winding_k_per_j: f32,
    housing_k_per_j: f32,
    /// Rises above ambient: small numbers, so that the small increments of a millisecond are not rounded away.
    winding_rise_k: f32,
    housing_rise_k: f32,
}

impl Winding {
    /// A motor at these temperatures.
    pub fn new(motor: &Motor, temperatures: Temperatures) -> Self {
        let thermal = &motor.thermal;
        Self {
            ambient_c: thermal.ambient_c,
            limit_c: thermal.limit_c,
            resistance_ohm: motor.resistance_ohm,
            winding_w_per_k: 1.0 / thermal.winding_k_per_w,
            housing_w_per_k: 1.0 / thermal.housing_k_per_w,
            winding_k_per_j: thermal.winding_k_per_w / thermal.winding_s,
            housing_k_per_j: thermal.housing_k_per_w / thermal.housing_s,
            winding_rise_k: temperatures.winding_c - thermal.ambient_c,
            housing_rise_k: temperatures.housing_c - thermal.ambient_c,
        }
    }

    /// Advances by `seconds`, much less than the winding's time constant, with this mean square of the current.
    pub fn advance(&mut self, mean_square_a2: f32, seconds: f32) {
        let heat_w = mean_square_a2 * self.resistance_ohm * self.relative_resistance();
        let to_housing_w = (self.winding_rise_k - self.housing_rise_k) * self.winding_w_per_k;
        let to_ambient_w = self.housing_rise_k * self.housing_w_per_k;
        self.winding_rise_k += (heat_w - to_housing_w) * self.winding_k_per_j * seconds;
        self.housing_rise_k += (to_housing_w - to_ambient_w) * self.housing_k_per_j * seconds;
    }

    /// Resistance of the winding at its temperature, relative to that of the configuration.
    pub fn relative_resistance(&self) -> f32 {
        1.0 + COPPER_PER_K * (self.celsius() - COLD_C)
    }

    /// Winding temperature, degree Celsius.
    pub fn celsius(&self) -> f32 {
        self.ambient_c + self.winding_rise_k
    }

    /// Housing temperature, degree Celsius.
    pub fn housing_c(&self) -> f32 {
        self.ambient_c + self.housing_rise_k
    }

    /// Above the limit.
    pub fn is_hot(&self) -> bool {
        self.celsius() > self.limit_c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::config::tests::p70;

    fn motor() -> Motor {
        p70().motor
    }

    /// Seconds until the limit, `None` within `patience_s`.
    fn seconds_to_limit(current_a: f32, patience_s: u32) -> Option<f32> {
        let mut winding = Winding::new(&motor(), Temperatures::ambient(&motor()));
        (0..patience_s * 1000)
            .find(|_| {
                winding.advance(current_a * current_a, 1e-3);
                winding.is_hot()
            })
            .map(|ms| ms as f32 * 1e-3)
    }

    #[test]
    fn the_continuous_limit_is_that_of_the_thermal_resistances() {
        // 42 K/W, 60 K, 35 ohm warmed up by 60 K: i^2 = 60 / (42 * 35 * 1.2358), 182 mA; the data sheet says 183 mA.
        assert_eq!(seconds_to_limit(0.178, 3000), None);
        assert!(seconds_to_limit(0.186, 3000).is_some());
    }

    #[test]
    fn a_stall_at_full_voltage_is_cut_before_the_winding_is_hot() {
        // 347 mA: 4.2 W on the winding alone, 50 K above the housing in the end: adiabatic start 12.6 K/s.
        let seconds = seconds_to_limit(0.347, 200).expect("must trip");
        assert!((5.0..60.0).contains(&seconds), "{seconds}");
        // Twice the current must trip much sooner than a quarter of the time.
        assert!(seconds_to_limit(0.694, 200).expect("must trip") < 0.25 * seconds);
    }

    #[test]
    fn the_default_current_never_trips_and_settles_where_it_must() {
        let mut winding = Winding::new(&motor(), Temperatures::ambient(&motor()));
        for _ in 0..1_500_000 {
            winding.advance(0.12 * 0.12, 1e-3);
            assert!(!winding.is_hot());
        }
        // Fixed point of rise = 42 K/W * i^2 R (1 + alpha rise).
        let power_w = 0.12f32 * 0.12 * 35.0;
        let rise = 42.0 * power_w / (1.0 - 42.0 * power_w * COPPER_PER_K);
        assert!(
            (winding.celsius() - 25.0 - rise).abs() < 0.3,
            "{} against {rise}",
            winding.celsius()
        );
    }

    #[test]
    fn cools_with_both_time_constants() {
        let mut winding = Winding::new(&motor(), Temperatures::ambient(&motor()));
        for _ in 0..4000 {
            winding.advance(0.3 * 0.3, 1e-3);
        }
        let hot = winding.celsius();
        for _ in 0..12_000 {
            winding.advance(0.0, 1e-3);
        }
        let warm = winding.celsius();
        assert!(
            warm < hot - 10.0,
            "the winding gives its heat to the housing in seconds: {hot} to {warm}"
        );
        assert!(warm > 26.0, "the housing keeps it for minutes: {warm}");
    }

    #[test]
    fn what_is_assumed_after_a_power_cut_is_where_continuous_running_ends() {
        let motor = motor();
        let assumed = Temperatures::after_continuous(&motor, 0.12);
        let mut winding = Winding::new(&motor, Temperatures::ambient(&motor));
        for _ in 0..1_500_000 {
            winding.advance(0.12 * 0.12, 1e-3);
        }
        assert!((winding.celsius() - assumed.winding_c).abs() < 0.3);
        assert!((winding.housing_c() - assumed.housing_c).abs() < 0.3);
        // A current beyond what is allowed for long: still below the limit.
        let hot = Temperatures::after_continuous(&motor, 0.35);
        assert!((70.0..80.0).contains(&hot.winding_c), "{hot:?}");
        // Continuing from there is no restart.
        let mut resumed = Winding::new(&motor, assumed);
        resumed.advance(0.12 * 0.12, 1e-3);
        assert!((resumed.celsius() - assumed.winding_c).abs() < 0.01);
    }
}
