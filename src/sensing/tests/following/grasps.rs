//! How an object is held at the end of a closing.

use super::{CALIBRATION, Hand, Told, Way, p70, to_the_end};
use crate::finger::Contact;
use crate::scene::{P70, Scene};
use crate::sensing::{Directive, Event, Follow, Followed, Grip, Settings};

type Finger = <P70 as Scene>::Finger;
type Grasping = Hand<Finger, Follow<Finger>>;

/// A contact at 0.8 rad, and another at an angle, from which on only the cable gives way.
fn contacts_nm(theta_a_rad: f32, second_rad: f32) -> f32 {
    let cable = 1.0 / CALIBRATION.cable_rad_per_nm;
    0.4 * (theta_a_rad - 0.8).max(0.0) + (cable - 0.4) * (theta_a_rad - second_rad).max(0.0)
}

const ONE: f32 = f32::INFINITY;

/// Whether nothing is held, by no force that is known.
fn is_lost(followed: &Followed) -> bool {
    matches!(followed, Followed::Grasp { grip: Grip::Lost, torque_nm, forces }
        if torque_nm.abs() < 1e-3 && forces.distal_moment_nm.is_nan())
}

/// Whether all that was told is that the contact is lost.
fn is_lost_alone(told: &Told) -> bool {
    matches!(told.followed[..], [(_, last)] if is_lost(&last))
}

/// How the object was held by one contact, and the torque above friction; nothing else was told.
#[track_caller]
fn held_by_one(told: &Told) -> (Grip, f32) {
    match told.followed[..] {
        [
            (
                _,
                Followed::Grasp {
                    grip, torque_nm, ..
                },
            ),
        ] => (grip, torque_nm),
        _ => panic!("{told:?}"),
    }
}

/// One contact, two, and one that is lost, one closing after another, whatever friction is over that of the record.
#[test]
fn every_closing_tells_how_it_ends() {
    for level_nm in [0.0, -4e-3, 8e-3] {
        let mut hand: Grasping = p70(to_the_end::<P70>());
        hand.level_nm = level_nm;
        for _ in 0..2 {
            let told = hand.watch(1.2, |theta| contacts_nm(theta, ONE));
            assert_eq!((told.touches(), &told.followed[..]), (1, &[][..]));
            let told = hand.stand(1500, 0.0);
            let (grip, torque_nm) = held_by_one(&told);
            assert_eq!(grip, Grip::Single);
            // The last turn ended at most two before the end.
            assert!((torque_nm - 0.158).abs() < 3e-3, "{level_nm}: {told:?}");
            hand.open();

            let told = hand.watch(1.3, |theta| contacts_nm(theta, 1.0).min(0.3));
            let [
                (
                    second_ms,
                    Followed::SecondContact {
                        phalanx: 1,
                        theta_a_rad,
                        torque_nm,
                        stiffness_nm_per_rad,
                        stiffness_sigma_nm_per_rad,
                        ..
                    },
                ),
                (
                    grasp_ms,
                    Followed::Grasp {
                        grip: Grip::Enveloped,
                        torque_nm: end_nm,
                        ..
                    },
                ),
            ] = told.followed[..]
            else {
                panic!("{level_nm}: {told:?}");
            };
            assert!(
                Some(second_ms) >= told.settled_ms() && grasp_ms >= second_ms,
                "{told:?}"
            );
            assert!((theta_a_rad - 1.0).abs() < 5e-3, "{told:?}");
            assert!((torque_nm - 0.08).abs() < 8e-3 && end_nm > 0.1, "{told:?}");
            let off = stiffness_nm_per_rad - 1.0 / CALIBRATION.cable_rad_per_nm;
            assert!(off.abs() < 2.0 * stiffness_sigma_nm_per_rad, "{told:?}");
            assert_eq!(hand.stand(1500, 0.0).followed, []);
            hand.open();

            let told = hand.watch(1.3, |theta| {
                if theta < 1.1 {
                    contacts_nm(theta, ONE)
                } else {
                    0.0
                }
            });
            let mut told = told.followed;
            told.extend(hand.stand(1500, 0.0).followed);
            let [
                (
                    _,
                    Followed::Grasp {
                        grip: Grip::Lost,
                        torque_nm,
                        ..
                    },
                ),
            ] = told[..]
            else {
                panic!("{told:?}");
            };
            assert!(torque_nm.abs() < 1e-3, "{level_nm}: {told:?}");
            hand.open();

            assert_eq!(hand.watch(1.3, |_| 0.0).followed, []);
            assert_eq!(hand.stand(1500, 0.0).followed, []);
            hand.open();
        }
    }
}

/// Nor has a closing anything of the last where the finger opens under the same directive.
#[test]
fn a_closing_under_the_same_directive_begins_anew() {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    hand.direct(Directive::Watch);
    for second_rad in [1.0, 1.1, ONE, 1.0] {
        let mut told = hand.close(1.25, |theta| contacts_nm(theta, second_rad).min(0.3));
        told.followed.extend(hand.stand(1500, 0.0).followed);
        let grip = if second_rad == ONE {
            held_by_one(&told).0
        } else {
            let [
                (_, Followed::SecondContact { theta_a_rad, .. }),
                (_, Followed::Grasp { grip, .. }),
            ] = told.followed[..]
            else {
                panic!("{second_rad}: {told:?}");
            };
            assert!((theta_a_rad - second_rad).abs() < 5e-3, "{told:?}");
            grip
        };
        let is_single = grip == Grip::Single;
        assert_eq!(is_single, second_rad == ONE, "{second_rad}: {told:?}");
        assert_eq!(hand.open().followed, []);
    }
}

/// At the torque at which probing ends the closing is over, although the motor turns on: what comes then is no second contact.
#[test]
fn enough_torque_ends_a_closing() {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    let enough_nm = hand.sensor.settings().enough_nm();
    let curve = |theta: f32| 0.6 * (theta - 0.8).max(0.0) + 0.65 * (theta - 1.38).max(0.0);
    let mut told = hand.watch(1.48, curve);
    told.followed.extend(hand.stand(1500, 0.0).followed);
    let (grip, torque_nm) = held_by_one(&told);
    assert_eq!(grip, Grip::Single);
    assert!(torque_nm >= enough_nm, "{torque_nm}");
}

/// The next closing has nothing of one whose end was not told yet.
#[test]
fn a_closing_that_is_broken_off_is_forgotten() {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    hand.watch(1.0, |theta| contacts_nm(theta, ONE));
    hand.sensor.conclude();
    let told = hand.close(1.4, |theta| contacts_nm(theta, ONE));
    assert!(told.settled_ms().is_some() && told.followed.is_empty());
    hand.direct(Directive::Watch);
    assert_eq!(hand.open().followed, []);
    assert_eq!(hand.watch(1.3, |_| 0.0).followed, []);
}

/// Once the first contact is judged the end is told when the motor is to rest, and not later than a quarter of a second after it stands.
#[test]
fn rest_ends_a_closing_at_once() {
    for rests in [true, false] {
        let mut hand: Grasping = p70(to_the_end::<P70>());
        hand.watch(1.0, |theta| contacts_nm(theta, ONE));
        hand.sensor.conclude();
        let told = hand.close(1.4, |theta| contacts_nm(theta, ONE));
        assert!(
            told.settled_ms().is_some() && told.followed.is_empty(),
            "{told:?}"
        );
        let stands_ms = hand.ms;
        if rests {
            hand.direct(Directive::Rest);
        }
        let told = hand.stand(1500, 0.0);
        assert_eq!(held_by_one(&told).0, Grip::Single);
        let after_ms = told.followed[0].0 - stands_ms;
        let expected_ms = if rests { 0..5 } else { 200..260 };
        assert!(expected_ms.contains(&after_ms), "{rests}: {told:?}");
    }
}

/// Closes, holds and asserts what grasp is told: alone where it is a single contact.
#[track_caller]
fn grasps(hand: &mut Grasping, second_rad: f32, grip: Grip) {
    let mut told = hand.watch(1.25, |theta| contacts_nm(theta, second_rad));
    told.followed.extend(hand.stand(1500, 0.0).followed);
    let last = told.followed.last();
    assert!(
        matches!(last, Some((_, Followed::Grasp { grip: told, .. })) if *told == grip),
        "{told:?}"
    );
    assert_eq!(told.followed.len() == 1, grip == Grip::Single, "{told:?}");
}

/// A first contact's finger that comes to its stop has only the cable left, as one that is enveloped.
#[test]
fn the_stop_is_no_second_contact() {
    // Behind a cable that is twisted by 0.8 rad for a newton metre the input link is at 1 rad then.
    let stop_rad = (1.0 - 0.8 * 0.8 * 0.4) / (1.0 - 0.8 * 0.4);
    for (closing_stop_rad, grip) in [(1.0, Grip::Single), (1.6, Grip::Enveloped)] {
        let mut hand: Grasping = p70(Settings {
            closing_stop_rad,
            ..to_the_end::<P70>()
        });
        grasps(&mut hand, stop_rad, grip);
    }
}

/// Nor is the end of the travel.
#[test]
fn the_end_of_the_travel_is_no_second_contact() {
    for (travel_rad, grip) in [(1.1, Grip::Single), (1.5, Grip::Enveloped)] {
        let mut hand: Grasping = p70(to_the_end::<P70>());
        hand.sensor.set_settings(Settings {
            travel_rad,
            ..to_the_end::<P70>()
        });
        grasps(&mut hand, 1.1, grip);
    }
}

/// The motor slows down over some turns and goes on with the current that holds: that is no torque of the finger.
#[test]
fn a_break_in_the_motion_is_no_second_contact() {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    hand.watch(1.1, |theta| contacts_nm(theta, ONE));
    let current_a = hand.current_a(0.2);
    let mut told = hand.turn(150, current_a, |s| 0.1 * s);
    let slow_rad = hand.theta_a_rad();
    let on = hand.close(1.2, |theta| 0.2 + 1.2 * (theta - slow_rad));
    told.followed.extend(on.followed);
    told.followed.extend(hand.stand(1500, 0.0).followed);
    let (grip, torque_nm) = held_by_one(&told);
    assert_eq!(grip, Grip::Single);
    // Not more than the finger took before the motor slowed down.
    let before_nm = contacts_nm(1.1, ONE);
    assert!(
        (before_nm - 8e-3..before_nm + 1e-3).contains(&torque_nm),
        "{torque_nm}"
    );
}

/// A corner that only the very block shows in which it is sure that the contact has let go is no second contact.
#[test]
fn what_a_lost_contact_shows_is_no_second_contact() {
    for half_blocks in 4..20 {
        let lost_rad = 0.95 + 2.45e-3 * half_blocks as f32;
        let mut hand: Grasping = p70(to_the_end::<P70>());
        let mut told = hand.watch(lost_rad + 0.1, |theta| {
            if theta < lost_rad {
                0.9 * (theta - 0.8).max(0.0) + 0.35 * (theta - 0.95).max(0.0)
            } else {
                0.0
            }
        });
        told.followed.extend(hand.stand(1500, 0.0).followed);
        // The corner has too few points after it; and at 15 the pair that shows it ends with the second block below.
        if half_blocks < 12 || half_blocks == 15 {
            assert_eq!(held_by_one(&told).0, Grip::Lost, "{half_blocks}");
        } else {
            let [(_, Followed::SecondContact { .. }), (_, last)] = told.followed[..] else {
                panic!("{half_blocks}: {told:?}");
            };
            assert!(is_lost(&last), "{half_blocks}: {told:?}");
        }
    }
}

/// One contact that lets go after the closing is over, while the last word on it is still to come, is lost as well.
#[test]
fn what_lets_go_before_the_last_word_is_lost() {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    let enough_nm = hand.sensor.settings().enough_nm();
    let enough_rad = 0.8 + enough_nm / 0.6;
    let mut told = hand.watch(enough_rad + 0.12, |theta| {
        if theta < enough_rad + 0.01 {
            0.6 * (theta - 0.8).max(0.0)
        } else {
            0.0
        }
    });
    told.followed.extend(hand.stand(1500, 0.0).followed);
    assert!(is_lost_alone(&told), "{told:?}");
}

/// So is one that the motor, which runs faster for a moment, is out of before it turns steadily again, to the end of its travel too.
#[test]
fn what_frees_the_motor_is_lost() {
    for travel_rad in [1.1, 1.5] {
        let mut hand: Grasping = p70(to_the_end::<P70>());
        hand.sensor.set_settings(Settings {
            travel_rad,
            ..to_the_end::<P70>()
        });
        hand.watch(1.0, |theta| contacts_nm(theta, ONE));
        let current_a = hand.current_a(0.0);
        let mut told = hand.turn(40, current_a, |s| 0.5 * s);
        told.followed.extend(hand.close(1.2, |_| 0.0).followed);
        told.followed.extend(hand.stand(1500, 0.0).followed);
        assert!(is_lost_alone(&told), "{travel_rad}: {told:?}");
    }
}

/// A contact that ends at rest is the last one until the next directive, whatever the motor does meanwhile: a self-test closes too.
#[test]
fn nothing_is_felt_at_rest_after_a_contact() {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    hand.watch(1.1, |theta| contacts_nm(theta, ONE));
    hand.direct(Directive::Rest);
    assert!(hand.stand(1500, 0.0).settled_ms().is_some());
    hand.open();
    let told = hand.close(1.2, |theta| contacts_nm(theta, ONE));
    assert_eq!((told.events, told.followed), (vec![], vec![]));
}

/// Closes on a contact on phalanx 2, and by so many turns farther than to another, and stands for a time before the motor is to rest. The
/// first contact's place and force, and what else was told.
fn stopped(k_m: f32, turns: u8, idle_ms: u64) -> (Option<[f32; 2]>, Vec<Followed>) {
    let mut hand: Grasping = p70(to_the_end::<P70>());
    let contact = Contact {
        phalanx: 2,
        k_m,
        radius_m: 0.014,
    };
    let way = Way::of(&hand.sensor, 0.8, contact, 0.1);
    let cable = 1.0 / CALIBRATION.cable_rad_per_nm;
    let mut told = hand.watch(way.end_rad() + 4.9e-3 * f32::from(turns), |theta| {
        way.rise_nm(theta) + cable * (theta - way.end_rad()).max(0.0)
    });
    let mut add = |more: Told| {
        told.events.extend(more.events);
        told.followed.extend(more.followed);
    };
    add(hand.stand(idle_ms, 0.0));
    hand.direct(Directive::Rest);
    add(hand.stand(1500, 0.0));
    let located = told.events.iter().find_map(|(_, event)| match *event {
        Event::Located {
            settled: true,
            k_m,
            force_n,
            ..
        } => Some([k_m, force_n]),
        _ => None,
    });
    let followed = told.followed.into_iter();
    (located, followed.map(|(_, followed)| followed).collect())
}

/// A closing that is stopped just after a second contact, by its user or by a fault, which has the bridge off before the sensing hears of
/// it, tells both; the place of the first follows from what was before the second.
#[test]
fn a_stop_in_a_second_contact_tells_both() {
    for (k_m, from) in [(0.03, 4), (0.05, 6)] {
        let (wanted, _) = stopped(k_m, 24, 0);
        let [wanted_m, _] = wanted.expect("a place");
        for turns in from..from + 4 {
            for idle_ms in [0, 2] {
                let (located, followed) = stopped(k_m, turns, idle_ms);
                let case = format!("{k_m} {turns} {idle_ms}: {wanted_m} {located:?} {followed:?}");
                let [told_m, force_n] = located.expect("a place");
                assert!(
                    (told_m - wanted_m).abs() < 1e-5 && force_n.is_nan(),
                    "{case}"
                );
                let [Followed::SecondContact { .. }, Followed::Grasp { grip, .. }] = followed[..]
                else {
                    panic!("{case}");
                };
                assert_eq!(grip, Grip::Enveloped, "{case}");
            }
        }
    }
}
