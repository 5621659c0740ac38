//! The reference finger that is held at two contacts next to the simulated plant, which shares no code with it.

use palpate_evaluation::bound::opened;
use palpate_evaluation::reference::{Drive, HeldTwice, Rubs, Touching};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::{Linkage3, Tendon3};
use palpate_simulation::second_contacts::Grasping;
use palpate_simulation::{Simulated, Simulation};

/// Torque of the plant at the input link next to that of the reference at the same angles, after a second contact: the largest
/// difference and how far the torque rises meanwhile, newton metre, and how far the second contacts are apart, metre. The reference
/// may be told that nothing rubs.
fn compared<S: Simulated>(parameters: &Parameters, is_smooth: bool) -> [f64; 3] {
    let (phalanx, k_m, radius_m) = (2, 0.045, 0.03);
    let shape = Shape::Cylinder {
        diameter_m: 2.0 * radius_m,
    };
    let grasp = Grasp::touching(phalanx, k_m, 0.8, shape);
    let mut simulation = Simulation::<S>::new(parameters, 1).expect("a finger");
    simulation.prepare().expect("a record");
    simulation.traced = true;
    let mut began = None;
    let outcome = simulation
        .close_while(&grasp, |plant, _| {
            let truth = plant.truth();
            let other = truth.contacts.iter().find(|one| one.phalanx != phalanx);
            began = began.or(other.copied());
        })
        .expect("it closes");
    let first = outcome.first_contact.expect("a contact");
    let second = began.expect("a second contact");
    assert_eq!(first.contact.phalanx, phalanx);

    let opened = opened(&parameters.finger);
    let mechanism = &parameters.mechanism;
    let rubs = if is_smooth {
        Rubs::default()
    } else {
        Rubs {
            friction: parameters.contact.friction,
            joint_nm: mechanism.joint_friction_nm,
            loss: if parameters.finger.pulley_m.is_empty() {
                0.0
            } else {
                mechanism.capstan_share
            },
            uneven: [0.0; 2],
        }
    };
    let rigid = Drive {
        factor: 1.0,
        cable_rad_per_nm: 0.0,
        stiffening_per_nm: 0.0,
    };
    let half_m = parameters.mechanism.phalanx_half_thickness_m;
    let touching = |phalanx: u8, k_m: f64| Touching {
        phalanx: phalanx.into(),
        k_m,
        radius_m: radius_m + half_m,
    };
    let mut held =
        HeldTwice::new(&opened, rubs, half_m, rigid, first.theta_a_rad).expect("it closes");
    held.touch(&touching(phalanx, first.contact.k_m));
    let mut found = None;
    let (mut most_nm, mut from_nm, mut to_nm) = (0.0_f64, f64::INFINITY, 0.0_f64);
    let mut last_rad = first.theta_a_rad;
    for row in &outcome.trace {
        let angle_rad = row.true_theta_a_rad;
        // Steps of a hundredth of the way, forwards.
        if row.true_pressing == 0 || angle_rad < last_rad + 2e-3 {
            continue;
        }
        last_rad = angle_rad;
        assert!(held.close_to(angle_rad), "{angle_rad}");
        let other = usize::from(second.phalanx);
        if found.is_none() {
            let [gap_m, along_m] = held.gap_m(other).expect("a first contact");
            if gap_m > 0.0 {
                continue;
            }
            found = Some(along_m);
            held.touch(&touching(second.phalanx, along_m));
        } else if row.true_pressing.count_ones() == 2 {
            let off_nm = row.true_torque_nm - held.now().torque_nm;
            most_nm = most_nm.max(off_nm.abs());
            from_nm = from_nm.min(row.true_torque_nm);
            to_nm = to_nm.max(row.true_torque_nm);
        }
    }
    let along_m = found.expect("the reference has a second contact too");
    [most_nm, to_nm - from_nm, (along_m - second.k_m).abs()]
}

/// The plant's joints are damped as well, and its objects yield a little.
#[test]
fn two_contacts_show_the_torque_of_the_plant() {
    for rubs in [false, true] {
        let of = |scene: &str| {
            let mut parameters = Parameters::of(scene).expect("a scene");
            if rubs {
                parameters.contact.friction = 0.2;
                parameters.mechanism.joint_friction_nm = 3e-4;
                parameters.mechanism.capstan_share = 0.03;
            }
            parameters
        };
        let tendon = compared::<Grasping<Tendon3>>(&of("tendon3"), false);
        let linkage = compared::<Grasping<Linkage3>>(&of("linkage3"), false);
        println!("{rubs}: {tendon:?} {linkage:?}");
        for [most_nm, rise_nm, apart_m] in [tendon, linkage] {
            assert!(most_nm < 6e-3 && rise_nm > 0.01, "{most_nm} {rise_nm}");
            assert!(apart_m < 3e-4, "{apart_m}");
        }
        if rubs {
            let [most_nm, ..] = compared::<Grasping<Tendon3>>(&of("tendon3"), true);
            println!("without friction {most_nm}");
            assert!(most_nm > 0.012, "friction hardly shows: {most_nm}");
        }
    }
}
