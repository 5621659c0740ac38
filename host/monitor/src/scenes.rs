//! The fingers that can be drawn.

use palpate::finger::Mechanics;
use palpate::scene::{Linkage3, P70, P70Rigid, Scene, Tendon2, Tendon2Hall, Tendon3};
use palpate_monitor::posture::{Drawn, SceneFinger};

/// The finger of a scene by its name.
pub fn finger(scene: &str) -> Option<Box<dyn Drawn>> {
    Some(match scene {
        "p70" => drawn::<P70>(),
        "p70-rigid" => drawn::<P70Rigid>(),
        "tendon2" => drawn::<Tendon2>(),
        "tendon2-hall" => drawn::<Tendon2Hall>(),
        "tendon3" => drawn::<Tendon3>(),
        "linkage3" => drawn::<Linkage3>(),
        _ => return None,
    })
}

fn drawn<S: Scene>() -> Box<dyn Drawn>
where
    S::Finger: 'static,
    <S::Finger as Mechanics>::Configuration: 'static,
{
    let finger = S::MECHANISM;
    let drivetrain = S::drivetrain(&finger);
    let scales = (
        f64::from(drivetrain.rad_per_count),
        f64::from(drivetrain.torque_per_ampere_nm),
    );
    let stop = f64::from(drivetrain.opening_stop_rad);
    Box::new(SceneFinger::new(finger, stop, scales))
}
