//! Fingers whose weight is stated, against positions and energies in f64: every derivative by differences.

use nalgebra::{DMatrix, DVector};
use palpate::finger::{
    Contact, Finger, Mechanics, Mounting, Parameter, Parameters, ReturnCable, Tendon,
};
use palpate::scene::Scene;
use palpate_scenes::{Hidden3, Linkage3, P70, Return2, Tendon2, Tendon3};
use proptest::prelude::*;
use std::f64::consts::TAU;

const GRAVITY: f64 = 9.81;
/// Step of the differences, radian.
const STEP: f64 = 1e-4;
/// Parts into which a rise of the torque is divided.
const PARTS: u32 = 20;
/// Mountings, radian, and weights over those of the scenes: as in the world `harsh` at most.
const GRAVITY_RAD: [f64; 5] = [-1.57, -0.4, 0.7, 1.8, 3.1];
const SHARES: [f64; 2] = [1.0, 3.0];

/// A stage of a linkage: levers and coupler, offset; or the ratio of a tendon's pulleys.
#[derive(Clone, Copy)]
enum Stage {
    Tendon(f64),
    Linkage([f64; 4], f64),
}

/// What a finger's energy knows.
struct Energy {
    lengths: Vec<f64>,
    masses: Vec<f64>,
    springs: Vec<f64>,
    rest: Vec<f64>,
    stages: Vec<Stage>,
    /// Radii, tension, stiffness.
    cable: Option<([f64; 2], f64, f64)>,
    down: [f64; 2],
}

impl Energy {
    fn of<const N: usize>(
        parameters: &Parameters<N>,
        stages: Vec<Stage>,
        (gravity_rad, share): (f64, f64),
    ) -> Self {
        let all = |list: [f32; N]| list.map(f64::from).to_vec();
        let lengths = all(parameters.lengths_m);
        Self {
            masses: lengths.iter().map(|length| 0.1 * length).collect(),
            lengths,
            springs: all(parameters.stiffness_nm_per_rad),
            rest: all(parameters.rest_rad),
            stages,
            cable: None,
            down: [gravity_rad.cos(), gravity_rad.sin()].map(|part| share * GRAVITY * part),
        }
    }

    /// Where a point of a phalanx is.
    fn point(&self, theta: &DVector<f64>, phalanx: usize, along: f64) -> [f64; 2] {
        let (mut at, mut angle) = ([0.0, 0.0], 0.0f64);
        for j in 0..=phalanx {
            angle += theta[j];
            let length = if j == phalanx { along } else { self.lengths[j] };
            at = [at[0] + length * angle.cos(), at[1] + length * angle.sin()];
        }
        at
    }

    fn theta_a(&self, theta: &DVector<f64>) -> f64 {
        let mut inner = 0.0;
        for (j, stage) in self.stages.iter().enumerate().rev() {
            let u = theta[j + 1] + inner;
            inner = match stage {
                Stage::Tendon(ratio) => ratio * u,
                Stage::Linkage([a, b, c, psi], mode) => {
                    let ground = self.lengths[j];
                    let gamma = |delta: f64| {
                        let end = [ground + c * delta.cos(), c * delta.sin()];
                        let reach = end[0].hypot(end[1]);
                        let cosine = (reach * reach + a * a - b * b) / (2.0 * a * reach);
                        end[1].atan2(end[0]) + mode * cosine.acos()
                    };
                    gamma(u - psi) - gamma(-psi)
                }
            };
        }
        theta[0] + inner
    }

    /// Height times weight, springs, return cable, less what the motor gives.
    fn energy(&self, theta: &DVector<f64>, torque: f64) -> f64 {
        let mut sum = -torque * self.theta_a(theta);
        for j in 0..self.lengths.len() {
            let middle = self.point(theta, j, 0.5 * self.lengths[j]);
            sum -= self.masses[j] * (self.down[0] * middle[0] + self.down[1] * middle[1]);
            let bent = theta[j] - self.rest[j];
            sum += 0.5 * self.springs[j] * bent * bent;
        }
        if let Some((radii, tension, stiffness)) = self.cable {
            let wound = radii[0] * theta[0] + radii[1] * theta[1];
            sum += wound * (tension + 0.5 * stiffness * wound);
        }
        sum
    }

    fn gradient(&self, theta: &DVector<f64>, of: impl Fn(&DVector<f64>) -> f64) -> DVector<f64> {
        DVector::from_fn(theta.len(), |j, _| {
            let beside = |steps: f64| {
                let mut beside = theta.clone();
                beside[j] += steps * STEP;
                of(&beside)
            };
            // Of fourth order.
            (8.0 * (beside(1.0) - beside(-1.0)) - (beside(2.0) - beside(-2.0))) / (12.0 * STEP)
        })
    }

    /// What is left at every joint.
    fn left(&self, theta: &DVector<f64>, torque: f64) -> DVector<f64> {
        self.gradient(theta, |theta| self.energy(theta, torque))
    }

    /// Distance of a point in space from a phalanx's axis.
    fn distance(&self, theta: &DVector<f64>, phalanx: usize, point: [f64; 2]) -> f64 {
        let joint = self.point(theta, phalanx, 0.0);
        let angle: f64 = theta.iter().take(phalanx + 1).sum();
        (point[0] - joint[0]) * -angle.sin() + (point[1] - joint[1]) * angle.cos()
    }

    /// A root of some balance by Newton's steps.
    fn root(start: DVector<f64>, balance: impl Fn(&DVector<f64>) -> DVector<f64>) -> DVector<f64> {
        let mut x = start;
        for _ in 0..30 {
            let columns: Vec<_> = (0..x.len())
                .map(|j| {
                    let beside = |step: f64| {
                        let mut beside = x.clone();
                        beside[j] += step;
                        balance(&beside)
                    };
                    (beside(STEP) - beside(-STEP)) / (2.0 * STEP)
                })
                .collect();
            let step = DMatrix::from_columns(&columns)
                .lu()
                .solve(&balance(&x))
                .expect("regular");
            x -= &step;
            if step.amax() < 1e-12 {
                break;
            }
        }
        x
    }

    /// The free finger at an angle of the input link: joint angles and torque. A return cable lets joint 1 alone turn.
    fn free(&self, theta_a: f64) -> (DVector<f64>, f64) {
        let joints = self.lengths.len();
        let turning = if self.cable.is_some() { 1 } else { joints };
        let posture = |x: &DVector<f64>| {
            let mut theta = DVector::from_column_slice(&self.rest);
            theta.rows_mut(0, turning).copy_from(&x.rows(0, turning));
            theta
        };
        let start = DVector::from_column_slice(&self.rest)
            .rows(0, turning)
            .clone_owned()
            .push(0.0);
        let x = Self::root(start, |x| {
            let theta = posture(x);
            let left = self.left(&theta, x[turning]);
            left.rows(0, turning)
                .clone_owned()
                .push(self.theta_a(&theta) - theta_a)
        });
        (posture(&x), x[turning])
    }

    /// The finger on a point that its phalanx met in a posture, followed from there: rotation and force after a rise of the torque, and
    /// compliance.
    fn pressed(&self, at: &DVector<f64>, phalanx: usize, k: f64, torques: [f64; 2]) -> [f64; 3] {
        let point = self.point(at, phalanx, k);
        let joints = at.len();
        let under = |torque: f64, near: &DVector<f64>| {
            Self::root(near.clone(), |x| {
                let theta = x.rows(0, joints).clone_owned();
                let normal = self.gradient(&theta, |theta| self.distance(theta, phalanx, point));
                let left = self.left(&theta, torque) - normal * x[joints];
                left.push(self.distance(&theta, phalanx, point))
            })
        };
        let turned = |x: &DVector<f64>| self.theta_a(&x.rows(0, joints).clone_owned());
        let [from, rise] = torques;
        let mut now = at.clone().push(0.0);
        // Below break-away a return cable holds what this balance knows nothing of.
        let parts = if self.cable.is_some() { 1 } else { PARTS };
        for part in 1..=parts {
            now = under(from + rise * f64::from(part) / f64::from(parts), &now);
        }
        let step = 1e-4;
        let [more, less] = [step, -step].map(|step| turned(&under(from + rise + step, &now)));
        [
            turned(&now) - self.theta_a(at),
            now[joints],
            (more - less) / (2.0 * step),
        ]
    }

    /// 1/K_c at contact: the energy's Hessian, bordered with the contact's gradient.
    fn compliance(&self, at: &DVector<f64>, torque: f64, phalanx: usize, k: f64) -> f64 {
        let joints = at.len();
        let point = self.point(at, phalanx, k);
        let normal = self.gradient(at, |theta| self.distance(theta, phalanx, point));
        let x = self.gradient(at, |theta| self.theta_a(theta));
        let columns: Vec<_> = (0..joints)
            .map(|j| {
                let beside = |step: f64| {
                    let mut beside = at.clone();
                    beside[j] += step;
                    self.left(&beside, torque)
                };
                let column = (beside(STEP) - beside(-STEP)) / (2.0 * STEP);
                column.push(normal[j])
            })
            .chain([normal.clone().push(0.0)])
            .collect();
        let turned = DMatrix::from_columns(&columns)
            .lu()
            .solve(&x.clone().push(0.0))
            .expect("regular");
        x.dot(&turned.rows(0, joints))
    }
}

fn tendon(ratios: &[f64]) -> Vec<Stage> {
    ratios.iter().copied().map(Stage::Tendon).collect()
}

fn linkage3() -> Vec<Stage> {
    let stage = |a, b, c| Stage::Linkage([a, b, c, 2.0], -1.0);
    vec![stage(0.0585, 0.1035, 0.0297), stage(0.045, 0.0774, 0.0225)]
}

/// Largest errors of what the library says of a finger: torque of the free finger, newton metre; angles of its joints, radian;
/// compliance at contact, rotation, force and compliance of a path, as shares.
#[derive(Debug, Default)]
struct Errors {
    torque_nm: f64,
    joints_rad: f64,
    at_contact: f64,
    rotation: f64,
    force: f64,
    along: f64,
    contacts: u32,
}

impl Errors {
    fn grow(worst: &mut f64, error: f64) {
        assert!(error.is_finite());
        *worst = worst.max(error.abs());
    }

    fn compare<F: Mechanics>(&mut self, heavy: &F, energy: &Energy, closed: f32) {
        let rest = heavy.rest();
        let theta_a = heavy.input_angle_rad(&rest) + closed;
        let free = heavy.free_at_angle(theta_a, &rest).expect("a posture");
        let (theta, torque) = energy.free(theta_a.into());
        Self::grow(&mut self.torque_nm, f64::from(free.torque_nm) - torque);
        for joint in 0..F::PHALANGES {
            let told = heavy
                .joint_rad(&free.configuration, joint as u8 + 1)
                .expect("a joint");
            Self::grow(&mut self.joints_rad, f64::from(told) - theta[joint]);
        }
        for phalanx in 2..=F::PHALANGES as u8 {
            let length = f64::from(heavy.phalanx_length_m(phalanx).expect("a phalanx"));
            for share in [0.15, 0.5, 0.8] {
                self.contact(
                    heavy,
                    energy,
                    (&free.configuration, free.torque_nm),
                    (&theta, torque),
                    (phalanx, share * length),
                );
            }
        }
    }

    fn contact<F: Mechanics>(
        &mut self,
        heavy: &F,
        energy: &Energy,
        (at, torque_nm): (&F::Configuration, f32),
        (theta, torque): (&DVector<f64>, f64),
        (phalanx, k): (u8, f64),
    ) {
        let index = usize::from(phalanx) - 1;
        let k_m = k as f32;
        let contact = Contact {
            phalanx,
            k_m,
            radius_m: 0.0,
        };
        let expected = energy.compliance(theta, torque, index, k);
        let told = heavy
            .contact_compliance(at, torque_nm, phalanx, k_m)
            .expect("stable");
        // As a share of the finger's own: near the stiffest place nothing is left of the other.
        let own = heavy.proximal_compliance(at, torque_nm).expect("stable");
        Self::grow(
            &mut self.at_contact,
            (f64::from(told) - expected) / f64::from(own),
        );
        // The place leads back, where the finger presses.
        let Some(mut path) = heavy.path(at, torque_nm, contact) else {
            return;
        };
        // A weight that tips the finger over on its tip leaves no order of places.
        let tip_m = heavy.phalanx_length_m(phalanx).expect("a phalanx");
        if heavy
            .contact_compliance(at, torque_nm, phalanx, tip_m)
            .is_none()
        {
            return;
        }
        for inverse in [
            heavy.locate(at, torque_nm, told),
            heavy.locate_closed(at, torque_nm, told),
        ] {
            let found = inverse
                .candidates()
                .iter()
                .any(|place| place.phalanx == phalanx && (place.k_m - k_m).abs() < 2e-3 * k_m);
            assert!(found, "{phalanx} {k_m} {told}: {inverse:?}");
        }
        for rise in [0.02, 0.1] {
            let Some(point) = heavy.follow(&mut path, rise as f32) else {
                continue;
            };
            // Still held at its stop by a return cable.
            if point.rotation_rad <= 0.0 {
                continue;
            }
            let [rotation, force, compliance] = energy.pressed(theta, index, k, [torque, rise]);
            Self::grow(
                &mut self.rotation,
                f64::from(point.rotation_rad) / rotation - 1.0,
            );
            Self::grow(&mut self.force, f64::from(point.force_n) / force - 1.0);
            Self::grow(
                &mut self.along,
                (f64::from(point.compliance_rad_per_nm) - compliance) / f64::from(own),
            );
            self.contacts += 1;
        }
    }
}

#[test]
fn postures_stiffness_and_paths_are_those_of_the_energy() {
    let (mut sprung, mut returned) = (Errors::default(), Errors::default());
    for gravity_rad in GRAVITY_RAD {
        for share in SHARES {
            let hangs = (gravity_rad, share);
            let mounting = Mounting {
                gravity_rad: gravity_rad as f32,
                share: share as f32,
            };
            for closed in [0.1, 0.5] {
                macro_rules! compare {
                    ($scene:ident, $stages:expr) => {{
                        let finger = $scene::MECHANISM.mounted(mounting);
                        let energy = Energy::of(finger.parameters(), $stages, hangs);
                        sprung.compare(&finger, &energy, closed);
                    }};
                }
                compare!(Tendon2, tendon(&[0.8]));
                compare!(Tendon3, tendon(&[0.8, 2.0 / 3.0]));
                compare!(Hidden3, tendon(&[1.0, 5.0 / 9.0]));
                compare!(Linkage3, linkage3());
                let finger = Return2::MECHANISM.mounted(mounting);
                let mut energy = Energy::of(finger.parameters(), tendon(&[0.5]), hangs);
                energy.cable = Some(([0.010, 0.010], 3.5, 200.0));
                returned.compare(&finger, &energy, closed);
            }
        }
    }
    println!("springs: {sprung:?}\nreturn cable: {returned:?}");
    assert!(sprung.contacts > 300 && returned.contacts > 20);
    for errors in [&sprung, &returned] {
        assert!(
            errors.torque_nm < 1e-6 && errors.joints_rad < 1e-5,
            "{errors:?}"
        );
        assert!(
            errors.at_contact < 1e-4 && errors.along < 1e-3,
            "{errors:?}"
        );
        assert!(errors.rotation < 1e-3 && errors.force < 1e-3, "{errors:?}");
    }
}

/// What a scene does not state, it does not have; and in a level plane a stated weight does nothing.
#[test]
fn in_a_level_plane_it_is_the_finger_without_weight() {
    let level = Tendon3::MECHANISM.mounted(Mounting::LEVEL);
    let without: Finger<3, Tendon<3>> =
        Finger::new(*level.parameters(), [0.009, 0.0072, 0.0054, 0.0036]).expect("tendon3");
    let rest = level.rest();
    for closed in [0.1, 0.6] {
        let theta_a = level.input_angle_rad(&rest) + closed;
        let [one, other] = [
            level.free_at_angle(theta_a, &rest).expect("a posture"),
            without.free_at_angle(theta_a, &rest).expect("a posture"),
        ];
        assert_eq!(one, other);
        assert_eq!(level.expected_k_a(&one), without.expected_k_a(&one));
        for (phalanx, k_m) in [(2u8, 0.02), (3, 0.02)] {
            let [heavy, light] = [
                level.contact_compliance(&one.configuration, one.torque_nm, phalanx, k_m),
                without.contact_compliance(&one.configuration, one.torque_nm, phalanx, k_m),
            ]
            .map(|compliance| compliance.expect("stable"));
            assert!((heavy / light - 1.0).abs() < 1e-4, "{heavy} {light}");
        }
    }
    let p70 = P70::MECHANISM;
    let hung = Mounting {
        gravity_rad: 1.0,
        share: 1.0,
    };
    assert_eq!(p70.mounted(hung), p70);
    assert!(!<<P70 as Scene>::Finger as Mechanics>::WEIGHS);
}

/// K_a' (7) is the secant from the torque that holds the finger at rest: weight alone is no stiffness.
#[test]
fn a_free_closing_has_the_stiffness_of_springs_and_weight() {
    for share in SHARES {
        let finger = Tendon3::MECHANISM.mounted(Mounting {
            gravity_rad: -1.57,
            share: share as f32,
        });
        let rest = finger.rest();
        let from = finger.input_angle_rad(&rest);
        let [first, last] = [0.0, 0.8].map(|closed| {
            finger
                .free_at_angle(from + closed, &rest)
                .expect("a posture")
        });
        let secant = (last.torque_nm - first.torque_nm) / 0.8;
        let told = finger.expected_k_a(&last).expect("stiff");
        assert!((told / secant - 1.0).abs() < 1e-4, "{told} {secant}");
        let tangent = 1.0
            / finger
                .free_compliance(&last.configuration, last.torque_nm)
                .expect("stiff");
        let step = 1e-2;
        let [less, more] = [0.8 - step, 0.8 + step].map(|closed| {
            finger
                .free_at_angle(from + closed, &rest)
                .expect("a posture")
                .torque_nm
        });
        let slope = (more - less) / (2.0 * step);
        assert!((tangent / slope - 1.0).abs() < 2e-3, "{tangent} {slope}");
        // And a torque leads back to its posture.
        let back = finger
            .free_at_torque(last.torque_nm, &rest)
            .expect("a posture");
        assert!((finger.input_angle_rad(&back) - from - 0.8).abs() < 1e-5);
    }
    let cable = Return2::MECHANISM.mounted(Mounting {
        gravity_rad: -1.57,
        share: 2.0,
    });
    let free = cable.free_at_angle(0.6, &cable.rest()).expect("a posture");
    let back = cable
        .free_at_torque(free.torque_nm, &cable.rest())
        .expect("a posture");
    assert!((cable.input_angle_rad(&back) - 0.6).abs() < 1e-5);
}

#[test]
fn a_weight_out_of_range_is_named() {
    let hung = Mounting {
        gravity_rad: 0.0,
        share: 1.0,
    };
    let parameters = *Tendon2::MECHANISM.parameters();
    let finger: Finger<2, Tendon<2>> = Finger::new(parameters, [0.009, 0.0072]).expect("tendon2");
    assert!(finger.weighted([0.0, 0.1], hung).is_ok());
    for bad in [-1e-9, f32::NAN, f32::INFINITY, 1.1e9] {
        let error = finger.weighted([0.1, bad], hung).expect_err("a weight");
        assert_eq!(error.parameter, Parameter::Weight { phalanx: 2 });
        assert_eq!((error.min, error.max), (0.0, 1e9));
    }
    for gravity_rad in [7.0, f32::NAN] {
        let error = finger
            .weighted(
                [0.1; 2],
                Mounting {
                    gravity_rad,
                    ..hung
                },
            )
            .expect_err("a direction");
        assert_eq!(error.parameter, Parameter::Gravity);
    }
    let springless = Parameters {
        stiffness_nm_per_rad: [0.0, 0.1],
        ..parameters
    };
    let finger: Finger<2, Tendon<2>> = Finger::new(springless, [0.009, 0.0072]).expect("a finger");
    let error = finger.weighted([0.1; 2], hung).expect_err("no spring");
    assert_eq!(error.parameter, Parameter::Stiffness { joint: 1 });
}

/// Everything that a finger answers, each finite or missing.
fn answers<F: Mechanics>(finger: &F, [angle, torque, k, rise]: [f32; 4]) -> Vec<f32> {
    let rest = finger.rest();
    let mut found = Vec::new();
    let free = finger.free_at_angle(angle, &rest);
    found.extend(free.iter().map(|free| free.torque_nm));
    found.extend(free.iter().filter_map(|free| finger.expected_k_a(free)));
    let at = finger.free_at_torque(torque, &rest);
    found.extend(at.iter().map(|at| finger.input_angle_rad(at)));
    let at = at.or(free.map(|free| free.configuration)).unwrap_or(rest);
    found.extend(finger.free_compliance(&at, torque));
    found.extend(finger.softest_compliance(&at, torque));
    for phalanx in 1..=F::PHALANGES as u8 {
        found.extend(finger.contact_compliance(&at, torque, phalanx, k));
        found.extend(finger.stiffest_m(&at, torque, phalanx));
        let contact = Contact {
            phalanx,
            k_m: k,
            radius_m: 0.01,
        };
        if let Some(mut path) = finger.path(&at, torque, contact)
            && let Some(point) = finger.follow(&mut path, rise)
        {
            found.extend([
                point.rotation_rad,
                point.compliance_rad_per_nm,
                point.force_n,
            ]);
            found.extend([point.rotation_by_k_rad_per_m, point.k_now_m]);
        }
    }
    for inverse in [
        finger.locate(&at, torque, rise),
        finger.locate_closed(&at, torque, rise),
    ] {
        found.extend(inverse.candidates().iter().map(|place| place.k_m));
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any bits at all: nothing panics, and nothing comes out that is not finite.
    #[test]
    fn any_numbers_give_finite_answers_or_none(
        bits in prop::array::uniform6(any::<u32>()),
        usual in prop::array::uniform6(0u8..3),
        weights in prop::array::uniform3(any::<u32>()),
    ) {
        let plain = [1.0, -1.5, 0.8, 0.02, 0.03, 0.5];
        let mut values = [0.0; 6];
        for i in 0..6 {
            values[i] = if usual[i] > 0 { plain[i] } else { f32::from_bits(bits[i]) };
        }
        let [share, gravity_rad, angle, torque, k, rise] = values;
        let mounting = Mounting { gravity_rad, share };
        let inputs = [angle, torque, k, rise];
        let mut found = answers(&Tendon2::MECHANISM.mounted(mounting), inputs);
        found.extend(answers(&Linkage3::MECHANISM.mounted(mounting), inputs));
        found.extend(answers(&Return2::MECHANISM.mounted(mounting), inputs));
        let of = *Tendon3::MECHANISM.parameters();
        let finger: Finger<3, Tendon<3>> = Finger::new(of, [0.009, 0.0072, 0.0054, 0.0036]).expect("tendon3");
        if let Ok(finger) = finger.weighted(weights.map(f32::from_bits), mounting) {
            found.extend(answers(&finger, inputs));
        }
        prop_assert!(found.iter().all(|value| value.is_finite()), "{found:?}");
    }

    /// The torque about each joint is what the energy loses as it turns, and the stiffness what that torque loses.
    #[test]
    fn the_torque_is_the_energys_slope(
        gravity in 0.0..TAU,
        angles in prop::array::uniform3(-1.0f64..2.0),
    ) {
        let finger = Tendon3::MECHANISM.mounted(Mounting { gravity_rad: gravity as f32, share: 1.0 });
        let energy = Energy::of(finger.parameters(), tendon(&[0.8, 2.0 / 3.0]), (gravity, 1.0));
        let at = finger.configuration(angles.map(|angle| (angle.max(-0.5)) as f32)).expect("between its stops");
        let theta = DVector::from_iterator(3, at.rad().map(f64::from));
        let gear = palpate::finger::Transmission::factors(finger.transmission(), &at).expect("tendons");
        let told = finger.equivalent_torques_nm(&gear, &at, 0.03).expect("finite");
        let left = energy.left(&theta, 0.03);
        for joint in 0..3 {
            prop_assert!((f64::from(told[joint]) + left[joint]).abs() < 1e-6, "{told:?} {left}");
        }
    }
}

/// The return cable of a scene, for its type.
#[test]
fn a_returned_finger_without_weight_takes_one() {
    let cable = ReturnCable {
        ratio: 1.0,
        torque_nm: 0.035,
        stiffness_nm_per_rad: 0.02,
    };
    let finger =
        Finger::returned(*Return2::MECHANISM.parameters(), [0.010, 0.005], cable).expect("return2");
    let hung = finger
        .weighted(
            [0.1; 2],
            Mounting {
                gravity_rad: -1.57,
                share: 1.0,
            },
        )
        .expect("in range");
    let [light, heavy] = [
        finger
            .free_at_angle(0.5, &finger.rest())
            .expect("a posture")
            .torque_nm,
        hung.free_at_angle(0.5, &hung.rest())
            .expect("a posture")
            .torque_nm,
    ];
    assert!(heavy > light + 5e-3, "{light} {heavy}");
}
