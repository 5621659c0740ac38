//! The optional angle sensor of joint 2, from the converter's code to what a change of the angle says of a contact.
//!
//! One trait, [`JointSensor`]: control interrupt, sensing and log are generic over it. In a scene without the sensor its type
//! is [`NoJointSensor`], codes and readings have no size, and nothing of this module is compiled into the firmware.

use crate::range::{OutOfRange, check};

/// How joint 2 is measured: [`NoJointSensor`] or [`HallSensor`].
pub trait JointSensor: Copy + core::fmt::Debug {
    /// What the control interrupt stores with a sample.
    type Code: Copy;

    /// An angle or a change of it, kept with each block of samples.
    type Reading: Copy + Default + core::fmt::Debug + PartialEq;

    /// Whether there is a pin to convert.
    const FITTED: bool;

    /// Standard deviation of a measured change of theta_2, radian.
    const SIGMA_RAD: f32;

    /// A sensor on the board's converter.
    ///
    /// # Errors
    /// The first parameter out of its range.
    fn new(adc: AdcScale, sensor: &AngleSensor) -> Result<Self, OutOfRange>;

    /// Stores a code, where there is a pin to convert.
    fn take(code: impl FnOnce() -> u16) -> Self::Code;

    /// What the sensor tells of a contact; without a sensor it has no size.
    type Told: Told;

    /// Angle of a stored code.
    fn reading(&self, code: Self::Code) -> Self::Reading;

    /// The reading whose angle a recording tells, radian; without a sensor it is ignored.
    fn recorded(angle_rad: Option<f32>) -> Self::Reading;

    /// Change of theta_2 between two readings.
    fn change(from: Self::Reading, to: Self::Reading) -> Self::Reading;

    /// The mean of two readings.
    fn middle(a: Self::Reading, b: Self::Reading) -> Self::Reading;

    /// A reading or a change, radian; None without a sensor or while it has no reading.
    fn rad(reading: Self::Reading) -> Option<f32>;

    /// What a change of theta_2 since the curve's origin tells, read where the nominal excess torque is `excess_nm` and the free finger's
    /// torque `free_nm`, newton metre.
    fn told(change: Self::Reading, excess_nm: f32, free_nm: f32) -> Self::Told;

    /// Which side of phalanx 2's stiffest place e_2 a change since contact indicates; None without a sensor.
    fn side(change: Self::Reading) -> Option<Side> {
        Self::rad(change).map(|change_rad| Side::of(change_rad, SIDE_SIGMAS * Self::SIGMA_RAD))
    }
}

/// What a sensor of joint 2 tells of a contact: [`JointChange`] if it has a reading, or nothing.
pub trait Told: Copy + Default + core::fmt::Debug {
    /// The change, if there is one.
    fn change(self) -> Option<JointChange>;

    /// The same, taken for wrong: its deviation is infinite.
    #[must_use]
    fn distrusted(self) -> Self;
}

impl Told for () {
    fn change(self) -> Option<JointChange> {
        None
    }

    fn distrusted(self) {}
}

impl Told for Option<JointChange> {
    fn change(self) -> Option<JointChange> {
        self
    }

    fn distrusted(self) -> Self {
        self.map(|change| JointChange {
            sigma_rad: f32::INFINITY,
            ..change
        })
    }
}

/// A change of theta_2 since the origin of the contact's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointChange {
    /// The change, closing positive, radian.
    pub rad: f32,
    /// Its standard deviation; infinite for one that is taken for wrong.
    pub sigma_rad: f32,
    /// Nominal torque above the free finger's where it was read, newton metre.
    pub excess_nm: f32,
    /// The free finger's torque there.
    pub free_nm: f32,
}

/// Error of a measured change as a share of it: magnet and converter are as the scene says, and nobody calibrates them (chosen).
const SCALE_SIGMA: f32 = 0.03;

/// Standard deviations that a change must exceed to indicate a side.
const SIDE_SIGMAS: f32 = 3.0;

/// Side of e_2 on which phalanx 2 is touched: below it the joint closes as the torque rises, beyond it the joint opens
/// (docs/MECHANICS.md#observability). Of a contact on another phalanx it says nothing certain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Between the joint and e_2.
    Below,
    /// Between e_2 and the tip.
    Beyond,
    /// The joint has not moved by more than its sensor's noise.
    Unclear,
}

impl Side {
    /// The side that a change of theta_2 since contact indicates, closing positive, where `noise_rad` of it may be noise; both
    /// in radian.
    pub fn of(change_rad: f32, noise_rad: f32) -> Self {
        if change_rad > noise_rad {
            Self::Below
        } else if change_rad < -noise_rad {
            Self::Beyond
        } else {
            Self::Unclear
        }
    }
}

/// The converter that reads the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdcScale {
    /// Voltage at full scale, volt.
    pub reference_v: f32,
    /// Code at full scale.
    pub full_scale: u16,
}

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

/// No sensor; no size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoJointSensor;

impl JointSensor for NoJointSensor {
    type Code = ();
    type Reading = ();
    type Told = ();
    const FITTED: bool = false;
    const SIGMA_RAD: f32 = f32::INFINITY;

    fn new(_: AdcScale, _: &AngleSensor) -> Result<Self, OutOfRange> {
        Ok(Self)
    }

    fn take(_: impl FnOnce() -> u16) {}

    fn reading(&self, (): ()) {}

    fn recorded(_: Option<f32>) {}

    fn change((): (), (): ()) {}

    fn middle((): (), (): ()) {}

    fn rad((): ()) -> Option<f32> {
        None
    }

    fn told((): (), _: f32, _: f32) {}
}

/// A Hall sensor. A code that the joint cannot have is no reading: a broken wire gives zero, a short circuit full scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HallSensor {
    rad_per_code: f32,
    zero_code: f32,
    lowest: u16,
    highest: u16,
}

impl JointSensor for HallSensor {
    type Code = u16;
    /// Radian.
    type Reading = Option<f32>;
    type Told = Option<JointChange>;
    const FITTED: bool = true;
    // 0.2 degree: a few millivolt of such a sensor.
    const SIGMA_RAD: f32 = 3.5e-3;

    fn new(adc: AdcScale, sensor: &AngleSensor) -> Result<Self, OutOfRange> {
        // Both ends must stand clear of what a broken wire and a short read.
        let end_v = |rad: f32| sensor.zero_v + sensor.volt_per_rad * rad;
        let (a_v, b_v) = (end_v(sensor.min_rad), end_v(sensor.max_rad));
        let (low_v, high_v) = (a_v.min(b_v), a_v.max(b_v));
        let margin_v = 0.02 * adc.reference_v;
        check(&[
            ("volt_per_rad", sensor.volt_per_rad.abs(), 0.01, 10.0),
            ("zero_v", sensor.zero_v, -20.0, 20.0),
            ("min_rad", sensor.min_rad, -3.2, sensor.max_rad),
            ("max_rad", sensor.max_rad, sensor.min_rad, 3.2),
            ("lowest_v", low_v, margin_v, adc.reference_v),
            ("highest_v", high_v, low_v, adc.reference_v - margin_v),
        ])?;
        let code_per_v = f32::from(adc.full_scale) / adc.reference_v;
        // Within the converter's range, as just checked.
        let code = |volt: f32| (volt * code_per_v) as u16;
        Ok(Self {
            rad_per_code: 1.0 / (sensor.volt_per_rad * code_per_v),
            zero_code: sensor.zero_v * code_per_v,
            lowest: code(low_v),
            highest: code(high_v),
        })
    }

    fn take(code: impl FnOnce() -> u16) -> u16 {
        code()
    }

    fn reading(&self, code: u16) -> Option<f32> {
        let plausible = code >= self.lowest && code <= self.highest;
        plausible.then(|| (f32::from(code) - self.zero_code) * self.rad_per_code)
    }

    fn recorded(angle_rad: Option<f32>) -> Option<f32> {
        angle_rad
    }

    fn change(from: Option<f32>, to: Option<f32>) -> Option<f32> {
        Some(to? - from?)
    }

    fn middle(a: Option<f32>, b: Option<f32>) -> Option<f32> {
        Some(0.5 * (a? + b?))
    }

    fn rad(reading: Option<f32>) -> Option<f32> {
        reading.filter(|angle| angle.is_finite())
    }

    fn told(change: Option<f32>, excess_nm: f32, free_nm: f32) -> Option<JointChange> {
        let rad = Self::rad(change)?;
        Some(JointChange {
            rad,
            sigma_rad: Self::SIGMA_RAD + SCALE_SIGMA * rad.abs(),
            excess_nm,
            free_nm,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADC: AdcScale = AdcScale {
        reference_v: 3.3,
        full_scale: 16 * 4095,
    };
    const SENSOR: AngleSensor = AngleSensor {
        zero_v: 0.5,
        volt_per_rad: 1.0,
        min_rad: -0.4,
        max_rad: 2.3,
    };

    fn code(volt: f32) -> u16 {
        (volt / ADC.reference_v * f32::from(ADC.full_scale)).round() as u16
    }

    #[test]
    fn a_code_becomes_its_angle() {
        let input = HallSensor::new(ADC, &SENSOR).unwrap();
        for angle_rad in [-0.39, 0.0, 0.7, 1.5, 2.29] {
            let volt = SENSOR.zero_v + SENSOR.volt_per_rad * angle_rad;
            let read = input.reading(HallSensor::take(|| code(volt))).unwrap();
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
        let input = HallSensor::new(ADC, &falling).unwrap();
        let read = input.reading(code(1.8)).unwrap();
        assert!((read - 1.0).abs() < 1e-4, "{read}");
    }

    #[test]
    fn a_code_that_the_joint_cannot_have_is_no_reading() {
        let input = HallSensor::new(ADC, &SENSOR).unwrap();
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
            let error = HallSensor::new(ADC, &sensor).expect_err(name);
            assert_eq!(error.name, name);
        }
    }

    #[test]
    fn a_board_without_it_has_nothing() {
        NoJointSensor::take(|| panic!("nothing to read"));
        NoJointSensor::change((), ());
        assert_eq!(NoJointSensor::side(()), None);
        assert_eq!(size_of::<NoJointSensor>(), 0);
        assert_eq!(size_of::<<NoJointSensor as JointSensor>::Code>(), 0);
        assert_eq!(size_of::<<NoJointSensor as JointSensor>::Reading>(), 0);
    }

    #[test]
    fn the_sign_of_the_change_is_the_side() {
        let side = |from, to| HallSensor::side(HallSensor::change(from, to));
        assert_eq!(side(Some(1.0), Some(1.02)), Some(Side::Below));
        assert_eq!(side(Some(1.0), Some(0.98)), Some(Side::Beyond));
        assert_eq!(side(Some(1.0), Some(1.01)), Some(Side::Unclear));
        for nothing in [None, Some(f32::NAN), Some(f32::INFINITY)] {
            assert_eq!(side(Some(1.0), nothing), None);
            assert_eq!(side(nothing, Some(1.0)), None);
        }
    }

    /// Magnet and converter are as the scene says, and a large change is as much in doubt as they are.
    #[test]
    fn the_larger_a_change_the_larger_its_deviation() {
        for rad in [-1.0f32, -0.1, 0.0, 0.1, 1.0] {
            let told = HallSensor::told(Some(rad), 0.2, 0.1).expect("a reading");
            let sigma_rad = HallSensor::SIGMA_RAD + 0.03 * rad.abs();
            assert!((told.sigma_rad - sigma_rad).abs() < 1e-6, "{told:?}");
            assert_eq!([told.rad, told.excess_nm, told.free_nm], [rad, 0.2, 0.1]);
            let change = Some(told).distrusted().change().expect("the same");
            assert!(change.rad == rad && change.sigma_rad == f32::INFINITY);
        }
        for nothing in [None, Some(f32::NAN), Some(f32::INFINITY)] {
            assert_eq!(HallSensor::told(nothing, 0.2, 0.1), None);
        }
    }

    #[test]
    fn the_middle_lies_between_two_readings() {
        assert_eq!(HallSensor::middle(Some(0.5), Some(1.0)), Some(0.75));
        assert_eq!(HallSensor::middle(None, Some(1.0)), None);
        assert_eq!(HallSensor::middle(Some(0.5), None), None);
    }
}
