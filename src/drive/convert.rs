//! Codes to units and back: the one place that knows the scales.

use super::config::Config;
use super::io::{ADC_FULL, AdcCode, CONTROL_HZ, DUTY_FULL, Direction, Duty, Outputs};
use core::f32::consts::TAU;

/// Control period, second.
pub const PERIOD_S: f32 = 1.0 / CONTROL_HZ as f32;
/// Control period, microseconds.
pub const PERIOD_US: u32 = 1_000_000 / CONTROL_HZ;

/// Scales of one board and drivetrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    a_per_code: f32,
    code_per_a: f32,
    /// What the code of no current reads, ampere.
    zero_a: f32,
    v_per_code: f32,
    code_per_v: f32,
    counts_per_rad: f32,
    rad_per_count: f32,
    emf_v_per_count_per_period: f32,
}

impl Scale {
    /// Scales of a configuration; [`CheckedConfig`](super::config::CheckedConfig) has them of one that holds together.
    pub(super) const fn of(config: &Config) -> Self {
        let pin_v_per_code = config.sense.reference_v / ADC_FULL as f32;
        let a_per_code = pin_v_per_code / config.sense.volt_per_a;
        let v_per_code = pin_v_per_code * config.sense.supply_divider;
        let counts_per_rad =
            config.drivetrain.counts_per_motor_rev * config.drivetrain.reduction / TAU;
        let motor_rad_per_s = TAU / config.drivetrain.counts_per_motor_rev * CONTROL_HZ as f32;
        Self {
            a_per_code,
            code_per_a: 1.0 / a_per_code,
            zero_a: config.sense.zero_v / config.sense.volt_per_a,
            v_per_code,
            code_per_v: 1.0 / v_per_code,
            counts_per_rad,
            rad_per_count: 1.0 / counts_per_rad,
            emf_v_per_count_per_period: config.motor.torque_constant_nm_per_a * motor_rad_per_s,
        }
    }

    /// Motor current as the sense reads it, ampere, offset included: a magnitude, or closing positive where the sense is
    /// signed.
    pub fn current_a(&self, code: AdcCode) -> f32 {
        f32::from(code.0) * self.a_per_code - self.zero_a
    }

    /// Ampere of a code of excess: either half of a period is summed from half as many conversions as the whole.
    pub fn a_per_excess(&self) -> f32 {
        2.0 * self.a_per_code
    }

    /// Code that reads as this current: rounded, saturating at both ends of the converter; NaN gives 0.
    pub fn current_code(&self, current_a: f32) -> AdcCode {
        saturated_code((current_a + self.zero_a) * self.code_per_a)
    }

    /// Supply voltage, volt.
    pub fn supply_v(&self, code: AdcCode) -> f32 {
        f32::from(code.0) * self.v_per_code
    }

    /// Code that reads as this supply voltage: rounded, saturating; NaN gives 0.
    pub fn supply_code(&self, supply_v: f32) -> AdcCode {
        saturated_code(supply_v * self.code_per_v)
    }

    /// Angle of the input link, radian, of a number of counts.
    pub fn angle_rad(&self, counts: i32) -> f32 {
        counts as f32 * self.rad_per_count
    }

    /// Counts of an angle of the input link, truncated, saturating; NaN gives 0.
    pub fn counts(&self, angle_rad: f32) -> i32 {
        (angle_rad * self.counts_per_rad) as i32
    }

    /// Counts per second of a speed of the input link.
    pub fn counts_per_s(&self, rad_per_s: f32) -> f32 {
        rad_per_s * self.counts_per_rad
    }

    /// Speed of the input link, radian per second.
    pub fn rad_per_s(&self, counts_per_s: f32) -> f32 {
        counts_per_s * self.rad_per_count
    }

    /// Back-EMF, volt, of a motor speed of one count a control period.
    pub fn emf_v_per_count_per_period(&self) -> f32 {
        self.emf_v_per_count_per_period
    }
}

/// Rounds to a code; a float-to-integer cast saturates and maps NaN to 0.
fn saturated_code(code: f32) -> AdcCode {
    AdcCode(((code + 0.5) as u16).min(ADC_FULL))
}

/// Bridge output for a motor voltage, given as a fraction of the supply, closing positive: direction from the sign,
/// on-time rounded and clamped to the timer's range; NaN gives no drive.
pub fn drive(fraction: f32) -> Outputs {
    let direction = if fraction < 0.0 {
        Direction::Opening
    } else {
        Direction::Closing
    };
    // The core converts to 32 bits, saturating, in one instruction; to 16 in eight.
    let ticks = (fraction.abs() * f32::from(DUTY_FULL) + 0.5) as u32;
    Outputs::Drive {
        direction,
        duty: Duty(ticks.min(u32::from(DUTY_FULL)) as u16),
    }
}

/// Fraction of the supply that an output applies to the motor, closing positive.
pub fn applied(outputs: Outputs) -> f32 {
    const PER_TICK: f32 = 1.0 / DUTY_FULL as f32;
    match outputs {
        Outputs::Off | Outputs::Wake | Outputs::Brake => 0.0,
        Outputs::Drive {
            direction: Direction::Closing,
            duty,
        } => f32::from(duty.0) * PER_TICK,
        Outputs::Drive {
            direction: Direction::Opening,
            duty,
        } => -(f32::from(duty.0) * PER_TICK),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::config::tests::p70;
    use proptest::prelude::*;

    fn scale() -> Scale {
        Scale::of(&p70())
    }

    #[test]
    fn the_prototypes_scales_are_those_of_its_data_sheets() {
        let scale = scale();
        // 3.3 V over 6.8 V/A, and 18.3 V behind 82 and 18 kohm.
        assert!((scale.current_a(AdcCode(ADC_FULL)) - 0.485_294).abs() < 1e-6);
        assert!((scale.supply_v(AdcCode(ADC_FULL)) - 18.333_33).abs() < 1e-4);
        // 1024 x 64 x 20 counts a revolution.
        assert!((scale.angle_rad(1_310_720) - TAU).abs() < 1e-6);
        assert!((scale.counts_per_s(0.3) - 62_582.3).abs() < 0.5);
        assert!((scale.rad_per_s(62_582.3) - 0.3).abs() < 1e-6);
        // 8.9 mV s/rad at 20,000 / 1024 revolutions a second.
        assert!((scale.emf_v_per_count_per_period() - 1.092_19).abs() < 1e-4);
    }

    proptest! {
        #[test]
        fn every_code_survives_the_way_to_units_and_back(code in 0..=ADC_FULL) {
            let scale = scale();
            prop_assert_eq!(scale.current_code(scale.current_a(AdcCode(code))), AdcCode(code));
            prop_assert_eq!(scale.supply_code(scale.supply_v(AdcCode(code))), AdcCode(code));
        }

        #[test]
        fn whatever_is_asked_for_is_a_legal_output(fraction: f32) {
            match drive(fraction) {
                Outputs::Drive { direction, duty } => {
                    prop_assert!(duty.0 <= DUTY_FULL);
                    if fraction.abs() < 1.0 {
                        prop_assert!((applied(drive(fraction)) - fraction).abs() <= 0.501 / f32::from(DUTY_FULL));
                    }
                    if fraction < 0.0 {
                        prop_assert_eq!(direction, Direction::Opening);
                    }
                }
                other => prop_assert!(false, "{:?}", other),
            }
        }
    }

    #[test]
    fn a_signed_sense_has_its_zero_in_the_middle() {
        let mut config = p70();
        config.sense.volt_per_a = 5.0;
        config.sense.zero_v = 1.65;
        config.sense.signed = true;
        let signed = Scale::of(&config);
        for (code, current_a) in [(0, -0.33), (ADC_FULL, 0.33), (ADC_FULL / 2, 0.0)] {
            assert!((signed.current_a(AdcCode(code)) - current_a).abs() < 1e-5);
            assert_eq!(
                signed.current_code(signed.current_a(AdcCode(code))),
                AdcCode(code)
            );
        }
    }

    #[test]
    fn conversions_saturate() {
        let scale = scale();
        for (value, code) in [
            (f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
            (-1.0, 0),
            (1e30, ADC_FULL),
            (f32::INFINITY, ADC_FULL),
        ] {
            assert_eq!(scale.current_code(value), AdcCode(code));
            assert_eq!(scale.supply_code(value), AdcCode(code));
        }
        assert_eq!(scale.counts(f32::NAN), 0);
        assert_eq!(scale.counts(f32::INFINITY), i32::MAX);
        assert_eq!(scale.counts(f32::NEG_INFINITY), i32::MIN);
        assert_eq!(applied(drive(f32::NAN)), 0.0);
        assert!((applied(drive(f32::INFINITY)) - 1.0).abs() < 1e-6);
        assert!((applied(drive(f32::NEG_INFINITY)) + 1.0).abs() < 1e-6);
    }
}
