//! Where a contact is, from three numbers: posture, torque and measured stiffness: `cargo run --example locate_contact`.

use palpate::finger::{Finger, Parameters, Tendon};
use palpate::sensing::Cable;
use palpate::sensing::location::places;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let finger: Finger<2, Tendon<2>> = Finger::new(
        Parameters {
            lengths_m: [0.090, 0.0675],
            stiffness_nm_per_rad: [0.1, 0.1],
            rest_rad: [0.52, 0.52],
            range_rad: [[-0.5, 2.6], [-0.5, 2.0]],
        },
        [0.009, 0.0072],
    )?;
    // The finger closed freely to this posture, and there it became stiffer: something is in the way.
    let (joints_rad, torque_nm) = ([1.6, 0.6], 0.11);
    let at = finger.configuration(joints_rad)?;
    // Between motor and finger lies a cable; its twist is part of what was measured.
    let cable = Cable::new(1.2)?;
    let measured_nm_per_rad = 0.45;

    println!("measured {measured_nm_per_rad} N m/rad at the input link");
    let found = places(
        &finger,
        &at,
        torque_nm,
        1.0 / measured_nm_per_rad,
        &cable,
        None,
    );
    for place in found.candidates() {
        println!(
            "  phalanx {}, {:.1} mm from its joint",
            place.phalanx,
            1e3 * place.k_m
        );
    }
    Ok(())
}
