//! What a user edits: this finger, this drivetrain, these limits. One file a scene.
//!
//! A scene is a type: what it does not use is not compiled into its firmware. To make your own, copy [`p70`], change its
//! numbers and give it a cargo feature beside the others. The numbers of the simulated scenes are explained in
//! docs/MANUAL.md#scenes.

pub mod linkage3;
pub mod p70;
pub mod p70_rigid;
pub mod re10;
pub mod tendon2;
pub mod tendon2_hall;
pub mod tendon3;

use crate::drive::config::{CheckedConfig, Config, OutOfRange};
use crate::drive::joint::{AngleSensor, HallInput, JointInput, NotFitted};
use crate::drive::sequence::Motion;
use crate::finger::{ConfigError, Mechanics};
use crate::sample::Sample;
use crate::sensing::{Calibration, Drivetrain, Hall, JointSensor, NoHall, Series, Settings};

pub use linkage3::Linkage3;
pub use p70::P70;
pub use p70_rigid::P70Rigid;
pub use tendon2::Tendon2;
pub use tendon2_hall::Tendon2Hall;
pub use tendon3::Tendon3;

/// A sensor of joint 2, and what reads it: [`NoHall`] or [`Hall`].
pub trait Joint: JointSensor {
    /// What the board has for it.
    type Input: JointInput<Reading = Self::Reading>;
}

impl Joint for NoHall {
    type Input = NotFitted;
}

impl Joint for Hall {
    type Input = HallInput;
}

/// How a scene's board reads joint 2.
pub type JointPin<S> = <<S as Scene>::Joint as Joint>::Input;

/// What a scene's board reads of joint 2: nothing without a sensor.
pub type Reading<S> = <<S as Scene>::Joint as JointSensor>::Reading;

/// A sample of a scene's drivetrain.
pub type SampleOf<S> = Sample<Reading<S>>;

/// A finger with its drivetrain, its board and its limits.
pub trait Scene {
    /// Name, as logged and as `--scene` takes it.
    const NAME: &'static str;

    /// The finger's mechanics.
    type Finger: Mechanics;

    /// The sensor of joint 2: [`Hall`], or [`NoHall`].
    type Joint: Joint;

    /// What lies between gears and input link: a [`Cable`](crate::sensing::Cable), or nothing that gives way
    /// ([`Rigid`](crate::sensing::Rigid)).
    type Series: Series;

    /// The finger, checked: one with a value out of its range, or whose linkage does not close, does not compile.
    const MECHANISM: Self::Finger;

    /// Angle of the input link from the opening stop to where a free closing ends, short of the closing stop, radian.
    const TRAVEL_RAD: f32;

    /// Motor, gears, board, limits and trips.
    const DRIVE: Config = re10::DRIVE;

    /// Speeds, currents and times of the motion sequence.
    const MOTION: Motion = re10::motion(Self::TRAVEL_RAD);

    /// [`DRIVE`](Self::DRIVE), checked, with its scales. A scene whose drive or motion is out of range does not compile.
    const CHECKED: CheckedConfig = match (
        CheckedConfig::new(Self::DRIVE),
        Self::MOTION.validate(&Self::DRIVE.limits),
    ) {
        (Ok(checked), Ok(())) => checked,
        _ => panic!("a value of the scene's DRIVE or MOTION is out of range"),
    };

    /// What the sensing may assume before anything is calibrated.
    const UNCALIBRATED: Calibration = re10::UNCALIBRATED;

    /// Phalanges; the last one is where a pin calibrates.
    const PHALANGES: u8;

    /// Nominal efficiency of the gears under load, 0 to 1.
    const EFFICIENCY: f32 = re10::EFFICIENCY;

    /// Contact force that holding aims at, newton.
    const HOLD_FORCE_N: f32 = 1.0;

    /// The sensor of joint 2 where one is fitted.
    const ANGLE_SENSE: AngleSensor = re10::ANGLE_SENSE;

    /// What reads joint 2.
    ///
    /// # Errors
    /// The parameter of the sensor that is out of its range.
    fn joint_input() -> Result<JointPin<Self>, OutOfRange>
    where
        Self: Sized,
    {
        JointInput::new(&Self::DRIVE.sense, &Self::ANGLE_SENSE)
    }

    /// Settings of the sensing.
    fn settings() -> Settings {
        Settings {
            speed_rad_per_s: Self::MOTION.closing_rad_per_s,
            travel_rad: Self::TRAVEL_RAD,
            torque_limit_nm: re10::PROBE_TORQUE_NM,
            ..Settings::default()
        }
    }

    /// The drivetrain as the sensing sees it. At the opening stop the finger has its springs' rest angles.
    fn drivetrain(finger: &Self::Finger) -> Drivetrain {
        re10::drivetrain(finger.input_angle_rad(&finger.rest()))
    }
}

/// What a scene's finger is, if it can be: otherwise the compiler stops and says what is out of range.
const fn valid<F: Copy>(finger: Result<F, ConfigError>) -> F {
    match finger {
        Ok(finger) => finger,
        Err(error) => panic!("{}", error.what()),
    }
}

/// Names each scene once: its cargo feature and its type. From the second one on they exclude those before.
macro_rules! scenes {
    ($($feature:literal => $scene:ident),+ $(,)?) => {
        $(
            /// The scene that this firmware is built for.
            #[cfg(feature = $feature)]
            pub type Active = $scene;
        )+

        #[cfg(all(target_os = "none", not(any($(feature = $feature),+))))]
        compile_error!("choose a scene: --features scene-p70 (or another scene-... of Cargo.toml)");

        /// The scene that this firmware is built for.
        #[cfg(not(any($(feature = $feature),+)))]
        pub type Active = P70;

        one_of!($($feature),+);
    };
}

macro_rules! one_of {
    ($last:literal) => {};
    ($first:literal, $($others:literal),+) => {
        #[cfg(all(feature = $first, any($(feature = $others),+)))]
        compile_error!("choose one scene only: --no-default-features --features scene-...");
        one_of!($($others),+);
    };
}

scenes! {
    "scene-p70" => P70,
    "scene-p70-rigid" => P70Rigid,
    "scene-tendon2" => Tendon2,
    "scene-tendon2-hall" => Tendon2Hall,
    "scene-tendon3" => Tendon3,
    "scene-linkage3" => Linkage3,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds_together<S: Scene>() {
        let finger = S::MECHANISM;
        CheckedConfig::new(S::DRIVE).expect(S::NAME);
        S::joint_input().expect(S::NAME);
        let drivetrain = S::drivetrain(&finger);
        let limits = S::DRIVE.limits;
        let (motion, settings) = (S::MOTION, S::settings());
        // Everything that the sequence asks for must lie within what the controller allows, or it would be clamped.
        for current_a in [
            motion.free_current_a,
            motion.homing_current_a,
            motion.probing_current_a,
            motion.holding_current_a,
        ] {
            assert!(
                current_a > 0.0 && current_a <= limits.current_a,
                "{}",
                S::NAME
            );
        }
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
        holds_together::<P70>();
        holds_together::<P70Rigid>();
        holds_together::<Tendon2>();
        holds_together::<Tendon2Hall>();
        holds_together::<Tendon3>();
        holds_together::<Linkage3>();
    }

    #[test]
    fn scenes_have_names_of_their_own() {
        let names = [
            P70::NAME,
            P70Rigid::NAME,
            Tendon2::NAME,
            Tendon2Hall::NAME,
            Tendon3::NAME,
            Linkage3::NAME,
        ];
        assert!((1..names.len()).all(|i| !names[..i].contains(&names[i])));
    }
}
