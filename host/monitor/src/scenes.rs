//! The fingers that can be drawn: those of `scenes/`.

use crate::posture::{FingerView, Scales, SceneFinger};
use palpate::finger::Mechanics;
use palpate::scene::Scene;

/// The finger of a scene by its name.
#[must_use]
pub fn finger(scene: &str) -> Option<Box<dyn FingerView>> {
    palpate_scenes::for_scene!(scene, |S| drawn::<S>())
}

fn drawn<S: Scene>() -> Box<dyn FingerView>
where
    S::Finger: 'static,
    <S::Finger as Mechanics>::Configuration: 'static,
{
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let scales = Scales {
        rad_per_count: f64::from(drivetrain.rad_per_count),
        nm_per_a: f64::from(drivetrain.torque_per_ampere_nm),
        efficiency: f64::from(drivetrain.efficiency),
        cable_rad_per_nm: f64::from(S::UNCALIBRATED.cable_rad_per_nm),
    };
    let stop = f64::from(drivetrain.opening_stop_rad);
    Box::new(SceneFinger::new(finger, stop, scales))
}
