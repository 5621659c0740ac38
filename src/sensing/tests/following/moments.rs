//! Changes of a contact at an unlucky moment.

use super::STEP_RAD;
use super::changes::{Held, contact_nm, held};
use crate::finger::{HeldForces, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::sensing::{
    AfterContact, Change, Directive, Event, Followed, Grip, Sample, Sensor, SeriesElement,
};
use core::sync::atomic::{AtomicU64, Ordering};

/// The end of the swing after a change is none, wherever in a turn that is: it is in the turn before until another one is over.
#[test]
fn the_end_of_a_swing_is_no_change() {
    for phase in 0..16 {
        let at_rad = 1.0 + STEP_RAD * phase as f32;
        let slips_nm = |theta| contact_nm(theta) - if theta < at_rad { 0.0 } else { 0.05 };
        let mut hand: Held = held();
        let (begun_ms, from_rad) = (hand.ms, hand.sensor.drivetrain().closing_rad(0));
        let alone = hand.watch(1.3, slips_nm).changes();
        let [(told_ms, Change::Slipped, ..)] = alone[..] else {
            panic!("{phase}: {alone:?}");
        };
        let after_ms = |theta: f32| {
            let ms = ((theta - from_rad) / STEP_RAD).round();
            ms - (told_ms - begun_ms) as f32
        };
        for swing_nm in [0.05, -0.03] {
            let mut hand: Held = held();
            let told = hand.watch(1.3, |theta| {
                let swings = (86.0..100.0).contains(&after_ms(theta));
                slips_nm(theta) + if swings { swing_nm } else { 0.0 }
            });
            assert_eq!(told.changes(), alone, "{phase}: {swing_nm}");
        }
    }
}

/// Says that a grasp is over at a time, millisecond.
#[derive(Clone, Debug, Default)]
struct Ends;

static ENDS_MS: AtomicU64 = AtomicU64::new(u64::MAX);

impl<F: Mechanics> AfterContact<F> for Ends {
    const FOLLOWS: bool = true;

    fn direct(&mut self, _: Directive) {}

    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        _: &mut Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
        _: Option<&Event>,
    ) -> Option<Followed> {
        let ends_ms = ENDS_MS.load(Ordering::Relaxed);
        (sample.time_us / 1000 == ends_ms).then_some(Followed::Grasp {
            grip: Grip::Single,
            torque_nm: 0.2,
            forces: HeldForces::UNKNOWN,
        })
    }
}

/// Where a contact has come to is worked out once the motor stands; one that slips before is told to have slipped, and to be nowhere.
#[test]
fn a_contact_that_slips_has_come_nowhere() {
    let slips_nm = |theta| contact_nm(theta) - if theta < 1.2 { 0.0 } else { 0.05 };
    let until = |theta_a_rad: f32| {
        let mut hand = held::<Ends>();
        hand.watch(1.0, slips_nm);
        hand.sensor.conclude();
        let told = hand.close(theta_a_rad, slips_nm);
        (hand, told)
    };
    let (_, alone) = until(1.3);
    assert!(alone.settled_ms().is_some() && alone.moved().is_none());
    let [(slipped_ms, Change::Slipped, ..)] = alone.changes()[..] else {
        panic!("{alone:?}");
    };
    ENDS_MS.store(slipped_ms - 150, Ordering::Relaxed);
    let (mut hand, told) = until(1.3);
    assert!(
        matches!(
            told.followed[..],
            [
                (_, Followed::Grasp { .. }),
                (
                    _,
                    Followed::Changed {
                        change: Change::Slipped,
                        ..
                    }
                )
            ]
        ),
        "{told:?}"
    );
    assert_eq!(hand.stand(100, 0.0).followed, []);
    let (mut hand, told) = until(1.19);
    assert!(told.moved().is_none(), "{told:?}");
    let told = hand.stand(100, 0.0);
    assert!(told.moved().is_some(), "{told:?}");
}
