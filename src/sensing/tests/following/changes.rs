//! What becomes of a contact that is held.

use super::{Hand, p70, to_the_end};
use crate::finger::{HeldForces, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::scene::{P70, Scene};
use crate::sensing::{
    AfterContact, Change, Changes, Directive, Event, FirstContactOnly, Follow, Followed, Grip,
    Sample, Sensor, SeriesElement,
};

pub(super) type Held<A = FirstContactOnly> = Hand<<P70 as Scene>::Finger, Changes<A>>;

pub(super) fn held<A: AfterContact<<P70 as Scene>::Finger>>() -> Held<A> {
    p70(to_the_end::<P70>())
}

/// A contact at 0.8 rad, as stiff as one in the middle of the distal phalanx.
pub(super) fn contact_nm(theta_a_rad: f32) -> f32 {
    0.6 * (theta_a_rad - 0.8).max(0.0)
}

/// When a closing that began at a time comes by an angle, millisecond.
fn ms_at(hand: &Held, begun_ms: u64, theta_a_rad: f32) -> u64 {
    let from_rad = hand.sensor.drivetrain().closing_rad(0);
    begun_ms + ((theta_a_rad - from_rad) / super::STEP_RAD) as u64
}

/// Slips, is pushed, and is lost. Torques are above friction, whatever that does.
#[test]
fn a_contact_tells_what_becomes_of_it() {
    for level_nm in [0.0, -4e-3, 8e-3] {
        let mut hand: Held = held();
        hand.level_nm = level_nm;
        let begun_ms = hand.ms;
        let told = hand.watch(1.4, |theta| {
            contact_nm(theta)
                + if theta < 1.0 {
                    0.0
                } else if theta < 1.15 {
                    -0.03
                } else if theta < 1.25 {
                    0.05
                } else {
                    -contact_nm(theta)
                }
        });
        let happened = [
            (1.0, Change::Slipped, 0.12, 0.09),
            (1.15, Change::Pushed, 0.18, 0.26),
            (1.25, Change::Lost, 0.32, 0.0),
        ];
        assert_eq!(told.touches(), 1);
        assert_eq!(told.changes().len(), happened.len(), "{told:?}");
        for (told, (at_rad, change, from_nm, to_nm)) in told.changes().into_iter().zip(happened) {
            let at_ms = ms_at(&hand, begun_ms, at_rad);
            let case = format!("{level_nm} {at_ms} {change:?}: {told:?}");
            assert!((at_ms..at_ms + 50).contains(&told.0), "{case}");
            assert_eq!(told.1, change, "{case}");
            // It rises by 3 mN m a turn.
            assert!((told.2 - from_nm).abs() < 6e-3, "{case}");
            assert!((told.3 - to_nm).abs() < 6e-3, "{case}");
        }
        // Its place is not known any more.
        assert_eq!(told.followed.len(), happened.len(), "{told:?}");
        assert_eq!(hand.stand(1500, 0.0).followed, []);
    }
}

/// A contact to which nothing happens has a place at the end; the next closing, on nothing, has nothing of it.
#[test]
fn a_closing_knows_nothing_of_the_last() {
    for (rests, level_nm) in [(true, 0.0), (false, 8e-3)] {
        let mut hand: Held = held();
        hand.level_nm = level_nm;
        for closing in 0..2 {
            let mut told = hand.watch(1.2, contact_nm);
            assert_eq!((told.touches(), &told.followed[..]), (1, &[][..]));
            if rests {
                hand.direct(Directive::Rest);
            }
            // The last word on the contact and its place are still due.
            told = hand.stand(1500, 0.0);
            let [(_, Followed::Moved { torque_nm, .. })] = told.followed[..] else {
                panic!("{rests} {closing}: {told:?}");
            };
            assert!(told.settled_ms().is_some());
            assert!((torque_nm - 0.237).abs() < 3e-3, "{level_nm}: {torque_nm}");
            assert_eq!(hand.open().followed, []);
            let told = hand.watch(1.4, |_| 0.0);
            assert_eq!((told.touches(), &told.followed[..]), (0, &[][..]));
            hand.open();
        }
    }
}

/// Nor where the finger opens under the same directive: what was held is not lost when it opens, nor when it closes again.
#[test]
fn what_was_held_is_not_lost_by_opening() {
    let mut hand: Held = held();
    hand.direct(Directive::Watch);
    for closing in 0..2 {
        let told = hand.close(1.2, contact_nm);
        assert_eq!(
            (told.touches(), &told.followed[..]),
            (1, &[][..]),
            "{closing}"
        );
        let told = hand.stand(1500, 0.05);
        assert!(
            told.moved().is_some() && told.changes().is_empty(),
            "{told:?}"
        );
        assert_eq!(hand.open().followed, []);
        let told = hand.close(1.4, |_| 0.0);
        assert_eq!(
            (told.touches(), &told.followed[..]),
            (0, &[][..]),
            "{closing}"
        );
        assert_eq!(hand.open().followed, []);
    }
}

#[test]
fn what_is_lost_is_watched_no_more() {
    let mut hand: Held = held();
    let told = hand.watch(1.4, |theta| {
        if theta < 1.0 {
            contact_nm(theta)
        } else if theta < 1.3 {
            0.6 * (theta - 1.1).max(0.0)
        } else {
            0.0
        }
    });
    assert!(
        matches!(told.changes()[..], [(_, Change::Lost, ..)]),
        "{told:?}"
    );
    assert_eq!(hand.stand(1500, 0.0).changes(), []);
}

/// What was felt before a slip is not felt to fade after it.
#[test]
fn a_slip_is_told_once() {
    let mut hand: Held = held();
    let told = hand.watch(
        1.4,
        |theta| {
            if theta < 1.1 { contact_nm(theta) } else { 0.12 }
        },
    );
    let [(_, Change::Slipped, from_nm, to_nm)] = told.changes()[..] else {
        panic!("{told:?}");
    };
    assert!(
        (from_nm - 0.18).abs() < 6e-3 && (to_nm - 0.12).abs() < 3e-3,
        "{told:?}"
    );
}

/// What a slip has left goes while the finger may still swing: that is told afterwards.
#[test]
fn what_a_slip_has_left_may_go_at_once() {
    let mut hand: Held = held();
    let told = hand.watch(1.4, |theta| {
        if theta < 1.1 {
            contact_nm(theta)
        } else if theta < 1.12 {
            0.12
        } else {
            0.0
        }
    });
    let [
        (slip_ms, Change::Slipped, ..),
        (lost_ms, Change::Lost, from_nm, to_nm),
    ] = told.changes()[..]
    else {
        panic!("{told:?}");
    };
    assert!((100..180).contains(&(lost_ms - slip_ms)), "{told:?}");
    assert!(
        (from_nm - 0.12).abs() < 3e-3 && to_nm.abs() < 1e-3,
        "{told:?}"
    );
}

/// For a tenth of a second after a change it swings, whatever that looks like.
#[test]
fn a_finger_that_swings_after_a_slip_is_not_pushed() {
    for swing_nm in [0.05, -0.03] {
        let mut hand: Held = held();
        let told = hand.watch(1.3, |theta| {
            contact_nm(theta)
                + if theta < 1.0 {
                    0.0
                } else if (1.017..1.026).contains(&theta) {
                    swing_nm - 0.05
                } else {
                    -0.05
                }
        });
        assert!(
            matches!(told.changes()[..], [(_, Change::Slipped, ..)]),
            "{swing_nm}: {told:?}"
        );
    }
}

/// Where a contact was felt says nothing any more after a push; the sensor's last word on it comes all the same.
#[test]
fn a_contact_that_was_pushed_has_no_place() {
    for by_nm in [0.0, 0.1] {
        let mut hand: Held = held();
        let mut told = hand.watch(1.2, |theta| {
            contact_nm(theta) + if theta < 1.1 { 0.0 } else { by_nm }
        });
        let changes = told.changes();
        told = hand.stand(1500, 0.0);
        assert!(
            told.events
                .iter()
                .any(|(_, event)| matches!(event, Event::Located { settled: true, .. })),
            "{told:?}"
        );
        if by_nm > 0.0 {
            assert!(
                matches!(changes[..], [(_, Change::Pushed, ..)]),
                "{changes:?}"
            );
            assert_eq!(told.moved(), None);
        } else {
            assert_eq!(changes, []);
            assert!(told.moved().is_some());
        }
    }
}

/// Tells a second contact on a phalanx with the last word on the first, and then that the grasp is over.
#[derive(Clone, Debug, Default)]
struct Second<const PHALANX: u8> {
    is_due: bool,
}

impl<F: Mechanics, const PHALANX: u8> AfterContact<F> for Second<PHALANX> {
    const FOLLOWS: bool = true;

    fn direct(&mut self, _: Directive) {
        self.is_due = false;
    }

    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        _: &mut Sensor<F, H, X>,
        _: &Sample<H::Reading>,
        told: Option<&Event>,
    ) -> Option<Followed> {
        if let Some(Event::Located { settled: true, .. }) = told {
            self.is_due = true;
            return Some(Followed::SecondContact {
                phalanx: PHALANX,
                k_m: f32::NAN,
                sigma_m: f32::NAN,
                theta_a_rad: 1.1,
                torque_nm: 0.18,
                stiffness_nm_per_rad: 1.2,
                stiffness_sigma_nm_per_rad: 0.1,
            });
        }
        core::mem::take(&mut self.is_due).then_some(Followed::Grasp {
            grip: Grip::Enveloped,
            torque_nm: 0.2,
            forces: HeldForces::UNKNOWN,
        })
    }
}

/// What was told of a contact after a closing.
fn after<A: AfterContact<<P70 as Scene>::Finger>>() -> Vec<Followed> {
    let mut hand = held::<A>();
    hand.watch(1.25, contact_nm);
    let told = hand.stand(1500, 0.0);
    let followed = told.followed.into_iter();
    followed.map(|(_, followed)| followed).collect()
}

/// The first contact has come to where it was at the second one, however far the finger is pressed on; it has come nowhere if the second
/// one is on its phalanx, because then it is not where it was told.
#[test]
fn a_second_contact_ends_the_way_of_the_first() {
    let alone = after::<FirstContactOnly>();
    let [
        Followed::Moved {
            k_m: alone_m,
            torque_nm: alone_nm,
            ..
        },
    ] = alone[..]
    else {
        panic!("{alone:?}");
    };
    assert!((alone_nm - contact_nm(1.245)).abs() < 3e-3, "{alone_nm}");
    let other = after::<Second<1>>();
    let [
        Followed::SecondContact { .. },
        Followed::Grasp { .. },
        Followed::Moved {
            phalanx: 2,
            k_m,
            torque_nm,
            ..
        },
    ] = other[..]
    else {
        panic!("{other:?}");
    };
    assert_eq!(torque_nm, 0.18);
    assert!(k_m < alone_m - 2e-3, "{k_m} {alone_m}");
    let same = after::<Second<2>>();
    assert!(
        matches!(
            same[..],
            [Followed::SecondContact { .. }, Followed::Grasp { .. }]
        ),
        "{same:?}"
    );
}

/// The sensor's last word on a contact may come long before the closing is over: where the contact has come to is told afterwards.
#[test]
fn a_contact_has_come_to_its_place_when_the_closing_is_over() {
    let mut hand = held::<Follow<<P70 as Scene>::Finger>>();
    hand.watch(1.0, contact_nm);
    hand.sensor.conclude();
    let told = hand.close(1.3, contact_nm);
    assert!(
        told.settled_ms().is_some() && told.followed.is_empty(),
        "{told:?}"
    );
    let told = hand.stand(400, 0.0);
    let [
        (
            _,
            Followed::Grasp {
                grip: Grip::Single, ..
            },
        ),
        (_, Followed::Moved { torque_nm, .. }),
    ] = told.followed[..]
    else {
        panic!("{told:?}");
    };
    assert!((torque_nm - 0.297).abs() < 3e-3, "{torque_nm}");
}
