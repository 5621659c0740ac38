//! Both worlds on the same scenes: frictionless, without gravity, at rest, the finger's path, contact forces and
//! stiffness are the same within 0.5 %.
//!
//! The plant's finger follows closed equations of balance without mass; MuJoCo integrates bodies held together by
//! constraints. What the two have in common is the parameters alone.

use palpate_mujoco::{MujocoFinger, Surroundings};
use palpate_plant::{
    CableEnd, Error, FingerState, Grasp, Mechanics, Parameters, Quasistatic, Shape,
};

const SHARE: f64 = 0.005;

/// A second: joints come to rest in some 10 ms.
const OWN_STEPS: usize = 10_000;
const OWN_STEP_S: f64 = 1e-4;

const CYLINDER: Shape = Shape::Cylinder { diameter_m: 0.020 };

/// Angle of the input link, radian, and torque at it, newton metre.
type Load = (f64, f64);

/// Both fingers, held by the same cable.
struct Pair {
    own: Quasistatic,
    mujoco: MujocoFinger,
    stiffness_nm_per_rad: f64,
}

impl Pair {
    fn new(scene: &str) -> Self {
        Self::of(&Parameters::of(scene).expect("a scene of this project"))
    }

    fn of(parameters: &Parameters) -> Self {
        let surroundings = Surroundings::default();
        Self {
            own: Quasistatic::new(parameters).expect("the defaults are valid"),
            mujoco: MujocoFinger::new(parameters, &surroundings).expect("a valid model"),
            stiffness_nm_per_rad: parameters.cable_stiffness_nm_per_rad(),
        }
    }

    /// Both at rest with the cable's other end at `end_rad` above the opening stop.
    fn at(&mut self, end_rad: f64) -> [&FingerState; 2] {
        let at = self.own.state().stops_rad[0] + end_rad;
        let end = CableEnd {
            low_rad: at,
            high_rad: at,
            stiffness_nm_per_rad: self.stiffness_nm_per_rad,
        };
        // The plant's own settling takes steps of 5 ms, at which a stiff contact may chatter.
        for _ in 0..OWN_STEPS {
            self.own.step(&end, OWN_STEP_S);
        }
        self.mujoco.settle(&end);
        [self.own.state(), self.mujoco.state()]
    }

    fn place(&mut self, grasp: &Grasp) -> Result<(), Error> {
        self.own.place(grasp)?;
        self.mujoco.place(grasp)
    }
}

/// Deviation as a share of what it is measured by.
fn share(own: f64, mujoco: f64, scale: f64) -> f64 {
    (own - mujoco).abs() / scale.abs()
}

/// Largest deviations of a scene.
#[derive(Debug, Default)]
struct Worst {
    path: f64,
    torque: f64,
    force: f64,
    place: f64,
    stiffness: f64,
}

impl Worst {
    /// Compares torques, and stiffnesses since the last state; returns what the next state is compared with.
    fn note_load(
        &mut self,
        cable_nm_per_rad: f64,
        last: Option<[Load; 2]>,
        states: [&FingerState; 2],
    ) -> [Load; 2] {
        let [own, mujoco] = states;
        let torque = share(own.torque_nm, mujoco.torque_nm, own.torque_nm);
        Self::note(&mut self.torque, torque);
        let now = states.map(|state| (state.theta_a_rad, state.torque_nm));
        if let Some(last) = last {
            Self::note(&mut self.stiffness, deviation(cable_nm_per_rad, last, now));
        }
        now
    }

    fn note(worst: &mut f64, found: f64) {
        assert!(found.is_finite());
        *worst = worst.max(found);
    }

    fn check(&self, what: &str) {
        println!(
            "{what}: path {:.3} %, torque {:.3} %, force {:.3} %, place {:.3} %, stiffness {:.3} %",
            1e2 * self.path,
            1e2 * self.torque,
            1e2 * self.force,
            1e2 * self.place,
            1e2 * self.stiffness
        );
        for found in [
            self.path,
            self.torque,
            self.force,
            self.place,
            self.stiffness,
        ] {
            assert!(found < SHARE, "{what}: {self:?}");
        }
    }
}

#[test]
fn a_free_finger_takes_the_same_path() {
    for scene in SCENES {
        let mut pair = Pair::new(scene);
        let mut worst = Worst::default();
        let start = pair.own.state().joint_rad;
        for step in 1..=6 {
            let [own, mujoco] = pair.at(0.25 * f64::from(step));
            let travel = own.theta_a_rad - own.stops_rad[0];
            let joints = own.joint_rad.iter().zip(&mujoco.joint_rad).zip(&start);
            for ((own, mujoco), start) in joints.take(own.phalanges) {
                let moved = (own - start).abs().max(0.05);
                Worst::note(&mut worst.path, share(*own, *mujoco, moved));
            }
            Worst::note(
                &mut worst.path,
                share(own.theta_a_rad, mujoco.theta_a_rad, travel),
            );
            Worst::note(
                &mut worst.torque,
                share(
                    own.torque_nm,
                    mujoco.torque_nm,
                    own.torque_nm.abs().max(0.01),
                ),
            );
        }
        worst.check(&format!("{scene} free"));
    }
}

#[test]
fn stops_are_as_stiff() {
    for scene in SCENES {
        let mut pair = Pair::new(scene);
        let travel = {
            let [opening, closing] = pair.own.state().stops_rad;
            closing - opening
        };
        let mut worst = Worst::default();
        let cable = pair.stiffness_nm_per_rad;
        let mut last: Option<[Load; 2]> = None;
        for torque_nm in [0.2, 0.4] {
            let stop = Parameters::default().mechanism.stop_stiffness_nm_per_rad;
            let [own, mujoco] = pair.at(travel + torque_nm / cable + torque_nm / stop);
            last = Some(worst.note_load(cable, last, [own, mujoco]));
        }
        worst.check(&format!("{scene} on its closing stop"));
    }
}

/// Deviation of the compliance between two states, the finger's with the cable's, which is what a motor feels.
fn deviation(cable_nm_per_rad: f64, from: [Load; 2], to: [Load; 2]) -> f64 {
    let cable = 1.0 / cable_nm_per_rad;
    let compliance = [0, 1].map(|i| (to[i].0 - from[i].0) / (to[i].1 - from[i].1) + cable);
    share(compliance[0], compliance[1], compliance[0])
}

/// Closes on an object and compares every state with contact.
fn compare(scene: &str, grasp: &Grasp, what: &str) {
    let mut pair = Pair::new(scene);
    pair.at(0.05);
    pair.place(grasp).expect("clear of the open finger");
    let mut worst = Worst::default();
    let cable = pair.stiffness_nm_per_rad;
    let mut last: Option<[Load; 2]> = None;
    let mut pressed = 0;
    for step in 2..=32 {
        let [own, mujoco] = pair.at(0.05 * f64::from(step));
        if own.contacts.is_empty() || own.torque_nm > 0.35 {
            last = None;
            continue;
        }
        let force = |state: &FingerState| state.contacts.iter().map(|c| c.force_n).sum::<f64>();
        // Just touching, forces are what the engines' rounding leaves.
        if force(own) < 0.2 {
            continue;
        }
        pressed += 1;
        let centre = |state: &FingerState| {
            let weighted = state
                .contacts
                .iter()
                .map(|c| c.force_n * c.k_m)
                .sum::<f64>();
            weighted / force(state)
        };
        let phalanges = [own, mujoco].map(|state| {
            let mut list: Vec<u8> = state.contacts.iter().map(|c| c.phalanx).collect();
            list.dedup();
            list
        });
        assert_eq!(phalanges[0], phalanges[1], "{what}, step {step}");
        Worst::note(
            &mut worst.force,
            share(force(own), force(mujoco), force(own)),
        );
        if phalanges[0].len() == 1 {
            Worst::note(&mut worst.place, share(centre(own), centre(mujoco), 0.07));
        }
        last = Some(worst.note_load(cable, last, [own, mujoco]));
    }
    assert!(pressed >= 2, "{what}: {pressed} states with contact");
    worst.check(&format!("{scene} {what}, {pressed} states"));
}

const SCENES: [&str; 8] = [
    "p70",
    "p70-rigid",
    "p70-preloaded",
    "tendon2",
    "tendon3",
    "hidden3",
    "return2",
    "linkage3",
];

fn cylinders(scene: &str, places: &[(u8, f64)]) {
    for &(phalanx, k_m) in places {
        let grasp = Grasp::touching(phalanx, k_m, 0.8, CYLINDER);
        compare(
            scene,
            &grasp,
            &format!("cylinder at {:.0} mm of phalanx {phalanx}", 1e3 * k_m),
        );
    }
}

#[test]
fn prototype_on_cylinders() {
    cylinders("p70", &[(1, 0.05), (2, 0.02), (2, 0.04), (2, 0.06)]);
}

/// Joint 2's own motor holds it: the spring with its backlash is a tendon in one engine, two one-sided springs in the other.
#[test]
fn a_held_joint_gives_way_alike() {
    cylinders("direct2", &[(1, 0.05), (2, 0.02), (2, 0.04), (2, 0.06)]);
}

#[test]
fn two_phalanx_tendon_on_cylinders() {
    cylinders("tendon2", &[(1, 0.05), (2, 0.02), (2, 0.05)]);
}

#[test]
fn three_phalanx_tendon_on_cylinders() {
    cylinders("tendon3", &[(1, 0.05), (2, 0.03), (3, 0.015), (3, 0.03)]);
}

#[test]
fn hidden_phalanx_on_cylinders() {
    cylinders("hidden3", &[(2, 0.02), (2, 0.06), (3, 0.02), (3, 0.05)]);
}

/// Joint 2 stands at its stop until the torque overcomes a preloaded spring, or what a return cable holds it by.
#[test]
fn preloaded_joints_give_way_alike() {
    cylinders(
        "p70-preloaded",
        &[(1, 0.05), (2, 0.02), (2, 0.04), (2, 0.06)],
    );
    cylinders("return2", &[(1, 0.05), (2, 0.02), (2, 0.04), (2, 0.06)]);
}

#[test]
fn three_phalanx_linkage_on_cylinders() {
    cylinders("linkage3", &[(1, 0.05), (2, 0.03), (3, 0.015), (3, 0.03)]);
}

#[test]
fn boxes_and_polygons() {
    let triangle = Shape::Polygon {
        corners_m: vec![[0.0, 0.0], [0.03, 0.04], [-0.02, 0.04]],
    };
    for (shape, what) in [
        (Shape::square(0.03, 45.0), "edge of a box"),
        (triangle, "corner of a triangle"),
    ] {
        compare("p70", &Grasp::touching(2, 0.04, 0.8, shape), what);
    }
}

#[test]
fn weight_and_preload_are_the_same() {
    let mut parameters = Parameters::of("tendon2").expect("a scene");
    let mechanism = &mut parameters.mechanism;
    (mechanism.gravity_m_per_s2, mechanism.mounting_deg) = (9.81, 20.0);
    let mut pair = Pair::of(&parameters);
    let mut worst = Worst::default();
    for step in 1..=5 {
        let [own, mujoco] = pair.at(0.2 * f64::from(step));
        Worst::note(
            &mut worst.torque,
            share(own.torque_nm, mujoco.torque_nm, own.torque_nm),
        );
        Worst::note(
            &mut worst.path,
            share(own.joint_rad[1], mujoco.joint_rad[1], 0.1),
        );
    }
    worst.check("tendon2 under its own weight");

    let mut parameters = Parameters::default();
    parameters.mechanism.preload_deg = 10.0;
    let mut pair = Pair::of(&parameters);
    let grasp = Grasp::touching(2, 0.04, 0.8, CYLINDER);
    pair.at(0.05);
    pair.place(&grasp).expect("clear of the open finger");
    let mut worst = Worst::default();
    let mut stuck = false;
    for step in 0..=7 {
        let [own, mujoco] = pair.at(0.82 + 0.03 * f64::from(step));
        Worst::note(
            &mut worst.torque,
            share(own.torque_nm, mujoco.torque_nm, own.torque_nm),
        );
        stuck |= own.joint_rad[1].abs() < 1e-3 && !own.contacts.is_empty();
    }
    assert!(stuck, "the preload holds joint 2 at its stop");
    worst.check("prototype with preload");
}
