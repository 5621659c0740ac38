//! The optional angle sensor at joint 2, from the converter's codes to an angle.
//!
//! A type: a board without the sensor carries neither its state nor its code.

use super::config::{AnalogInputs, OutOfRange, check};
use super::io::{ADC_FULL, AdcCode};

/// An analogue angle sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleSensor {
    /// Output at an angle of zero, volt.
    pub zero_v: f32,
    /// Output a radian, volt; negative where the voltage falls as the joint closes.
    pub volt_per_rad: f32,
    /// Smallest angle that the joint can have, radian: a reading below is a fault of the sensor.
    pub min_rad: f32,
    /// Largest angle that the joint can have, radian.
    pub max_rad: f32,
}

/// How the board reads joint 2: [`NotFitted`] or [`HallInput`].
pub trait JointInput: Copy + core::fmt::Debug {
    /// What the control interrupt stores with a sample.
    type Raw: Copy;

    /// The angle that it stands for.
    type Reading: Copy;

    /// Whether there is a pin to convert.
    const FITTED: bool;

    /// An input.
    ///
    /// # Errors
    /// The first parameter out of its range.
    fn new(board: &AnalogInputs, sensor: &AngleSensor) -> Result<Self, OutOfRange>;

    /// Stores a code, where there is a pin to convert.
    fn take(code: impl FnOnce() -> AdcCode) -> Self::Raw;

    /// Angle of a stored code.
    fn reading(&self, raw: Self::Raw) -> Self::Reading;
}

/// No sensor; no size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NotFitted;

impl JointInput for NotFitted {
    type Raw = ();
    type Reading = ();
    const FITTED: bool = false;

    fn new(_: &AnalogInputs, _: &AngleSensor) -> Result<Self, OutOfRange> {
        Ok(Self)
    }

    fn take(_: impl FnOnce() -> AdcCode) {}

    fn reading(&self, (): ()) {}
}

/// A Hall sensor. A code that the joint cannot have is no reading: a broken wire gives zero, a short full scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HallInput {
    rad_per_code: f32,
    zero_code: f32,
    lowest: AdcCode,
    highest: AdcCode,
}

impl JointInput for HallInput {
    type Raw = AdcCode;
    /// Angle, radian.
    type Reading = Option<f32>;
    const FITTED: bool = true;

    fn new(board: &AnalogInputs, sensor: &AngleSensor) -> Result<Self, OutOfRange> {
        // Both ends must stand clear of what a broken wire and a short read.
        let end_v = |rad: f32| sensor.zero_v + sensor.volt_per_rad * rad;
        let (a_v, b_v) = (end_v(sensor.min_rad), end_v(sensor.max_rad));
        let (low_v, high_v) = (a_v.min(b_v), a_v.max(b_v));
        let margin_v = 0.02 * board.reference_v;
        check(&[
            ("volt_per_rad", sensor.volt_per_rad.abs(), 0.01, 10.0),
            ("zero_v", sensor.zero_v, -20.0, 20.0),
            ("min_rad", sensor.min_rad, -3.2, sensor.max_rad),
            ("max_rad", sensor.max_rad, sensor.min_rad, 3.2),
            ("lowest_v", low_v, margin_v, board.reference_v),
            ("highest_v", high_v, low_v, board.reference_v - margin_v),
        ])?;
        let code_per_v = f32::from(ADC_FULL) / board.reference_v;
        // Within the converter's range, as just checked.
        let code = |volt: f32| AdcCode((volt * code_per_v) as u16);
        Ok(Self {
            rad_per_code: 1.0 / (sensor.volt_per_rad * code_per_v),
            zero_code: sensor.zero_v * code_per_v,
            lowest: code(low_v),
            highest: code(high_v),
        })
    }

    fn take(code: impl FnOnce() -> AdcCode) -> AdcCode {
        code()
    }

    fn reading(&self, raw: AdcCode) -> Option<f32> {
        let plausible = raw >= self.lowest && raw <= self.highest;
        plausible.then(|| (f32::from(raw.0) - self.zero_code) * self.rad_per_code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOARD: AnalogInputs = AnalogInputs {
        reference_v: 3.3,
        volt_per_a: 6.8,
        zero_v: 0.0,
        signed: false,
        supply_divider: 5.0,
    };
    const SENSOR: AngleSensor = AngleSensor {
        zero_v: 0.5,
        volt_per_rad: 1.0,
        min_rad: -0.4,
        max_rad: 2.3,
    };

    fn code(volt: f32) -> AdcCode {
        AdcCode((volt / BOARD.reference_v * f32::from(ADC_FULL)).round() as u16)
    }

    #[test]
    fn a_code_becomes_its_angle() {
        let input = HallInput::new(&BOARD, &SENSOR).unwrap();
        for angle_rad in [-0.39, 0.0, 0.7, 1.5, 2.29] {
            let volt = SENSOR.zero_v + SENSOR.volt_per_rad * angle_rad;
            let read = input.reading(HallInput::take(|| code(volt))).unwrap();
            assert!((read - angle_rad).abs() < 1e-4, "{read} {angle_rad}");
        }
    }

    #[test]
    fn a_falling_output_is_as_good() {
        let falling = AngleSensor {
            zero_v: 2.8,
            volt_per_rad: -1.0,
            ..SENSOR
        };
        let input = HallInput::new(&BOARD, &falling).unwrap();
        let read = input.reading(code(1.8)).unwrap();
        assert!((read - 1.0).abs() < 1e-4, "{read}");
    }

    #[test]
    fn a_code_that_the_joint_cannot_have_is_no_reading() {
        let input = HallInput::new(&BOARD, &SENSOR).unwrap();
        for bad_v in [0.0, 0.09, 2.81, 3.3] {
            assert_eq!(input.reading(code(bad_v)), None, "{bad_v} V");
        }
        for good_v in [0.11, 1.2, 2.79] {
            assert!(input.reading(code(good_v)).is_some(), "{good_v} V");
        }
    }

    #[test]
    fn every_value_out_of_range_is_named() {
        type Spoil = (&'static str, fn(&mut AngleSensor));
        let spoils: [Spoil; 9] = [
            ("volt_per_rad", |s| s.volt_per_rad = 0.0),
            ("volt_per_rad", |s| s.volt_per_rad = f32::NAN),
            ("zero_v", |s| s.zero_v = f32::INFINITY),
            ("min_rad", |s| s.min_rad = f32::NAN),
            ("min_rad", |s| s.min_rad = 2.4),
            ("max_rad", |s| s.max_rad = 4.0),
            ("lowest_v", |s| s.zero_v = 0.4),
            ("highest_v", |s| s.zero_v = 1.0),
            ("lowest_v", |s| s.volt_per_rad = -1.0),
        ];
        for (name, spoil) in spoils {
            let mut sensor = SENSOR;
            spoil(&mut sensor);
            let error = HallInput::new(&BOARD, &sensor).expect_err(name);
            assert_eq!(error.name, name);
        }
    }

    #[test]
    fn a_board_without_it_has_nothing() {
        NotFitted::take(|| panic!("nothing to read"));
        assert_eq!(size_of::<NotFitted>(), 0);
        assert_eq!(size_of::<<NotFitted as JointInput>::Raw>(), 0);
    }
}
