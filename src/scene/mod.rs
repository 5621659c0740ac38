//! What a user edits: this finger, this drivetrain, these limits. One file a scene.
//!
//! A scene is a type: what it does not use is not compiled into its firmware. To make your own, copy [`p70`], change its
//! numbers and give it a cargo feature beside the others. The numbers of the simulated scenes are explained in
//! `docs/SCENES.md`.

pub mod linkage3;
pub mod p70;
pub mod re10;
pub mod tendon2;
pub mod tendon3;

use crate::drive::config::Config;
use crate::drive::sequence::Motion;
use crate::finger::{ConfigError, Mechanics};
use crate::sensing::{Calibration, Drivetrain, Settings};

pub use linkage3::Linkage3;
pub use p70::P70;
pub use tendon2::Tendon2;
pub use tendon3::Tendon3;

/// A finger with its drivetrain, its board and its limits.
pub trait Scene {
    /// Name, as logged and as `--scene` takes it.
    const NAME: &'static str;

    /// The finger's mechanics.
    type Finger: Mechanics;

    /// Builds the finger.
    ///
    /// # Errors
    /// The parameter of the scene that is out of its range.
    fn finger() -> Result<Self::Finger, ConfigError>;

    /// Angle of the input link from the opening stop to where a free closing ends, short of the closing stop, radian.
    const TRAVEL_RAD: f32;

    /// Motor, gears, board, limits and trips.
    const DRIVE: Config = re10::DRIVE;

    /// Speeds, currents and times of the motion sequence.
    const MOTION: Motion = re10::motion(Self::TRAVEL_RAD);

    /// What the sensing may assume before anything is calibrated.
    const UNCALIBRATED: Calibration = re10::UNCALIBRATED;

    /// Phalanges; the last one is where a pin calibrates.
    const PHALANGES: u8;

    /// Nominal efficiency of the gears under load, 0 to 1.
    const EFFICIENCY: f32 = re10::EFFICIENCY;

    /// Contact force that holding aims at, newton.
    const HOLD_FORCE_N: f32 = 1.0;

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

#[cfg(all(
    target_os = "none",
    not(any(
        feature = "scene-p70",
        feature = "scene-tendon2",
        feature = "scene-tendon3",
        feature = "scene-linkage3"
    ))
))]
compile_error!("choose a scene: --features scene-p70 (or another scene-... of Cargo.toml)");

#[cfg(any(
    all(
        feature = "scene-p70",
        any(
            feature = "scene-tendon2",
            feature = "scene-tendon3",
            feature = "scene-linkage3"
        )
    ),
    all(
        feature = "scene-tendon2",
        any(feature = "scene-tendon3", feature = "scene-linkage3")
    ),
    all(feature = "scene-tendon3", feature = "scene-linkage3")
))]
compile_error!("choose one scene only: --no-default-features --features scene-...");

/// The scene that this firmware is built for.
#[cfg(feature = "scene-tendon2")]
pub type Active = Tendon2;
/// The scene that this firmware is built for.
#[cfg(feature = "scene-tendon3")]
pub type Active = Tendon3;
/// The scene that this firmware is built for.
#[cfg(feature = "scene-linkage3")]
pub type Active = Linkage3;
/// The scene that this firmware is built for.
#[cfg(not(any(
    feature = "scene-tendon2",
    feature = "scene-tendon3",
    feature = "scene-linkage3"
)))]
pub type Active = P70;

#[cfg(test)]
mod tests {
    use super::*;

    fn holds_together<S: Scene>() {
        let finger = S::finger().expect(S::NAME);
        S::DRIVE.validate().expect(S::NAME);
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
        holds_together::<Tendon2>();
        holds_together::<Tendon3>();
        holds_together::<Linkage3>();
    }

    #[test]
    fn scenes_have_names_of_their_own() {
        let names = [P70::NAME, Tendon2::NAME, Tendon3::NAME, Linkage3::NAME];
        assert!((1..names.len()).all(|i| !names[..i].contains(&names[i])));
    }
}
