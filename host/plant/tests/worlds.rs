//! The named worlds: valid, apart from each other, and different from the firmware's assumptions where they say so.

use palpate_plant::{Engine, Grasp, Parameters, Pins, Plant, Shape, World, scenes, world_names};

fn world(name: &str) -> Parameters {
    World::named(name)
        .and_then(|world| world.of("p70").map_err(|error| error.to_string()))
        .expect(name)
}

#[test]
fn ideal_is_the_default_and_the_others_are_not() {
    assert_eq!(world("ideal"), Parameters::default());
    let names: Vec<_> = world_names().collect();
    for (i, name) in names.iter().enumerate() {
        for other in &names[..i] {
            assert_ne!(world(name), world(other), "{name} {other}");
        }
    }
    let mujoco = World::named("bench@mujoco").expect("known");
    assert_eq!(mujoco.engine, Engine::Mujoco);
    assert!(World::named("bench@other").is_err());
    let error = World::named("nowhere").expect_err("refused");
    assert!(
        error.contains("nowhere") && error.contains("workshop"),
        "{error}"
    );
}

/// Effects that a realistic world must have; each is zero in the ideal one.
fn effects(p: &Parameters) -> Vec<(&'static str, f64)> {
    vec![
        ("wander", p.friction.wander_share),
        ("warming up", p.friction.warm_up_share),
        ("hysteresis", p.transmission.hysteresis_share),
        ("worm error", p.transmission.worm_error_rad),
        ("wheel error", p.transmission.wheel_error_rad),
        ("gear error", p.transmission.gear_error_rad),
        ("random error", p.transmission.random_error_rad),
        ("friction ripple", p.worm.friction_ripple),
        ("stiffening", p.cable.stiffening_per_nm),
        ("slow creep", p.cable.slow_creep_fraction),
        ("preload", p.mechanism.preload_deg),
        ("joint friction", p.mechanism.joint_friction_nm),
        ("contact friction", p.contact.friction),
        ("capstan", p.mechanism.capstan_share),
        ("gravity", p.mechanism.gravity_m_per_s2),
        ("geometry", p.mechanism.geometry_m),
        ("magnets", p.motor.magnet_temperature_coefficient_per_k),
        ("nonlinear sense", p.sense.nonlinearity),
        ("settling", p.sense.settling_s),
        ("dead time", p.bridge.dead_time_s),
        ("encoder", p.encoder.random_error_counts),
    ]
}

#[test]
fn realistic_worlds_have_every_effect_and_draw_it() {
    for (effect, value) in effects(&world("ideal")) {
        assert_eq!(value, 0.0, "{effect}");
    }
    for name in ["bench", "workshop", "harsh"] {
        let nominal = world(name);
        let drawn: Vec<Parameters> = (0..20).map(|seed| nominal.randomised(seed)).collect();
        for (index, (effect, value)) in effects(&nominal).into_iter().enumerate() {
            assert!(value != 0.0, "{name}: {effect}");
            if matches!(effect, "gravity" | "geometry") {
                continue;
            }
            let others: Vec<f64> = drawn.iter().map(|p| effects(p)[index].1).collect();
            assert!(
                others.iter().any(|other| *other != others[0]),
                "{name}: {effect}"
            );
        }
        for p in &drawn {
            p.validate().expect(name);
            assert_ne!(p.finger.coupler_m, nominal.finger.coupler_m);
            assert_ne!(p.mechanism.mounting_deg, nominal.mechanism.mounting_deg);
        }
    }
}

/// A world with a scene's finger.
fn of(name: &str, scene: &str) -> Parameters {
    World::named(name).expect(name).of(scene).expect(scene)
}

/// A user sees ten degrees and weighs a gram; where the scene states no weight there is nothing to set.
#[test]
fn a_user_tells_how_the_finger_hangs_as_well_as_eye_and_scale_do() {
    assert_eq!(of("harsh", "p70").stated_mounting(), None);
    // Level, or nearly.
    for name in ["ideal", "bench"] {
        let (_, share) = of(name, "tendon3").stated_mounting().expect("stated");
        assert_eq!(share, 0.0, "{name}");
    }
    for seed in 0..20 {
        let drawn = of("harsh", "tendon3").randomised(seed);
        let (deg, share) = drawn.stated_mounting().expect("stated");
        let off = (deg - drawn.mechanism.mounting_deg + 180.0).rem_euclid(360.0) - 180.0;
        assert!(
            off.abs() <= 5.0 && (-180.0..=180.0).contains(&deg),
            "{deg} {off}"
        );
        let length_m: f64 = drawn.finger.length_m.iter().sum();
        let stated_kg: f64 = drawn.finger.stated_mass_kg.iter().sum();
        let heavier_kg = drawn.mechanism.linear_density_kg_per_m * length_m - share * stated_kg;
        assert!(heavier_kg.abs() <= 0.51e-3, "{share} {heavier_kg}");
    }
}

/// Drives with a duty for a while.
fn drive(plant: &mut Plant, duty: f64, seconds: f64) {
    let pins = Pins {
        outputs_enabled: true,
        awake: true,
        duty: duty.abs(),
        closing: duty > 0.0,
    };
    for _ in 0..(seconds / 50e-6) as usize {
        plant.step(&pins, 50e-6);
    }
}

#[test]
fn the_finger_closes_onto_an_object_in_every_world_and_mounting() {
    for name in world_names() {
        for mounting_deg in [-90.0, 0.0, 90.0, 180.0] {
            let mut p = world(name);
            p.mechanism.mounting_deg = mounting_deg;
            let shape = Shape::Cylinder { diameter_m: 0.02 };
            let grasp = Grasp::touching(2, 0.035, 0.8, shape);
            let mut plant = Plant::new(&p, &grasp, 3).expect(name);
            drive(&mut plant, 0.35, 8.0);
            let truth = plant.truth();
            let first = truth.first_contact.expect(name);
            assert_eq!(first.contact.phalanx, 2, "{name} {mounting_deg}");
            assert!(
                (first.contact.k_m - 0.035).abs() < 3e-3,
                "{name} {mounting_deg}: {first:?}"
            );
            assert!(truth.torque_nm > 0.1, "{name} {mounting_deg}: {truth:?}");
        }
    }
}

#[test]
fn every_scene_stands_in_every_world() {
    for name in world_names() {
        for scene in scenes() {
            let p = World::named(name).expect(name).of(&scene).expect(&scene);
            Plant::new(&p.randomised(1), &Grasp::Free, 1).expect(&scene);
        }
    }
}

#[test]
fn preload_holds_phalanx_2_until_its_torque_is_reached() {
    let mut p = world("ideal");
    p.mechanism.preload_deg = 5.0;
    let shape = Shape::Cylinder { diameter_m: 0.02 };
    let mut plant = Plant::new(&p, &Grasp::touching(2, 0.035, 0.8, shape), 3).expect("valid");
    let spring = p.finger.spring_nm_per_rad[1];
    let mut moved_at = None;
    for _ in 0..8000 {
        drive(&mut plant, 0.35, 1e-3);
        let truth = plant.truth();
        if moved_at.is_none() && truth.joint_rad[1] > 0.01 {
            moved_at = Some(truth);
        }
    }
    // Before it moves, what the contact and the linkage pass on to joint 2 is less than the preload.
    let truth = moved_at.expect("it moves in the end");
    let preload_nm = spring * 5.0f64.to_radians();
    assert!(truth.torque_nm > preload_nm, "{truth:?}");
    assert!(truth.contacts.iter().any(|contact| contact.phalanx == 2));
}

/// A user knows the kind of skin, not its coefficient, and sets the manual's value for it; the true one lies elsewhere in its range.
#[test]
fn a_user_states_the_skin_by_the_manuals_table() {
    let manual = include_str!("../../../docs/MANUAL.md");
    let row = |skin: &str| {
        let start = format!("| {skin}");
        let line = manual.lines().find(|line| line.starts_with(&start));
        let cells: Vec<_> = line.expect(skin).split('|').map(str::trim).collect();
        let (least, most) = cells[3].split_once(" to ").expect(skin);
        [cells[2], least, most.trim_end_matches(" %")].map(|cell| cell.parse::<f64>().expect(skin))
    };
    for (name, skin) in [("workshop", "plain plastics"), ("harsh", "rubber")] {
        let contact = world(name).contact;
        let truth = 100.0 * contact.friction;
        let [stated, least, most] = row(skin);
        assert_eq!(contact.stated(), Some(stated / 100.0), "{name}");
        assert!((least..=most).contains(&truth), "{name}: {truth}");
        assert_ne!(truth, stated, "{name}");
    }
    assert_eq!(world("ideal").contact.stated(), None);
}

/// What a scene has no cable for is drawn without one.
#[test]
fn a_finger_without_a_cable_is_drawn_with_its_shaft() {
    for world in ["ideal", "workshop", "harsh"] {
        let nominal = of(world, "p70-rigid");
        let cabled = of(world, "p70");
        for seed in 0..5 {
            let cable = nominal.randomised(seed).cable;
            assert_eq!(
                (cable.stiffness_n_per_m, cable.creep_fraction),
                (nominal.cable.stiffness_n_per_m, 0.0)
            );
            let drawn = cabled.randomised(seed).cable;
            assert!((1.5e3..=10e3).contains(&drawn.stiffness_n_per_m));
        }
    }
}
