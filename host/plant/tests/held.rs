//! Joints that motors of their own hold: the spring behind the worm's backlash, against statics written out here.

use palpate_plant::{
    CableEnd, Grasp, Mechanics, Parameters, Plant, Quasistatic, Shape, World, world_names,
};

const CABLE_NM_PER_RAD: f64 = 1.2;

/// Rests joint 1's wheel at an angle.
fn at(finger: &mut Quasistatic, rad: f64) {
    let end = CableEnd {
        low_rad: rad,
        high_rad: rad,
        stiffness_nm_per_rad: CABLE_NM_PER_RAD,
    };
    for _ in 0..4000 {
        finger.step(&end, 1e-4);
    }
}

/// A point on phalanx 2 pushes joint 2 open: freely to the flank, then against the spring; joint 1 carries the moment of the same
/// force.
#[test]
fn a_contact_bends_the_held_joint_against_its_spring_beyond_the_backlash() {
    let mut parameters = Parameters::of("direct2").expect("a scene");
    parameters.finger.held_backlash_deg = vec![2.0];
    let [l_1, _] = parameters.finger.length_m[..] else {
        panic!("two phalanges")
    };
    let spring = parameters.finger.spring_nm_per_rad[1];
    let rest = parameters.finger.rest_deg[1].to_radians();
    let flank = rest - 1f64.to_radians();
    let mut finger = Quasistatic::new(&parameters).expect("valid");
    let point = Shape::Cylinder { diameter_m: 2e-3 };
    finger
        .place(&Grasp::touching(2, 0.04, 0.8, point))
        .expect("clear of the open finger");
    let (mut loaded, mut idle) = (0, 0);
    for step in 0..60 {
        at(&mut finger, 0.79 + 0.002 * f64::from(step));
        let state = finger.state();
        let bent = state.joint_rad[1];
        let [moment_1, moment_2] = state.contacts.first().map_or([0.0; 2], |contact| {
            let arms = [contact.k_m + l_1 * bent.cos(), contact.k_m];
            arms.map(|arm| contact.force_n * arm)
        });
        // Between the flanks nothing holds joint 2, and a contact has no force.
        let held = spring * (flank - bent).max(0.0);
        assert!(
            (moment_2 - held).abs() < 1e-5 + 1e-3 * held,
            "{moment_2} {bent}"
        );
        let torque = state.torque_nm;
        assert!(
            (moment_1 - torque).abs() < 1e-5 + 1e-3 * torque,
            "{state:?}"
        );
        loaded += u32::from(bent < flank);
        idle += u32::from((flank..rest - 1e-3).contains(&bent));
    }
    assert!(loaded > 15 && idle > 0, "{loaded} {idle}");
}

/// A drawn finger is held near where the scene says, with another backlash; a world draws nothing else for it.
#[test]
fn drawn_fingers_are_held_elsewhere() {
    for name in world_names() {
        let nominal = World::named(name)
            .expect(name)
            .of("direct2")
            .expect("a scene");
        let drawn = nominal.randomised(3);
        let off = drawn.finger.rest_deg[1] - nominal.finger.rest_deg[1];
        assert!(off != 0.0 && off.abs() <= 0.5, "{off}");
        let play = drawn.finger.held_backlash_deg[0] / nominal.finger.held_backlash_deg[0];
        assert!(play != 1.0 && (play - 1.0).abs() <= 0.3, "{play}");
        Plant::new(&drawn, &Grasp::Free, 1).expect("valid");
    }
}
