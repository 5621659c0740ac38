//! The library's paths next to the finger of the reference: without noise, on every finger whose weight its scene states.

use palpate::finger::{Contact, Mechanics};
use palpate::scene::Scene;
use palpate_plant::Parameters;
use palpate_scenes::for_scene;

use super::known::{Chosen, FRICTION, JOINT, K, Known};
use crate::reference::Held;

/// Fingers with a weight.
const WEIGHED: [&str; 5] = ["tendon2", "tendon3", "hidden3", "linkage3", "return2"];
/// Share of the torque by which they may differ, where a joint that turns back stands and while it begins to turn: there the library
/// takes the whole finger for rigid. Elsewhere they differ by its rounding.
const NEAR: f64 = 1e-2;
const ROUNDING: f64 = 3e-4;
/// Steps of the measured angle, radian, and torque at which a curve ends, newton metre.
const STEP_RAD: f64 = 0.02;
const STEPS: u32 = 40;
const TOP_NM: f64 = 0.33;
/// Ends a path where the torque of a step has grown by less than this share of the first step's growth: the finger begins to fold round the
/// object.
const FOLDS: f64 = 0.3;

/// Largest differences of the torque since the contact, as shares of it, of points of a path where no joint turns back, and where one does;
/// and the points' numbers.
#[derive(Default)]
struct Compared {
    differences: [f64; 2],
    points: [u32; 2],
}

impl Compared {
    /// One contact, as the scene expects friction of contact, joints and pulleys.
    fn contact<S: Scene>(&mut self, known: &Known, chosen: Chosen) {
        let finger = S::MECHANISM;
        let values = known.means(&chosen);
        let (press, drive) = known.press(chosen.phalanx, &values);
        let opened = &known.opened;
        let held = Held::new(opened, press, chosen.onset_rad, &drive).expect("a contact");
        let start = held.start();
        let from_rad = opened.finger.theta_a(&start.theta);
        let free = finger
            .free_at_angle(from_rad as f32, &finger.rest())
            .expect("free");
        let off_nm = f64::from(free.torque_nm) - start.torque_nm;
        assert!(off_nm.abs() < 1e-6, "{}: {off_nm:e}", S::NAME);
        let contact = Contact {
            phalanx: chosen.phalanx as u8,
            k_m: values[K] as f32,
            radius_m: press.radius_m as f32,
        };
        let path = finger.path(&free.configuration, free.torque_nm, contact);
        let mut path = path.expect("a path");
        finger.lose(&mut path);
        finger.brake(&mut path, values[JOINT] as f32);
        let rubs = values[FRICTION] as f32;
        finger
            .rub(&mut path, rubs, press.half_thickness_m as f32)
            .expect("it slides");
        let (mut near, mut first_nm) = (start.clone(), 0.0);
        for step in 1..=STEPS {
            let angle_rad = chosen.onset_rad + STEP_RAD * f64::from(step);
            let Some(next) = held.at(angle_rad, &drive, &near) else {
                break;
            };
            let grown_nm = next.torque_nm - near.torque_nm;
            near = next;
            let rise_nm = near.torque_nm - start.torque_nm;
            if step == 1 {
                first_nm = rise_nm;
            }
            let share = held.along_m(&near.theta) / known.lengths_m[chosen.phalanx - 1];
            // At either end of the phalanx one leaves it before the other. Where the torque begins to fall the finger folds round the
            // object, and the library's path ends.
            if rise_nm > TOP_NM || !(0.01..0.99).contains(&share) || grown_nm < FOLDS * first_nm {
                break;
            }
            let point = finger.follow(&mut path, rise_nm as f32).expect("a point");
            // Less than none is none: the finger stands.
            let turned_rad = f64::from(point.rotation_rad).max(0.0);
            let compliance = f64::from(point.compliance_rad_per_nm) + drive.cable_rad_per_nm;
            let off_rad = opened.finger.theta_a(&near.theta) - from_rad - turned_rad;
            let back = (near.theta.iter().zip(&start.theta).skip(1)).any(|(now, was)| now <= was);
            let kind = usize::from(back);
            let difference = (off_rad / compliance / rise_nm).abs();
            self.differences[kind] = self.differences[kind].max(difference);
            self.points[kind] += 1;
        }
    }
}

#[test]
fn the_librarys_paths_are_those_of_the_reference_with_weight() {
    for name in WEIGHED {
        let parameters = Parameters::of(name).expect("a scene");
        let mut compared = Compared::default();
        for_scene!(name, |S| {
            let known = Known::of::<S>(&parameters);
            assert!(known.opened.weight.is_some(), "{name}");
            for (phalanx, theta_1_rad) in
                (2..=known.lengths_m.len()).flat_map(|phalanx| [(phalanx, 0.65), (phalanx, 0.95)])
            {
                for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
                    let chosen = Chosen {
                        phalanx,
                        k_m: share * known.lengths_m[phalanx - 1],
                        object_m: 0.008,
                        onset_rad: known.onset_rad(theta_1_rad).expect("an angle"),
                    };
                    compared.contact::<S>(&known, chosen);
                }
            }
        });
        let Compared {
            differences: [on, back],
            points,
        } = compared;
        println!("{name}: {on:.1e} and {back:.1e} of the torque, points {points:?}");
        assert!(on < ROUNDING && back < NEAR, "{name}: {on:.1e} {back:.1e}");
        assert!(points[0] > 30, "{name}: {points:?}");
    }
}
