//! What becomes of a contact while the motor holds it with a constant current.

use super::changes::{Held, contact_nm, held};
use super::{STEP_RAD, Way, friction_a};
use crate::finger::Contact;
use crate::sensing::{Change, Directive, Drive, Event};

/// The holding current makes so much at the input link, above friction, newton metre.
fn holding_nm(hand: &Held, current_a: f32) -> f32 {
    let drivetrain = hand.sensor.drivetrain();
    let above_a = current_a - friction_a(hand.angle_rad);
    drivetrain.efficiency * drivetrain.torque_per_ampere_nm * above_a
}

/// The motor stands at 0.05 A, and then turns without load, by so much at most.
fn released(level_nm: f32, way_rad: f32) -> (Held, Vec<(u64, Change, f32, f32)>) {
    let mut hand: Held = held();
    hand.level_nm = level_nm;
    hand.watch(1.1, contact_nm);
    // The place is told while it stands.
    let quiet = hand.stand(1500, 0.05);
    assert_eq!((quiet.changes(), quiet.moved().is_some()), (vec![], true));
    let drivetrain = *hand.sensor.drivetrain();
    let drives_nm = drivetrain.torque_per_ampere_nm * (0.05 - friction_a(hand.angle_rad));
    let by = (drives_nm - level_nm / drivetrain.efficiency) / drivetrain.inertia_kg_m2;
    let mut told = hand.turn(30, 0.05, |s| (0.5 * by * s * s).min(way_rad));
    let rest = hand.stand(200, 0.05);
    told.followed.extend(rest.followed);
    let changes = told.changes();
    (hand, changes)
}

#[test]
fn what_the_motor_holds_is_told_when_it_goes() {
    for level_nm in [0.0, 8e-3] {
        let (hand, told) = released(level_nm, 1.0);
        let [(_, Change::Lost, from_nm, to_nm)] = told[..] else {
            panic!("{told:?}");
        };
        let holding_nm = holding_nm(&hand, 0.05) - level_nm;
        assert!((from_nm - holding_nm).abs() < 4e-3, "{told:?} {holding_nm}");
        assert!(to_nm.abs() < 0.3 * from_nm, "{told:?}");
    }
}

/// It starts, and stands again before it has made a turn.
#[test]
fn what_gives_way_in_the_hold_slips() {
    let (hand, told) = released(0.0, 3e-3);
    let [(_, Change::Slipped, from_nm, to_nm)] = told[..] else {
        panic!("{told:?}");
    };
    let holding_nm = holding_nm(&hand, 0.05);
    assert!(
        from_nm.is_nan() && (to_nm - holding_nm).abs() < 4e-3,
        "{told:?} {holding_nm}"
    );
}

/// A motor that stood at the limit of its current while it probed, and turns on because the object gave way, is watched as one that
/// never stood: what it stood with holds nothing any more.
#[test]
fn what_stood_while_probing_is_watched_on() {
    for (to_nm, change) in [(0.05, Change::Slipped), (0.0, Change::Lost)] {
        let mut hand: Held = held();
        hand.watch(1.1, contact_nm);
        let stood_a = hand.current_a(contact_nm(1.1));
        let mut told = hand.turn(100, stood_a, |s| 0.3 * s - 1.5 * s * s).changes();
        told.extend(hand.stand(60, stood_a).changes());
        assert_eq!(told, []);
        told = hand.close(1.25, |_| 0.12).changes();
        let begun_ms = hand.ms;
        told.extend(hand.close(1.4, |_| to_nm).changes());
        let [(_, Change::Slipped, ..), (ms, what, from_nm, left_nm)] = told[..] else {
            panic!("{to_nm}: {told:?}");
        };
        assert_eq!(what, change, "{told:?}");
        assert!(
            (begun_ms..begun_ms + 50).contains(&ms),
            "{begun_ms}: {told:?}"
        );
        assert!(
            (from_nm - 0.12).abs() < 6e-3 && (left_nm - to_nm).abs() < 6e-3,
            "{told:?}"
        );
    }
}

/// A force is that of the angle at which the last word on it comes: after a stop that of the angle that the worm holds, and none where the
/// finger has been opened meanwhile.
#[test]
fn a_force_is_that_of_the_finger_as_it_stands() {
    let force_n = |back_rad: f32| {
        let mut hand: Held = held();
        let contact = Contact {
            phalanx: 2,
            k_m: 0.04,
            radius_m: 0.014,
        };
        let way = Way::of(&hand.sensor, 0.8, contact, 0.2);
        hand.watch(way.end_rad(), |theta| way.rise_nm(theta));
        hand.direct(Directive::Rest);
        let steps = (back_rad / (10.0 * STEP_RAD)) as i32;
        for _ in 0..steps {
            hand.angle_rad -= 10.0 * STEP_RAD;
            hand.sample(Drive::Opening, -friction_a(hand.angle_rad));
        }
        let rise_nm = way.rise_nm(hand.theta_a_rad());
        let told = hand.stand(1500, 0.0);
        let force_n = told.events.iter().find_map(|(_, event)| match *event {
            Event::Located {
                force_n,
                settled: true,
                ..
            } => Some(force_n),
            _ => None,
        });
        (force_n.expect("a place"), rise_nm)
    };
    let (stopped_n, stopped_nm) = force_n(0.0);
    assert!((1.4..1.8).contains(&stopped_n), "{stopped_n}");
    // The lever hardly changes.
    let (opened_n, opened_nm) = force_n(0.1);
    let share = opened_n / stopped_n;
    assert!((share - opened_nm / stopped_nm).abs() < 0.1, "{share}");
    let (gone_n, gone_nm) = force_n(0.4);
    assert!(gone_nm == 0.0 && gone_n < 0.01, "{gone_n}");
}
