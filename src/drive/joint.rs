//! The optional angle sensor at joint 2, from the converter's codes to an angle.
//!
//! A type: a board without the sensor carries neither its state nor its code.

use super::config::{OutOfRange, Sense, check};
use super::io::{ADC_FULL, AdcCode};

/// An analogue angle sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleSense {
    /// Output at an angle of zero, volt.
    pub zero_v: f32,
    /// Output a radian, volt; negative where the voltage falls as the joint closes.
    pub volt_per_rad: f32,
    /// Smallest angle that the joint can have, radian: what reads below is a fault of the sensor.
    pub min_rad: f32,
    /// Largest angle that the joint can have, radian.
    pub max_rad: f32,
}

/// How the board reads joint 2: [`NotFitted`] or [`HallInput`].
pub trait JointInput: Copy + core::fmt::Debug {
    /// What a sample carries.
    type Reading: Copy;

    /// Whether there is a pin to convert.
    const FITTED: bool;

    /// An input at rest.
    ///
    /// # Errors
    /// The first parameter out of its range.
    fn new(board: &Sense, sensor: &AngleSense) -> Result<Self, OutOfRange>;

    /// Takes the code of a control period.
    fn push(&mut self, code: AdcCode);

    /// The mean over the periods since the last call.
    fn take(&mut self) -> Self::Reading;
}

/// No sensor; no size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NotFitted;

impl JointInput for NotFitted {
    type Reading = ();
    const FITTED: bool = false;

    fn new(_: &Sense, _: &AngleSense) -> Result<Self, OutOfRange> {
        Ok(Self)
    }

    fn push(&mut self, _: AdcCode) {}

    fn take(&mut self) {}
}

/// A Hall sensor. It has no reading for a sample in which a single code was one that the joint cannot have: a broken wire
/// reads zero, a short full scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HallInput {
    rad_per_code: f32,
    zero_code: f32,
    lowest: AdcCode,
    highest: AdcCode,
    sum: u32,
    periods: u16,
    plausible: bool,
}

impl JointInput for HallInput {
    /// Angle, radian.
    type Reading = Option<f32>;
    const FITTED: bool = true;

    fn new(board: &Sense, sensor: &AngleSense) -> Result<Self, OutOfRange> {
        let full = f32::from(ADC_FULL);
        let code_per_v = full / board.reference_v;
        let code_per_rad = sensor.volt_per_rad * code_per_v;
        let zero_code = sensor.zero_v * code_per_v;
        check("volt_per_rad", sensor.volt_per_rad.abs(), 0.01, 10.0)?;
        check("zero_v", sensor.zero_v, -20.0, 20.0)?;
        check("min_rad", sensor.min_rad, -3.2, sensor.max_rad)?;
        check("max_rad", sensor.max_rad, sensor.min_rad, 3.2)?;
        // Both ends must stand clear of what a broken wire and a short read.
        let (a, b) = (sensor.min_rad, sensor.max_rad);
        let end = |rad: f32| sensor.zero_v + sensor.volt_per_rad * rad;
        let (low_v, high_v) = (end(a).min(end(b)), end(a).max(end(b)));
        let margin_v = 0.02 * board.reference_v;
        check("lowest_v", low_v, margin_v, board.reference_v)?;
        check("highest_v", high_v, low_v, board.reference_v - margin_v)?;
        // Within the converter's range, as just checked.
        let code = |volt: f32| AdcCode((volt * code_per_v) as u16);
        Ok(Self {
            rad_per_code: 1.0 / code_per_rad,
            zero_code,
            lowest: code(low_v),
            highest: code(high_v),
            sum: 0,
            periods: 0,
            plausible: true,
        })
    }

    // Both run in the control interrupt, and are part of it: no calls.
    #[inline(always)]
    fn push(&mut self, code: AdcCode) {
        self.plausible &= code >= self.lowest && code <= self.highest;
        self.sum = self.sum.wrapping_add(u32::from(code.0));
        self.periods = self.periods.wrapping_add(1);
    }

    #[inline(always)]
    fn take(&mut self) -> Option<f32> {
        let Self {
            sum,
            periods,
            plausible,
            ..
        } = *self;
        (self.sum, self.periods, self.plausible) = (0, 0, true);
        let mean = sum as f32 / f32::from(periods);
        (plausible && periods > 0).then(|| (mean - self.zero_code) * self.rad_per_code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOARD: Sense = Sense {
        reference_v: 3.3,
        volt_per_a: 6.8,
        supply_divider: 5.0,
    };
    const SENSOR: AngleSense = AngleSense {
        zero_v: 0.5,
        volt_per_rad: 1.0,
        min_rad: -0.4,
        max_rad: 2.3,
    };

    fn code(volt: f32) -> AdcCode {
        AdcCode((volt / BOARD.reference_v * f32::from(ADC_FULL)).round() as u16)
    }

    fn read(input: &mut HallInput, volts: &[f32]) -> Option<f32> {
        for &volt in volts {
            input.push(code(volt));
        }
        input.take()
    }

    #[test]
    fn an_angle_is_the_mean_of_its_codes() {
        let mut input = HallInput::new(&BOARD, &SENSOR).unwrap();
        for angle_rad in [-0.39, 0.0, 0.7, 1.5, 2.29] {
            let volt = SENSOR.zero_v + SENSOR.volt_per_rad * angle_rad;
            let ripple = 0.005;
            let volts: Vec<f32> = (0..20)
                .map(|i| volt + if i % 2 == 0 { ripple } else { -ripple })
                .collect();
            let read = read(&mut input, &volts).unwrap();
            assert!((read - angle_rad).abs() < 1e-4, "{read} {angle_rad}");
        }
    }

    #[test]
    fn a_falling_output_is_as_good() {
        let falling = AngleSense {
            zero_v: 2.8,
            volt_per_rad: -1.0,
            ..SENSOR
        };
        let mut input = HallInput::new(&BOARD, &falling).unwrap();
        let read = read(&mut input, &[1.8; 20]).unwrap();
        assert!((read - 1.0).abs() < 1e-4, "{read}");
    }

    #[test]
    fn one_impossible_code_spoils_its_sample_and_no_other() {
        let mut input = HallInput::new(&BOARD, &SENSOR).unwrap();
        for bad_v in [0.0, 0.09, 2.81, 3.3] {
            let mut volts = [1.2; 20];
            volts[7] = bad_v;
            assert_eq!(read(&mut input, &volts), None, "{bad_v} V");
            assert!(read(&mut input, &[1.2; 20]).is_some());
        }
        assert_eq!(input.take(), None, "nothing was converted");
    }

    #[test]
    fn every_value_out_of_range_is_named() {
        type Spoil = (&'static str, fn(&mut AngleSense));
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
        assert_eq!(size_of::<NotFitted>(), 0);
        assert_eq!(size_of::<<NotFitted as JointInput>::Reading>(), 0);
    }
}
