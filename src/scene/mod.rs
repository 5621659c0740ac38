//! What a firmware is built for: a finger with its drivetrain, its board and its limits.
//!
//! A scene is a type: what it does not use is not compiled into its firmware. The types are generated from `scenes/*.toml` at
//! build time, for the firmware and for the host programs; a library user may also implement [`Scene`] by hand.

#[cfg(all(test, feature = "firmware"))]
#[macro_use]
mod generated {
    //! Every scene of `scenes/`, for the tests of this library.
    include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
}

#[cfg(all(test, feature = "firmware"))]
pub use generated::*;

use crate::drive::config::{CheckedConfig, Config, OutOfRange};
use crate::drive::io::ADC_FULL;
use crate::drive::sequence::Motion;
use crate::finger::{ConfigError, Mechanics};
use crate::joint_sensor::{AdcScale, AngleSensor, JointSensor};
use crate::sample::Sample;
use crate::sensing::{AfterContact, Calibration, Drivetrain, SeriesElement, Settings};

/// Angle of joint 2 in a scene: nothing without a sensor.
pub type Reading<S> = <<S as Scene>::Joint as JointSensor>::Reading;

/// A sample of a scene's drivetrain.
pub type SampleOf<S> = Sample<Reading<S>>;

/// A finger with its drivetrain, its board and its limits. `build.rs` makes one of a file in `scenes/`.
///
/// ```
/// use palpate::finger::Mechanics;
/// use palpate::scene::Scene;
/// use palpate_scenes::P70;
///
/// assert_eq!((P70::NAME, P70::PHALANGES), ("p70", 2));
/// assert_eq!(P70::MECHANISM.phalanx_length_m(1), Some(0.090));
/// ```
pub trait Scene {
    /// Name, as logged and as `--scene` takes it.
    const NAME: &'static str;

    /// Every number on which a record of friction or a calibration depends, as text: lengths, springs, gears, cable, current sense,
    /// closing speed. A stored record of a scene with another name or other dimensions is refused.
    const DIMENSIONS: &'static str;

    /// The finger's mechanics.
    type Finger: Mechanics;

    /// The sensor of joint 2: [`HallSensor`](crate::sensing::HallSensor), or
    /// [`NoJointSensor`](crate::sensing::NoJointSensor).
    type Joint: JointSensor;

    /// What lies between gears and input link: a [`Cable`](crate::sensing::Cable), or nothing that gives way
    /// ([`Rigid`](crate::sensing::Rigid)).
    type Series: SeriesElement;

    /// What comes after the first contact: [`Follow`](crate::sensing::Follow), or nothing
    /// ([`FirstContactOnly`](crate::sensing::FirstContactOnly)).
    type After: AfterContact<Self::Finger>;

    /// The finger, checked: one with a value out of its range, or whose linkage does not close, does not compile.
    const MECHANISM: Self::Finger;

    /// Motor, gears, board, limits and trips.
    const DRIVE: Config;

    /// Speeds, currents and times of the motion sequence.
    const MOTION: Motion;

    /// What the sensing may assume before anything is calibrated.
    const UNCALIBRATED: Calibration;

    /// The drivetrain as the sensing sees it, but for the angle of the opening stop, which follows from the finger.
    const DRIVETRAIN: Drivetrain;

    /// Torque at the motor that friction takes without load at the closing speed, newton metre.
    const FRICTION_NM: f32;

    /// The firmware can identify its motor and uses what it found.
    const IDENTIFIES: bool;

    /// Contact force that holding aims at, newton.
    const HOLD_FORCE_N: f32;

    /// Direction of gravity where the scene states a weight, counterclockwise from phalanx 1 where its joint angle is zero, radian.
    const MOUNTING_RAD: f32 = 0.0;

    /// The sensor of joint 2 where one is fitted.
    const ANGLE_SENSOR: AngleSensor;

    /// Settings of the sensing.
    fn settings() -> Settings;

    /// Angle of the input link from the opening stop to where a free closing ends, short of the closing stop, radian.
    const TRAVEL_RAD: f32 = Self::MOTION.travel_rad;

    /// Nominal efficiency of the gears under load, 0 to 1.
    const EFFICIENCY: f32 = Self::DRIVETRAIN.efficiency;

    /// Phalanges; the last one is where a pin calibrates.
    const PHALANGES: u8 = <Self::Finger as Mechanics>::PHALANGES as u8;

    /// [`DRIVE`](Self::DRIVE), checked, with its scales. A scene whose drive or motion is out of range does not compile.
    const CHECKED: CheckedConfig = match (
        CheckedConfig::new(Self::DRIVE),
        Self::MOTION.validate(&Self::DRIVE.limits),
    ) {
        (Ok(checked), Ok(())) => checked,
        _ => panic!("a value of the scene's DRIVE or MOTION is out of range"),
    };

    /// The sensor of joint 2 on this board's converter.
    ///
    /// # Errors
    /// The parameter of the sensor that is out of its range.
    fn joint_sensor() -> Result<Self::Joint, OutOfRange> {
        let adc = AdcScale {
            reference_v: Self::DRIVE.sense.reference_v,
            full_scale: ADC_FULL,
        };
        JointSensor::new(adc, &Self::ANGLE_SENSOR)
    }

    /// The drivetrain as the sensing sees it. At the opening stop the finger has its springs' rest angles.
    fn drivetrain(finger: &Self::Finger) -> Drivetrain {
        Drivetrain {
            opening_stop_rad: finger.input_angle_rad(&finger.rest()),
            ..Self::DRIVETRAIN
        }
    }
}

/// What a scene's finger is, if it can be: otherwise the compiler stops and says what is out of range.
pub const fn valid<F: Copy>(finger: Result<F, ConfigError>) -> F {
    match finger {
        Ok(finger) => finger,
        Err(error) => panic!("{}", error.what()),
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::*;
    use crate::app::storage::record::scene_id;

    fn holds_together<S: Scene>() {
        let finger = S::MECHANISM;
        CheckedConfig::new(S::DRIVE).expect(S::NAME);
        S::joint_sensor().expect(S::NAME);
        let drivetrain = S::drivetrain(&finger);
        let limits = S::DRIVE.limits;
        let (motion, settings) = (S::MOTION, S::settings());
        // Everything that the sequence asks for must lie within what the controller allows, or it would be clamped.
        for current_a in [
            motion.free_current_a,
            motion.homing_current_a,
            motion.probing_current_a,
        ] {
            assert!(
                current_a > 0.0 && current_a <= limits.current_a,
                "{}",
                S::NAME
            );
        }
        // Nothing is as good: the worm holds.
        assert!((0.0..=limits.current_a).contains(&motion.holding_current_a));
        assert!(motion.closing_rad_per_s <= limits.speed_rad_per_s);
        assert!(motion.opening_rad_per_s <= limits.speed_rad_per_s);
        motion.validate(&limits).expect(S::NAME);
        // Probing must be able to reach the torque at which it ends.
        let probing_nm =
            motion.probing_current_a * drivetrain.torque_per_ampere_nm * drivetrain.efficiency;
        assert!(settings.torque_limit_nm < probing_nm, "{}", S::NAME);
        assert_eq!(settings.speed_rad_per_s, motion.closing_rad_per_s);
        assert!(drivetrain.opening_stop_rad.is_finite());
    }

    #[test]
    fn every_scene_is_valid_and_its_parts_fit_each_other() {
        for_each_scene!(|S| holds_together::<S>());
    }

    #[test]
    fn no_scene_takes_the_stored_record_of_another() {
        let mut ids = std::collections::BTreeSet::new();
        for_each_scene!(|S| assert!(ids.insert(scene_id::<S>()), "{}", S::NAME));
        assert!(ids.len() > 10);
    }
}
