//! A finger that is softer than it should be without contact, K_a below K_a' (Fig 8 of the paper): a spring that has lost its
//! hold, a contact on the back. Simulated, on fingers with springs, drawn in `workshop`.

use palpate::drive::sequence::State;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Parameters, Plant, Shape, World};
use palpate_scenes::{Linkage3, Tendon2, Tendon3};
use palpate_simulation::{Simulated, Simulation};

/// Fingers drawn of each scene.
const FINGERS: std::ops::Range<u64> = 0..5;
/// Fingers that are pressed on their back: of 29 it was told as `unusual` on 19 (docs/MECHANICS.md#preshaping).
const BACKS: std::ops::Range<u64> = 0..10;
/// Share of their stiffness that weak springs have left.
const SPRINGS_LEFT: f64 = 0.4;
/// Diameter of what presses on the back, metre, its force, newton, and the angle of joint 1 from which on it does, radian.
const ROD_M: f64 = 0.01;
const PUSH_N: f64 = 0.5;
const PUSHED_FROM_RAD: f64 = 0.4;

/// A drawn finger whose friction is recorded.
fn recorded<S: Simulated>(seed: u64) -> (Simulation<S>, Parameters) {
    let world = World::named("workshop").expect("a world");
    let parameters = world.of(S::NAME).expect("a scene").randomised(seed);
    let mut simulation = Simulation::<S>::new(&parameters, seed).expect("a finger");
    simulation.prepare().expect("prepared");
    (simulation, parameters)
}

/// What a closing without an object tells, opening included: whether it is unusual, and by how many deviations K_a is below K_a' in
/// the end.
fn closing<S: Simulated>(simulation: &mut Simulation<S>) -> (bool, f32, Vec<Event>) {
    let closed = simulation.close(&Grasp::Free);
    let closed = closed.expect("a closing");
    let opened = simulation.open().expect("an opening");
    assert_eq!((closed.fault, opened.fault), (None, None));
    let events: Vec<Event> = closed
        .events
        .iter()
        .chain(&opened.events)
        .map(|(_, event)| *event)
        .collect();
    let unusual = events
        .iter()
        .any(|event| matches!(event, Event::Unusual { .. }));
    let deficit = events.iter().rev().find_map(|event| match event {
        Event::Stiffness {
            k_a_nm_per_rad,
            k_a_sigma_nm_per_rad,
            k_a_free_nm_per_rad,
        } => Some((k_a_free_nm_per_rad - k_a_nm_per_rad) / k_a_sigma_nm_per_rad),
        _ => None,
    });
    let deficit = deficit.unwrap_or_else(|| panic!("no stiffness: {events:?}"));
    (unusual, deficit, events)
}

fn is_told<S: Simulated>() {
    for seed in FINGERS {
        let (mut simulation, _) = recorded::<S>(seed);
        let (unusual, deficit, events) = closing(&mut simulation);
        assert!(
            !unusual && deficit.abs() < 3.0,
            "{} {seed}, sound: {events:?}",
            S::NAME
        );
        simulation.plant().faults.springs_left = SPRINGS_LEFT;
        let (unusual, deficit, events) = closing(&mut simulation);
        assert!(
            unusual && deficit > 3.0,
            "{} {seed}, weak: {events:?}",
            S::NAME
        );
    }
}

#[test]
fn a_spring_that_lost_its_hold_is_told() {
    is_told::<Tendon2>();
    is_told::<Tendon3>();
    is_told::<Linkage3>();
}

/// A rod that follows the back of the last phalanx and presses on its middle.
struct Pusher {
    length_m: Vec<f64>,
    stiffness_n_per_m: f64,
    /// From the phalanx's axis to the rod's when they just touch, metre, and how far the rod is pressed in.
    away_m: f64,
    depth_m: f64,
    /// Where the rod is, and where it was to be a sample ago.
    at: Option<[[f64; 2]; 2]>,
}

impl Pusher {
    fn of(parameters: &Parameters) -> Self {
        Self {
            length_m: parameters.finger.length_m.clone(),
            stiffness_n_per_m: parameters.contact.stiffness_n_per_m,
            away_m: 0.5 * ROD_M + parameters.mechanism.phalanx_half_thickness_m,
            depth_m: 0.0,
            at: None,
        }
    }

    fn follow(&mut self, plant: &mut Plant) {
        let truth = plant.truth();
        let (mut middle, mut angle) = ([0.0; 2], 0.0_f64);
        for (i, length_m) in self.length_m.iter().enumerate() {
            angle += truth.joint_rad[i];
            let share = if i + 1 == self.length_m.len() {
                0.5
            } else {
                1.0
            };
            let (sin, cos) = angle.sin_cos();
            middle = [
                middle[0] + share * length_m * cos,
                middle[1] + share * length_m * sin,
            ];
        }
        let (sin, cos) = angle.sin_cos();
        let behind = |away_m: f64| [middle[0] + away_m * sin, middle[1] - away_m * cos];
        let force_n: f64 = truth.contacts.iter().map(|contact| contact.force_n).sum();
        self.depth_m += 0.2 * (PUSH_N - force_n) / self.stiffness_n_per_m;
        let wanted = behind(self.away_m - self.depth_m);
        let [at, before] = self.at.unwrap_or_else(|| {
            let origin_m = behind(self.away_m + 1e-3);
            let rod = Grasp::At {
                origin_m,
                angle_rad: 0.0,
                shape: Shape::Cylinder { diameter_m: ROD_M },
            };
            plant.place(&rod).expect("room behind the finger");
            [origin_m, wanted]
        });
        // The finger goes on moving until the next sample.
        let to = [0, 1].map(|i| 2.0 * wanted[i] - before[i]);
        plant.shift([0, 1].map(|i| to[i] - at[i])).expect("room");
        self.at = Some([to, wanted]);
    }
}

#[test]
fn a_contact_on_the_back_is_told() {
    let mut unusual = 0;
    for seed in BACKS {
        let (mut simulation, parameters) = recorded::<Tendon3>(seed);
        let mut pusher = Pusher::of(&parameters);
        let mut pressed_ms = 0;
        let closed = simulation.close_while(&Grasp::Free, |plant, state| {
            if state == State::Close && plant.truth().joint_rad[0] > PUSHED_FROM_RAD {
                pusher.follow(plant);
            }
            let truth = plant.truth();
            let pressed = truth.contacts.iter().find(|contact| contact.back);
            pressed_ms += i32::from(pressed.is_some_and(|back| back.force_n > 0.5 * PUSH_N));
        });
        let closed = closed.expect("a closing");
        assert!(pressed_ms > 200, "{seed}: {pressed_ms} ms");
        match closed.events.first() {
            Some((
                _,
                Event::Unusual {
                    k_a_nm_per_rad,
                    k_a_free_nm_per_rad,
                    ..
                },
            )) if k_a_nm_per_rad < k_a_free_nm_per_rad => unusual += 1,
            // It may also turn the phalanges against each other, which the motor feels as a load.
            Some((_, Event::Touch { .. })) => {}
            _ => panic!("{seed}: {:?}", closed.events),
        }
    }
    assert!(unusual > 3, "{unusual}");
}
