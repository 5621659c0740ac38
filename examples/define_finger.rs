//! Define a finger from its dimensions, and see what it can feel: `cargo run --example define_finger`.

use palpate::finger::{Assembly, Finger, Levers, Linkage, Mechanics, Parameters, Springless};

/// Two phalanges of 80 and 60 mm behind a linkage, without a spring at joint 1: a constant, checked by the compiler.
const FINGER: Finger<2, Linkage<1>, Springless> =
    match Finger::<2, Linkage<1>, Springless>::constant(
        Parameters {
            lengths_m: [0.080, 0.060],
            stiffness_nm_per_rad: [0.0, 0.05],
            rest_rad: [0.0, 0.0],
            range_rad: [[-0.5, 2.6], [0.0, 2.0]],
        },
        [LEVERS],
    ) {
        Ok(finger) => finger,
        Err(error) => panic!("{}", error.what()),
    };

const LEVERS: Levers = Levers {
    driving_m: 0.053,
    coupler_m: 0.092,
    driven_m: 0.027,
    offset_rad: 120.0_f32.to_radians(),
    assembly: Assembly::Clockwise,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The same from values that are only known when the program runs; a value out of range is an error that names it.
    let open = Levers {
        coupler_m: 0.2,
        ..LEVERS
    };
    match Finger::<2, Linkage<1>>::new(*FINGER.parameters(), [open]) {
        Ok(_) => println!("a coupler of 200 mm closes"),
        Err(error) => println!("a coupler of 200 mm: {error}"),
    }
    let at = FINGER.configuration([0.8, 0.0])?;
    println!("stiffness at contact, by its place on the second phalanx:");
    for k_mm in [10.0, 20.0, 30.0, 40.0, 50.0] {
        match FINGER.contact_compliance(&at, 0.0, 2, 1e-3 * k_mm) {
            Some(compliance) => println!("  {k_mm:4.0} mm: {:.3} N m/rad", 1.0 / compliance),
            None => println!("  {k_mm:4.0} mm: the finger is not stable there"),
        }
    }
    Ok(())
}
