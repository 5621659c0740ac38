//! What the plant's finger cannot be asked for: objects on springs and free ones; and contacts that slide with friction.

use palpate_mujoco::{Mount, MujocoFinger, Surroundings};
use palpate_plant::{CableEnd, Engine, Grasp, Mechanics, Parameters, Shape, World};

const CYLINDER: Shape = Shape::Cylinder { diameter_m: 0.020 };

/// The cable's end without backlash.
fn cable_end(parameters: &Parameters, rad: f64) -> CableEnd {
    CableEnd {
        low_rad: rad,
        high_rad: rad,
        stiffness_nm_per_rad: parameters.cable_stiffness_nm_per_rad(),
    }
}

/// Closes on a cylinder that is held in some way, in gravity or without.
fn closed_on(mount: Mount, gravity_m_per_s2: f64, end_rad: f64, held_steps: u32) -> MujocoFinger {
    let mut parameters = Parameters::default();
    let mechanism = &mut parameters.mechanism;
    (mechanism.gravity_m_per_s2, mechanism.mounting_deg) = (gravity_m_per_s2, 90.0);
    let surroundings = Surroundings {
        mount,
        object_kg: 0.05,
    };
    let mut finger = MujocoFinger::new(&parameters, &surroundings).expect("a valid model");
    let end = |rad: f64| cable_end(&parameters, rad);
    let grasp = Grasp::touching(2, 0.04, 0.8, CYLINDER);
    finger.settle(&end(0.05));
    finger.place(&grasp).expect("clear of the open finger");
    let steps = 20_000;
    for step in 0..steps {
        finger.step(&end(end_rad * f64::from(step) / f64::from(steps)), 50e-6);
    }
    for _ in 0..held_steps {
        finger.step(&end(end_rad), 50e-6);
    }
    finger
}

#[test]
fn a_world_file_says_how_the_object_is_held() {
    let held = |mount: &str, engine| {
        let mut world = World::from_toml(&format!("[object]\nmount = \"{mount}\"\nmass_kg = 0.2"))?;
        world.engine = engine;
        let parameters = world.of("p70")?;
        let surroundings = Surroundings::from(&parameters.object);
        palpate_mujoco::plant(&parameters, &Grasp::Free, 1).map(|_| surroundings)
    };
    let spring = held("spring", Engine::Mujoco).expect("a valid world");
    assert_eq!(spring.object_kg, 0.2);
    assert!(matches!(spring.mount, Mount::Spring { .. }));
    let free = held("free", Engine::Mujoco).expect("a valid world");
    assert_eq!(free.mount, Mount::Free);
    assert!(held("fixed", Engine::Plant).is_ok());
    let refused = held("free", Engine::Plant)
        .expect_err("fixed only")
        .to_string();
    assert!(
        refused.contains("object.mount") && refused.contains("mujoco"),
        "{refused}"
    );
    let unknown = held("hung", Engine::Mujoco)
        .expect_err("no such")
        .to_string();
    assert!(
        unknown.contains("hung") && unknown.contains("spring"),
        "{unknown}"
    );
}

#[test]
fn an_object_on_springs_yields_by_what_they_say() {
    let mut last: Option<(f64, f64)> = None;
    for stiffness_n_per_m in [200.0, 2000.0, 1e7] {
        let mount = Mount::Spring {
            stiffness_n_per_m,
            damping_n_s_per_m: 5.0,
        };
        let finger = closed_on(mount, 0.0, 0.95, 40_000);
        let force = finger
            .state()
            .contacts
            .iter()
            .map(|c| c.force_n)
            .sum::<f64>();
        let moved = finger
            .object_m()
            .expect("an object")
            .map(|part| part * stiffness_n_per_m);
        assert!(
            (moved[0].hypot(moved[1]) / force - 1.0).abs() < 0.02,
            "{moved:?} N, {force} N"
        );
        if let Some((softer, force_then)) = last {
            assert!(softer < stiffness_n_per_m && force > force_then);
        }
        last = Some((stiffness_n_per_m, force));
    }
}

#[test]
fn a_free_object_is_pushed_away_and_falls() {
    let finger = closed_on(Mount::Free, 0.0, 1.2, 0);
    assert!(finger.object_m().is_some_and(|[x, y]| x.hypot(y) > 0.01));
    let falling = closed_on(Mount::Free, 9.81, 0.05, 0);
    let [x, y] = falling.object_m().expect("an object");
    // A second of fall along the mounting's direction.
    assert!((y - 0.5 * 9.81).abs() < 0.01 && x.abs() < 1e-6, "{x} {y}");
}

#[test]
fn a_sliding_contact_with_friction_stays_in_touch() {
    let mut parameters = Parameters::default();
    parameters.mechanism.joint_friction_nm = 0.3e-3;
    let mut force_n = Vec::new();
    for friction in [0.0, 0.2, 0.4] {
        parameters.contact.friction = friction;
        let mut finger =
            MujocoFinger::new(&parameters, &Surroundings::default()).expect("a valid model");
        let end = |rad: f64| cable_end(&parameters, rad);
        finger.settle(&end(0.06));
        finger
            .place(&Grasp::touching(
                2,
                0.03,
                0.785,
                Shape::Cylinder { diameter_m: 0.010 },
            ))
            .expect("clear of the open finger");
        let steps = 60_000;
        for step in 0..steps {
            let at = 0.06 + 1.05 * f64::from(step) / f64::from(steps);
            finger.step(&end(at), 50e-6);
            // Past the impact.
            let touches = finger.state().contacts.len();
            assert!(
                at < 0.83 || touches == 1,
                "friction {friction}, end at {at} rad"
            );
        }
        force_n.push(finger.state().contacts[0].force_n);
    }
    // The contact slides towards the tip and friction holds it back: more force at the same place of the motor.
    assert!(force_n.is_sorted(), "{force_n:?}");
}
