//! Where a contact has come to as the finger closed on, against the path that it took.

use super::{CALIBRATION, Hand, Way, p70, to_the_end};
use crate::finger::{Contact, Mechanics};
use crate::scene::{P70, Scene, Tendon2};
use crate::sensing::{Changes, Event, FirstContactOnly, Followed, Sensor};

/// Closes on a contact on phalanx 2 until the torque has risen by so much. The place that was told of the contact's beginning and of its
/// end, with its deviation, and both as they are, metre.
fn places<F: Mechanics>(
    hand: &mut Hand<F, Changes<FirstContactOnly>>,
    onset_rad: f32,
    k_m: f32,
    rise_nm: f32,
) -> [[f32; 2]; 3] {
    let contact = Contact {
        phalanx: 2,
        k_m,
        radius_m: 0.014,
    };
    let way = Way::of(&hand.sensor, onset_rad, contact, rise_nm);
    let [.., end_m] = way.points[way.points.len() - 1];
    let rests = |theta| {
        hand.sensor
            .free_at(theta)
            .map_or(0.0, |free| free.torque_nm)
    };
    let onset_nm = rests(onset_rad);
    let rests_nm: Vec<f32> = (0..=500)
        .map(|i| rests(onset_rad + (way.end_rad() - onset_rad) * i as f32 / 500.0))
        .collect();
    // Over what the free finger would take there.
    let beyond_nm = |theta: f32| {
        let share = (theta - onset_rad) / (way.end_rad() - onset_rad);
        let rests_nm = rests_nm[((500.0 * share) as usize).min(500)];
        if share > 0.0 {
            way.rise_nm(theta) + onset_nm - rests_nm
        } else {
            0.0
        }
    };
    let mut told = hand.watch(way.end_rad(), beyond_nm);
    let rest = hand.stand(1500, 0.0);
    told.events.extend(rest.events);
    told.followed.extend(rest.followed);
    let located = told.events.iter().find_map(|(_, event)| match *event {
        Event::Located {
            phalanx: 2,
            k_m,
            sigma_m,
            settled: true,
            ..
        } => Some([k_m, sigma_m]),
        _ => None,
    });
    let [
        (
            _,
            Followed::Moved {
                phalanx: 2,
                k_m: moved_m,
                sigma_m,
                torque_nm,
            },
        ),
    ] = told.followed[..]
    else {
        panic!("{told:?}");
    };
    let end_nm = beyond_nm(way.end_rad());
    assert!((torque_nm - end_nm).abs() < 8e-3, "{torque_nm} {end_nm}");
    [located.expect("a place"), [moved_m, sigma_m], [k_m, end_m]]
}

#[track_caller]
fn is_right([[k_m, _], [moved_m, sigma_m], [true_m, end_m]]: [[f32; 2]; 3]) {
    let case = format!("{k_m} {moved_m} {sigma_m}, {true_m} {end_m}");
    assert!((k_m - true_m).abs() < 0.6e-3, "{case}");
    assert!((moved_m - end_m).abs() < 1e-3 && sigma_m < 7e-3, "{case}");
    assert!(end_m - true_m > 4e-3, "{case}");
}

/// It rolls by up to 14 mm.
#[test]
fn a_contact_is_followed_along_its_path() {
    for k_m in [0.03, 0.04] {
        for rise_nm in [0.1, 0.2, 0.3] {
            let mut hand = p70(to_the_end::<P70>());
            is_right(places(&mut hand, 0.8, k_m, rise_nm));
        }
    }
}

/// Springs take some of the torque at the onset already, and more of it as the finger closes on.
#[test]
fn it_is_followed_on_a_finger_with_springs() {
    let finger = Tendon2::MECHANISM;
    let drivetrain = Tendon2::drivetrain(&finger);
    for k_m in [0.015, 0.025, 0.035] {
        for rise_nm in [0.1, 0.2, 0.3] {
            let settings = to_the_end::<Tendon2>();
            let sensor = Sensor::new(finger, drivetrain, settings, CALIBRATION);
            let mut hand = Hand::new(sensor, 2.1);
            let onset_rad = drivetrain.closing_rad(0) + 0.7;
            is_right(places(&mut hand, onset_rad, k_m, rise_nm));
        }
    }
}
