//! How fast the plant runs on one core: closing on a cylinder, one step a control period.

use palpate_plant::{Grasp, Parameters, Pins, Plant, Shape};
use std::time::Instant;

fn main() -> Result<(), palpate_plant::Error> {
    for scene in palpate_plant::scenes() {
        let theta_1 = if scene.starts_with("p70") { 0.5 } else { 0.8 };
        for (name, shape) in [
            ("cylinder", Shape::Cylinder { diameter_m: 0.01 }),
            ("square", Shape::square(0.02, 45.0)),
        ] {
            let mut plant = Plant::new(
                &Parameters::of(&scene)?,
                &Grasp::touching(2, 0.03, theta_1, shape),
                1,
            )?;
            let pins = Pins::closing(0.5);
            let start = Instant::now();
            for _ in 0..60_000 {
                plant.step(&pins, 50e-6);
            }
            let wall = start.elapsed().as_secs_f64();
            let truth = plant.truth();
            println!(
                "{scene} {name}: {:.0} times real time; theta_a {:.3} rad, torque {:.3} N m, current {:.1} mA, joints {:.2?} rad, contacts {:?}, first {:?}",
                plant.time_s() / wall,
                truth.theta_a_rad,
                truth.torque_nm,
                1e3 * truth.motor_current_a,
                truth.joint_rad,
                truth.contacts,
                truth.first_contact.map(|f| (
                    f.time_s,
                    f.contact.phalanx,
                    f.contact.k_m,
                    f.joint_rad
                )),
            );
        }
    }
    Ok(())
}
