//! The scenes of the library are the fingers and drivetrains of the plant.

use palpate::finger::{Mechanics, Mounting};
use palpate_plant::Parameters;
use palpate_simulation::Simulated;

fn close(name: &str, library: f32, plant: f64) {
    let error = (f64::from(library) - plant).abs();
    assert!(
        error <= 1e-5 * plant.abs() + 1e-6,
        "{name}: library {library}, plant {plant}"
    );
}

fn mirrors<S: Simulated>() {
    let plant = Parameters::of(S::NAME).expect(S::NAME);
    // As in the default world, whose plane is level.
    let finger = S::MECHANISM.mounted(Mounting::LEVEL);
    let drivetrain = S::drivetrain(&finger);
    let geometry = &plant.finger;

    for (phalanx, &length_m) in (1u8..).zip(&geometry.length_m) {
        let length = finger.phalanx_length_m(phalanx).expect("phalanx");
        close("length", length, length_m);
    }
    assert_eq!(
        finger.phalanx_length_m(geometry.length_m.len() as u8 + 1),
        None
    );
    let unsprung = geometry.spring_nm_per_rad[0] == 0.0;
    let mut preload_nm = 0.0f64;
    let stops_deg = geometry.joint_min_deg.iter();
    let springs = &geometry.spring_nm_per_rad;
    for ((joint, &rest_deg), (stop_deg, spring)) in
        (1u8..).zip(&geometry.rest_deg).zip(stops_deg.zip(springs))
    {
        let without = joint == 1 && unsprung && geometry.return_pulley_m.is_empty();
        let rest_rad = if without {
            0.0
        } else {
            // A spring at rest beyond its stop is preloaded by it.
            preload_nm = preload_nm.max(spring * (stop_deg - rest_deg).to_radians());
            rest_deg.max(*stop_deg).to_radians()
        };
        let rest = finger.joint_rad(&finger.rest(), joint).expect("joint");
        close("rest angle", rest, rest_rad);
    }
    close("preload", finger.preload_nm(), preload_nm);
    if let [radius_m, _] = *geometry.return_pulley_m {
        let turned_rad = 0.8;
        let free = (finger.free_at_angle(turned_rad as f32, &finger.rest())).expect("a posture");
        let pull_n = geometry.return_tension_n + geometry.return_n_per_m * radius_m * turned_rad;
        close("return cable", free.torque_nm, radius_m * pull_n);
    }
    // The free closing ends short of the closing stop, and uses most of the way.
    assert!((0.9 * geometry.travel_rad..geometry.travel_rad).contains(&f64::from(S::TRAVEL_RAD)));
    // The stop that the plant has, at the angle that the library gives it.
    let world = palpate_plant::Plant::new(&plant, &palpate_plant::Grasp::Free, 1).expect(S::NAME);
    close(
        "opening stop",
        drivetrain.opening_stop_rad,
        world.truth().opening_stop_rad,
    );

    close(
        "counts",
        1.0 / drivetrain.rad_per_count,
        plant.counts_per_rad(),
    );
    let torque_nm = plant.ratio() * plant.motor.torque_constant_nm_per_a;
    close(
        "torque per ampere",
        drivetrain.torque_per_ampere_nm,
        torque_nm,
    );
    let inertia_kg_m2 = plant.motor.rotor_inertia_kg_m2 * plant.ratio() * plant.ratio();
    close("inertia", drivetrain.inertia_kg_m2, inertia_kg_m2);
    // Nominal and an upper limit, not copies.
    let efficiency = plant.gearhead.efficiency
        * palpate_plant::worm_efficiency(&plant, f64::from(S::MOTION.closing_rad_per_s));
    assert!(
        (f64::from(drivetrain.efficiency) / efficiency - 1.0).abs() < 0.1,
        "{efficiency}"
    );
    let backlash_rad =
        (plant.gearhead.backlash_counts + plant.worm.backlash_counts) / plant.counts_per_rad();
    assert!(f64::from(drivetrain.backlash_rad) >= backlash_rad);

    let (motor, sense) = (S::DRIVE.motor, S::DRIVE.sense);
    close(
        "torque constant",
        motor.torque_constant_nm_per_a,
        plant.motor.torque_constant_nm_per_a,
    );
    close(
        "resistance",
        motor.resistance_ohm,
        plant.motor.resistance_ohm,
    );
    close(
        "sense",
        sense.volt_per_a,
        if sense.signed {
            plant.sense.shunt_v_per_a
        } else {
            plant.sense.resistor_ohm * plant.sense.mirror_a_per_a
        },
    );
    close(
        "sense at no current",
        sense.zero_v,
        plant.sense.shunt_zero_v,
    );
    close("divider", sense.supply_divider, 1.0 / plant.supply.divider);
    let angle = S::ANGLE_SENSOR;
    close("zero of joint 2", angle.zero_v, plant.hall.zero_v);
    close(
        "volt a radian of joint 2",
        angle.volt_per_rad,
        plant.hall.sensitivity_v_per_rad,
    );
}

#[test]
fn scenes_mirror_the_plant() {
    palpate_scenes::for_each_scene!(|S| mirrors::<S>());
}
