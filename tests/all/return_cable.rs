//! `return2`: a finger that a preloaded return cable opens. Checked against the balance of its joints, in f64.

use palpate::finger::{
    Class, Contact, Finger, Mechanics, Mounting, Parameter, Parameters, ReturnCable,
};
use palpate::scene::Scene;
use palpate_scenes::{P70Preloaded, Return2};

/// Angles of joint 1 at contact, radian, and places, in lengths of phalanx 2.
const THETA_1_RAD: [f32; 3] = [0.2, 0.7, 1.3];
const SHARES: [f32; 6] = [0.05, 0.2, 0.4, 0.6, 0.8, 0.97];

/// The scene's numbers, in f64.
struct Balance {
    l_1: f64,
    x_2: f64,
    pulleys: [f64; 2],
    tension: f64,
    per_m: f64,
}

const BALANCE: Balance = Balance {
    l_1: 0.090,
    x_2: 0.5,
    pulleys: [0.010, 0.010],
    tension: 3.5,
    per_m: 200.0,
};

/// A point on a pin of radius 0 and the contact force there.
#[derive(Clone, Copy, Debug)]
struct Held {
    theta_rad: [f64; 2],
    torque_nm: f64,
    force_n: f64,
}

impl Balance {
    fn pull(&self, theta_rad: [f64; 2]) -> f64 {
        let [r_1, r_2] = self.pulleys;
        self.tension + self.per_m * (r_1 * theta_rad[0] + r_2 * theta_rad[1])
    }

    /// The finger on a point pin that phalanx 2 met with joint 1 at an angle, with joint 2 turned by `theta_2`: where the phalanx still
    /// passes through the pin, and torque and force that balance both joints.
    fn on_pin(&self, theta_1: f64, k: f64, theta_2: f64) -> Held {
        let (sin, cos) = theta_1.sin_cos();
        let pin = [(self.l_1 + k) * cos, (self.l_1 + k) * sin];
        let reach = (self.l_1 + k).hypot(0.0);
        // Triangle of joint 1, joint 2 and pin: the exterior angle at joint 2 is theta_2.
        let now =
            (reach * reach - (self.l_1 * theta_2.sin()).powi(2)).sqrt() - self.l_1 * theta_2.cos();
        let joint_1 =
            pin[1].atan2(pin[0]) - (now * theta_2.sin()).atan2(self.l_1 + now * theta_2.cos());
        let theta_rad = [joint_1, theta_2];
        let arms = [now + self.l_1 * theta_2.cos(), now];
        let pull = self.pull(theta_rad);
        // T - r_1 pull = f p_1, x_2 T - r_2 pull = f p_2.
        let [r_1, r_2] = self.pulleys;
        let force_n = pull * (r_2 - self.x_2 * r_1) / (self.x_2 * arms[0] - arms[1]);
        Held {
            theta_rad,
            torque_nm: r_1 * pull + force_n * arms[0],
            force_n,
        }
    }
}

#[test]
fn a_path_begins_at_the_break_away_torque_and_keeps_the_balance() {
    let finger = Return2::MECHANISM.mounted(Mounting::LEVEL);
    let mut worst = [0.0f64; 3];
    for theta_1 in THETA_1_RAD {
        let free = finger
            .free_at_angle(theta_1, &finger.rest())
            .expect("a posture");
        let free_nm = BALANCE.pulleys[0] * BALANCE.pull([f64::from(theta_1), 0.0]);
        assert!((f64::from(free.torque_nm) / free_nm - 1.0).abs() < 1e-6);
        for share in SHARES {
            let k_m = share * 0.0675;
            let k = f64::from(k_m);
            let contact = Contact {
                phalanx: 2,
                k_m,
                radius_m: 0.0,
            };
            let statics = finger
                .stopped_contact(&free.configuration, free.torque_nm)
                .expect("a cable");
            let break_away = BALANCE.on_pin(f64::from(theta_1), k, 0.0);
            let rise = f64::from(statics.break_away_nm(k_m));
            let expected = break_away.torque_nm - free_nm;
            worst[0] = worst[0].max((rise / expected - 1.0).abs());

            let mut path = finger
                .path(&free.configuration, free.torque_nm, contact)
                .expect("presses");
            // Half way there it is rigid, and statics of joint 1 gives the force.
            let held = finger
                .follow(&mut path, 0.5 * rise as f32)
                .expect("a point");
            assert!(
                held.rotation_rad < 0.0 && held.joints_rad == [0.0; 3],
                "{held:?}"
            );
            let force = 0.5 * expected / (BALANCE.l_1 + k);
            assert!(
                (f64::from(held.force_n) / force - 1.0).abs() < 1e-5,
                "{held:?} {force}"
            );
            for theta_2 in [0.02f64, 0.1, 0.25] {
                let on_pin = BALANCE.on_pin(f64::from(theta_1), k, theta_2);
                if on_pin.force_n < 0.0 || on_pin.torque_nm > 1.0 {
                    continue;
                }
                let point = finger
                    .follow(&mut path, (on_pin.torque_nm - free_nm) as f32)
                    .expect("a point");
                let turned = on_pin.theta_rad[0] - f64::from(theta_1) + BALANCE.x_2 * theta_2;
                worst[1] = worst[1].max((f64::from(point.rotation_rad) / turned - 1.0).abs());
                worst[2] = worst[2].max((f64::from(point.force_n) / on_pin.force_n - 1.0).abs());
            }
        }
    }
    println!(
        "break-away torque {:.1e}, rotation {:.1e}, force {:.1e} of themselves",
        worst[0], worst[1], worst[2]
    );
    assert!(
        worst[0] < 2e-6 && worst[1] < 1e-3 && worst[2] < 1e-4,
        "{worst:?}"
    );
}

#[test]
fn break_away_and_stiffness_tell_the_place() {
    let finger = Return2::MECHANISM.mounted(Mounting::LEVEL);
    let length_m = finger.phalanx_length_m(2).expect("a phalanx");
    for theta_1 in THETA_1_RAD {
        let free = finger
            .free_at_angle(theta_1, &finger.rest())
            .expect("a posture");
        let (at, torque_nm) = (&free.configuration, free.torque_nm);
        let statics = finger.stopped_contact(at, torque_nm).expect("a cable");
        for share in SHARES {
            let k_m = share * length_m;
            let rise_nm = statics.break_away_nm(k_m);
            let place_m = statics.place_m(rise_nm, length_m).expect("on it");
            assert!((place_m - k_m).abs() < 2e-6 * length_m, "{k_m} {place_m}");

            // Compliance beyond, against differences of the balance.
            let near = |theta_2: f64| BALANCE.on_pin(f64::from(theta_1), f64::from(k_m), theta_2);
            let (from, to) = (near(0.0), near(1e-5));
            let turned = to.theta_rad[0] - from.theta_rad[0] + BALANCE.x_2 * 1e-5;
            let mut path = finger
                .path(
                    at,
                    torque_nm,
                    Contact {
                        phalanx: 2,
                        k_m,
                        radius_m: 0.0,
                    },
                )
                .expect("presses");
            let point = finger.follow(&mut path, rise_nm).expect("a point");
            let expected = turned / (to.torque_nm - from.torque_nm);
            let told = f64::from(point.compliance_rad_per_nm);
            assert!(
                (told / expected - 1.0).abs() < 1e-3,
                "{share}: {told} {expected}"
            );

            let compliance = finger
                .contact_compliance(at, torque_nm, 2, k_m)
                .expect("it gives way");
            for inverse in [
                finger.locate(at, torque_nm, compliance),
                finger.locate_closed(at, torque_nm, compliance),
            ] {
                assert_eq!(inverse.class(), Class::Unique);
                let [place] = inverse.candidates() else {
                    panic!("{inverse:?}");
                };
                assert!((place.k_m - k_m).abs() < 1e-5 * length_m, "{k_m} {place:?}");
            }
        }
        let proximal = finger
            .proximal_compliance(at, torque_nm)
            .expect("it gives way");
        let own = finger.free_compliance(at, torque_nm).expect("a cable");
        for (compliance, class) in [
            (0.0, Class::TooStiff),
            (1.01 * proximal, Class::Gap),
            (1.01 * own, Class::TooSoft),
            (f32::NAN, Class::Invalid),
        ] {
            assert_eq!(finger.locate(at, torque_nm, compliance).class(), class);
        }
        // No torque makes joint 2 leave its stop from e_2 on.
        let e2_m = finger
            .stiffest_m(at, torque_nm, 2)
            .expect("ahead of the joint");
        assert!((e2_m - 0.090).abs() < 1e-6);
        assert_eq!(statics.break_away_nm(e2_m), f32::INFINITY);
    }
}

/// The scene's finger with one number changed, and what the error names.
#[test]
fn what_does_not_hold_joint_2_is_refused() {
    let parameters = Parameters {
        lengths_m: [0.090, 0.0675],
        stiffness_nm_per_rad: [0.0; 2],
        rest_rad: [0.0; 2],
        range_rad: [[0.0, 2.4], [0.0, 1.9]],
    };
    let cable = ReturnCable {
        ratio: 1.0,
        torque_nm: 0.035,
        stiffness_nm_per_rad: 0.02,
    };
    let radii_m = [0.010, 0.005];
    assert!(Finger::returned(parameters, radii_m, cable).is_ok());
    let sprung = Parameters {
        stiffness_nm_per_rad: [0.0, 0.1],
        ..parameters
    };
    let lifted = Parameters {
        rest_rad: [0.0, 0.1],
        ..parameters
    };
    for (parameters, cable, named) in [
        (sprung, cable, Parameter::Stiffness { joint: 2 }),
        (lifted, cable, Parameter::RestAngle { joint: 2 }),
        (
            parameters,
            ReturnCable {
                ratio: 0.5,
                ..cable
            },
            Parameter::ReturnRatio,
        ),
        (
            parameters,
            ReturnCable {
                torque_nm: 0.0,
                ..cable
            },
            Parameter::ReturnTorque,
        ),
        (
            parameters,
            ReturnCable {
                stiffness_nm_per_rad: f32::NAN,
                ..cable
            },
            Parameter::ReturnStiffness,
        ),
    ] {
        let error = Finger::returned(parameters, radii_m, cable).expect_err("refused");
        assert_eq!(error.parameter, named, "{error}");
    }
}

#[test]
fn a_preloaded_spring_lets_go_at_its_break_away_torque() {
    let finger = P70Preloaded::MECHANISM;
    let length_m = finger.phalanx_length_m(2).expect("a phalanx");
    let held_nm = finger.preload_nm();
    assert!((held_nm / (0.05 * 12f32.to_radians()) - 1.0).abs() < 1e-6);
    for theta_1 in THETA_1_RAD {
        let free = finger
            .free_at_angle(theta_1, &finger.rest())
            .expect("a posture");
        let statics = finger
            .stopped_contact(&free.configuration, free.torque_nm)
            .expect("a preload");
        // beta = p_1/p_2: T_b = beta P/(beta x_2 - 1).
        for share in SHARES {
            let k_m = share * length_m;
            let rise_nm = statics.break_away_nm(k_m);
            let beta = (statics.c_m + k_m) / k_m;
            let expected_nm = beta * held_nm / (beta * statics.x2 - 1.0);
            assert!((rise_nm / expected_nm - 1.0).abs() < 1e-5, "{share}");
            let place_m = statics.place_m(rise_nm, length_m).expect("on it");
            assert!((place_m - k_m).abs() < 2e-6 * length_m, "{k_m} {place_m}");
            // The path turns from there on. Nearer to the tip the finger gives way beyond the probing's torque, and by then jumps.
            if rise_nm > 0.35 {
                continue;
            }
            let contact = Contact {
                phalanx: 2,
                k_m,
                radius_m: 0.0,
            };
            let mut path = finger
                .path(&free.configuration, free.torque_nm, contact)
                .expect("presses");
            let [before, after] = [0.99, 1.01]
                .map(|share| finger.follow(&mut path, share * rise_nm).expect("a point"));
            assert!(before.rotation_rad < 0.0 && before.joints_rad == [0.0; 3]);
            assert!(after.rotation_rad > 0.0 && after.joints_rad[1] > 0.0);
            let balanced_n = 1.01 * rise_nm / (statics.c_m + k_m);
            assert!((after.force_n / balanced_n - 1.0).abs() < 0.02, "{after:?}");
        }
    }
}

/// Pulleys that are off move the break-away torque. A pin at a known place takes most of that into the torque factor: how far the
/// places are off elsewhere, against those without a pin.
#[test]
fn pins_leave_a_third_of_what_pulleys_are_off_by() {
    const SHARES: [f64; 2] = [0.3, 0.75];
    let real = Balance {
        x_2: 1.01 * BALANCE.x_2,
        ..BALANCE
    };
    let excess_nm = |of: &Balance, theta_1: f64, k: f64| {
        of.on_pin(theta_1, k, 0.0).torque_nm - of.pulleys[0] * of.pull([theta_1, 0.0])
    };
    // Where the drawing's finger shows a torque.
    let place = |theta_1: f64, torque_nm: f64| {
        let [mut low, mut high] = [-0.05, 0.085];
        while high - low > 1e-9 {
            let middle = 0.5 * (low + high);
            if excess_nm(&BALANCE, theta_1, middle) < torque_nm {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    };
    // The torque factor of a pin, each weighted as a place that is off says.
    let (mut sum, mut weights) = (0.0, 0.0);
    for share in SHARES {
        let (theta_1, k) = (0.6, 0.0675 * share);
        let shown_nm = excess_nm(&real, theta_1, k);
        let told_nm = excess_nm(&BALANCE, theta_1, k);
        let by_factor = place(theta_1, 1.01 * told_nm) - place(theta_1, 0.99 * told_nm);
        sum += by_factor * by_factor * told_nm / shown_nm;
        weights += by_factor * by_factor;
    }
    let factor = sum / weights;
    let rms_m = |factor: f64| {
        let squares: Vec<f64> = (THETA_1_RAD.into_iter().map(f64::from))
            .flat_map(|theta_1| {
                (0..17).map(move |i| (theta_1, 0.0675 * (0.1 + 0.05 * f64::from(i))))
            })
            .map(|(theta_1, k)| place(theta_1, factor * excess_nm(&real, theta_1, k)) - k)
            .map(|off| off * off)
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let (without, with) = (rms_m(1.0), rms_m(factor));
    let left = with / without;
    println!(
        "1 % of x_2 is {:.2} mm without pins, {:.2} mm with: {left:.2} of it",
        1e3 * without,
        1e3 * with,
    );
    let allowed = f64::from(<<Return2 as Scene>::Finger as Mechanics>::PINS_LEAVE);
    assert!((0.25..allowed).contains(&left), "{left}");
}
