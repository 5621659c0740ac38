//! Finger, object and parameters against physics and against bad input.

mod support;

use palpate_plant::{Error, Grasp, Parameters, Pins, Plant, Shape, World};
use support::{cylinder, drive, quiet, run, scene};

#[test]
fn grasp_stays_when_the_motor_is_off() {
    let mut p = quiet();
    p.cable.creep_fraction = 0.0;
    let grasp = Grasp::touching(2, 0.03, 0.8, cylinder(0.01));
    let mut plant = Plant::new(&p, &grasp, 3).unwrap();
    run(&mut plant, &drive(0.4), 4.0);
    run(&mut plant, &Pins::default(), 0.5);
    let (count, held) = (plant.encoder_count(), plant.truth().torque_nm);
    assert!(held > 0.05, "{held} N m");
    run(&mut plant, &Pins::default(), 2.0);
    assert_eq!(plant.encoder_count(), count);
    assert!((plant.truth().torque_nm / held - 1.0).abs() < 1e-6);
}

#[test]
fn same_seed_same_world_other_seed_other_noise() {
    let p = Parameters::default();
    let make = |seed| {
        let grasp = Grasp::touching(2, 0.045, 0.8, cylinder(0.01));
        let mut plant = Plant::new(&p, &grasp, seed).unwrap();
        let mut seen = Vec::new();
        for _ in 0..2000 {
            run(&mut plant, &drive(0.5), 1e-3);
            seen.push((
                plant.encoder_count(),
                plant.current_sense_v().to_bits(),
                plant.hall_v().to_bits(),
            ));
        }
        (seen, plant.truth())
    };
    assert_eq!(make(7), make(7));
    assert_ne!(make(7).0, make(8).0);
}

/// The object is met where it was asked for, thick phalanges and all, whatever its size.
#[test]
fn contact_begins_where_it_was_asked_for() {
    for (name, tolerance) in [("p70", 1e-4), ("tendon2", 1e-4), ("linkage3", 1e-4)] {
        for shape in [
            cylinder(0.004),
            cylinder(0.04),
            Shape::square(0.02, 45.0),
            Shape::square(0.02, 20.0),
        ] {
            for (phalanx, k_m) in [(1, 0.05), (2, 0.015), (2, 0.03), (2, 0.06)] {
                let grasp = Grasp::touching(phalanx, k_m, 0.8, shape.clone());
                let mut plant = Plant::new(&scene(name), &grasp, 3).unwrap();
                let first = loop {
                    run(&mut plant, &drive(0.3), 1e-3);
                    assert!(
                        plant.time_s() < 6.0,
                        "{name} {shape:?} {k_m}: never touched"
                    );
                    if let Some(first) = plant.truth().first_contact {
                        break first;
                    }
                };
                assert_eq!(first.contact.phalanx, phalanx, "{name} {shape:?}");
                assert!(
                    (first.contact.k_m - k_m).abs() < tolerance,
                    "{name} {shape:?}: {first:?}"
                );
                assert!((first.joint_rad[0] - 0.8).abs() < 2e-3, "{first:?}");
                assert!(!first.contact.back);
            }
        }
    }
}

#[test]
fn flush_wall_touches_at_joint_and_tip() {
    let grasp = Grasp::touching(2, 0.035, 0.8, Shape::plane());
    let mut plant = Plant::new(&quiet(), &grasp, 3).unwrap();
    run(&mut plant, &drive(0.4), 4.0);
    let tips_m = quiet().finger.length_m;
    let contacts = plant.truth().contacts;
    assert!(contacts.iter().any(|c| c.force_n > 0.1), "{contacts:?}");
    assert!(
        contacts
            .iter()
            .all(|c| c.k_m < 1e-3 || c.k_m > tips_m[usize::from(c.phalanx) - 1] - 1e-4),
        "{contacts:?}"
    );
}

#[test]
fn contact_may_lie_on_the_back() {
    let mut plant = Plant::new(&scene("tendon2"), &Grasp::Free, 3).unwrap();
    run(&mut plant, &drive(0.5), 2.0);
    assert!(plant.truth().joint_rad[0] > 0.9);
    // Between the opening finger and its rest pose (phalanx 1 at 30 deg), 80 mm out.
    let (sin, cos) = 0.65f64.sin_cos();
    plant
        .place(&Grasp::At {
            origin_m: [0.08 * cos, 0.08 * sin],
            angle_rad: 0.0,
            shape: cylinder(0.01),
        })
        .unwrap();
    run(&mut plant, &drive(-0.5), 3.0);
    let first = plant.truth().first_contact.unwrap();
    assert!(
        first.contact.back && first.contact.phalanx == 1,
        "{first:?}"
    );
}

#[test]
fn friction_at_the_contact_holds_back() {
    let slid = |friction| {
        let mut p = quiet();
        p.contact.friction = friction;
        let grasp = Grasp::touching(2, 0.03, 0.8, cylinder(0.01));
        let mut plant = Plant::new(&p, &grasp, 3).unwrap();
        run(&mut plant, &drive(0.4), 4.0);
        let truth = plant.truth();
        truth.strongest().unwrap().k_m - truth.first_contact.unwrap().contact.k_m
    };
    let (free, rubbing) = (slid(0.0), slid(0.3));
    assert!(free > 1e-3 && rubbing < free, "{free} {rubbing} m");
}

#[test]
fn missing_stop_lets_the_finger_run_on() {
    let angle = |missing| {
        let mut plant = Plant::new(&quiet(), &Grasp::Free, 3).unwrap();
        plant.faults.stops_missing = missing;
        run(&mut plant, &drive(0.8), 3.0);
        plant.truth().theta_a_rad
    };
    assert!((angle(false) - 1.6).abs() < 0.01);
    assert!(angle(true) > 2.0);
}

#[test]
fn random_plants_are_valid_and_their_own() {
    let base = Parameters::default();
    assert_eq!(base.randomised(1), base.randomised(1));
    for seed in 0..200 {
        let p = base.randomised(seed);
        p.validate().unwrap();
        assert_ne!(p, base.randomised(seed + 1));
        assert!((1.5e3..=10e3).contains(&p.cable.stiffness_n_per_m));
        assert!((0.03e-3..=0.15e-3).contains(&p.gearhead.drag_nm));
    }
}

#[test]
fn a_file_may_be_partial() {
    let p =
        Parameters::from_toml("motor.resistance_ohm = 30\n[finger]\nspring_nm_per_rad = [0, 0.07]")
            .unwrap();
    assert_eq!(
        (p.motor.resistance_ohm, p.finger.spring_nm_per_rad[1]),
        (30.0, 0.07)
    );
    assert_eq!(
        p.motor.torque_constant_nm_per_a,
        Parameters::default().motor.torque_constant_nm_per_a
    );
}

/// What the default scene's finger does not have is no mistake in a world for another one.
#[test]
fn a_world_with_a_finger_fits_its_own_scene_only() {
    for (scene, text) in [
        ("tendon3", "[finger]\nlength_m = [0.091, 0.0675, 0.045]"),
        ("tendon2", "[finger]\npulley_m = [0.009, 0.0061]"),
    ] {
        let world = World::from_toml(text).expect(text);
        assert!(world.of(scene).is_ok(), "{scene}: {:?}", world.of(scene));
        assert!(world.of("p70").is_err(), "{scene}");
    }
    assert!(World::from_toml("[finger]\nlenght_m = [0.09, 0.07]").is_err());
}

#[test]
fn a_bad_file_is_told_what_is_wrong() {
    let error = |text: &str| Parameters::from_toml(text).expect_err(text);
    let unknown = error("[motor]\nresistence_ohm = 3");
    assert!(matches!(&unknown, Error::UnknownKey { key, .. } if key == "motor.resistence_ohm"));
    assert!(unknown.to_string().contains("resistance_ohm"), "{unknown}");
    let range = error("[gearhead]\nefficiency = 1.2").to_string();
    assert!(
        range.contains("gearhead.efficiency")
            && range.contains("1.2")
            && range.contains("0.1 to 1"),
        "{range}"
    );
    assert!(matches!(
        error("motor.resistance_ohm = nan"),
        Error::OutOfRange { .. }
    ));
    assert!(matches!(
        error("motor.resistance_ohm = inf"),
        Error::OutOfRange { .. }
    ));
    assert!(matches!(
        error("motor.resistance_ohm = \"big\""),
        Error::WrongType { .. }
    ));
    assert!(matches!(error("motor = 3"), Error::WrongType { .. }));
    assert!(matches!(error("[motor"), Error::Syntax(_)));
    assert!(matches!(
        error("finger.length_m = [0.09]"),
        Error::WrongLength { expected: 2, .. }
    ));
    assert!(matches!(
        error("finger.length_m = [0.09, true]"),
        Error::WrongType { .. }
    ));
    assert!(matches!(
        error("finger.mode = [0]"),
        Error::OutOfRange { .. }
    ));
    assert!(matches!(
        error("finger.coupler_m = [0.3]"),
        Error::Open { .. }
    ));
    assert!(matches!(
        error("finger.pulley_m = [0.1, 0.1]"),
        Error::Transmission { .. }
    ));
}

#[test]
fn an_object_that_cannot_be_there_is_refused() {
    let p = Parameters::default();
    let place = |grasp| Plant::new(&p, &grasp, 1).expect_err("refused");
    for grasp in [
        Grasp::touching(3, 0.03, 0.8, cylinder(0.01)),
        Grasp::touching(0, 0.03, 0.8, cylinder(0.01)),
        Grasp::touching(2, 0.08, 0.8, cylinder(0.01)),
        Grasp::touching(2, f64::NAN, 0.8, cylinder(0.01)),
        Grasp::touching(2, 0.03, 3.0, cylinder(0.01)),
        Grasp::touching(2, 0.03, 0.8, cylinder(-0.01)),
        Grasp::touching(
            2,
            0.03,
            0.8,
            Shape::Polygon {
                corners_m: vec![[0.0, 0.0], [0.0, 0.1], [0.1, 0.0]],
            },
        ),
        Grasp::At {
            origin_m: [0.05, 0.0],
            angle_rad: 0.0,
            shape: cylinder(0.01),
        },
        Grasp::At {
            origin_m: [f64::NAN, 0.0],
            angle_rad: 0.0,
            shape: cylinder(0.01),
        },
    ] {
        assert!(
            matches!(place(grasp.clone()), Error::Contact(_)),
            "{grasp:?}"
        );
    }
}

/// The step of the integration does not show in what it integrates.
#[test]
fn shorter_steps_give_the_same_motion() {
    let angles = |dt: f64| {
        let grasp = Grasp::touching(2, 0.03, 0.6, cylinder(0.02));
        let mut plant = Plant::new(&quiet(), &grasp, 3).unwrap();
        let mut seen = Vec::new();
        for _ in 0..30 {
            for _ in 0..(0.1 / dt).round() as u64 {
                plant.step(&drive(0.4), dt);
            }
            let truth = plant.truth();
            seen.push((truth.theta_a_rad, truth.torque_nm));
        }
        (seen, plant.truth().first_contact.unwrap().contact.k_m)
    };
    let (coarse, coarse_k) = angles(50e-6);
    let (fine, fine_k) = angles(5e-6);
    for (i, (c, f)) in coarse.iter().zip(&fine).enumerate() {
        assert!(
            (c.0 - f.0).abs() < 5e-4 && (c.1 - f.1).abs() < 5e-4,
            "{i}: {c:?} {f:?}"
        );
    }
    assert!((coarse_k - fine_k).abs() < 1e-6);
}
