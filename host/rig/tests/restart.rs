//! What was saved, after a restart: the encoder has a new zero then, some milliradians beside the one that friction was
//! recorded with. Simulated.

use palpate::app::settings::Overrides;
use palpate::drive::demand::Status;
use palpate::drive::sequence::Request;
use palpate::scene::P70;
use palpate::sensing::{Directive, Event};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_rig::{Outcome, Rig};

/// Where the pins are, in the order of the closings; the first closing is the one that aligns the record.
const PLACES_MM: [f32; 4] = [20.0, 50.0, 35.0, 45.0];

/// A rig after a restart, with what another one of the same finger has recorded and saved.
fn restarted(parameters: &Parameters, seed: u64) -> Rig<P70> {
    let mut before = Rig::<P70>::new(parameters, seed).unwrap();
    assert_eq!(before.prepare().unwrap().fault, None);
    let sense = &before.slow().sense;
    let kept = sense.keep(Overrides::default(), |kept| kept.clone());
    let mut rig = Rig::<P70>::new(parameters, 1000 + seed).unwrap();
    let notice = rig.slow().sense.restore(kept);
    rig.slow()
        .conduct
        .advance(0, &Status::default(), Some(notice));
    rig
}

fn press(rig: &mut Rig<P70>, k_mm: f32) -> Outcome {
    let pin = Shape::Cylinder { diameter_m: 0.01 };
    rig.plant()
        .place(&Grasp::touching(2, f64::from(k_mm) * 1e-3, 0.785, pin))
        .unwrap();
    let outcome = rig.motion(Request::Run, Directive::Watch).unwrap();
    rig.plant().place(&Grasp::Free).unwrap();
    outcome
}

/// Without the alignment one closing in five felt what was not there or went blind.
#[test]
fn a_record_of_before_a_restart_serves() {
    let mut errors_mm = Vec::new();
    for seed in 1..=24 {
        let nominal = Parameters::default();
        let random = nominal.randomised(seed);
        for (parameters, nominal) in [(&nominal, true), (&random, false)] {
            let mut rig = restarted(parameters, seed);
            for k_mm in PLACES_MM {
                let outcome = press(&mut rig, k_mm);
                let told = format!("seed {seed}, {k_mm} mm: {:?}", outcome.events);
                assert_eq!(outcome.fault, None, "{told}");
                let first = outcome.events.first();
                assert!(matches!(first, Some((_, Event::Touch { .. }))), "{told}");
                let delay_s = outcome.delay_s().expect("touched");
                assert!((-0.01..0.3).contains(&delay_s), "{delay_s} s, {told}");
                // A random finger's places are as far off as its hidden values: that is what calibration is for.
                if nominal {
                    let Some((_, Event::Located { k_m, .. })) = outcome.events.last() else {
                        panic!("{told}");
                    };
                    errors_mm.push((1e3 * k_m - k_mm).abs());
                }
            }
        }
    }
    errors_mm.sort_by(f32::total_cmp);
    let (median, most) = (
        errors_mm[errors_mm.len() / 2],
        errors_mm[errors_mm.len() - 1],
    );
    println!(
        "{} places, median {median:.2} mm, most {most:.2} mm",
        errors_mm.len()
    );
    assert!(most <= 3.5, "{most} mm");
}

/// A finger that meets something before the record is aligned must not go on pressing, nor tell a place that is none.
#[test]
fn a_finger_that_is_not_free_at_first_tells_so() {
    let mut rig = restarted(&Parameters::default(), 1);
    // At the proximal phalanx, after a tenth of a radian.
    let pin = Shape::Cylinder { diameter_m: 0.01 };
    rig.plant()
        .place(&Grasp::touching(1, 0.05, 0.12, pin))
        .unwrap();
    let outcome = rig.motion(Request::Run, Directive::Watch).unwrap();
    let told = format!("{:?}", outcome.events);
    assert_eq!(outcome.fault, None, "{told}");
    assert!(
        matches!(
            outcome.events.first(),
            Some((_, Event::FrictionStale { .. }))
        ),
        "{told}"
    );
    let placed = |event: &Event| matches!(event, Event::Located { .. } | Event::Ambiguous { .. });
    assert!(
        !outcome.events.iter().any(|(_, event)| placed(event)),
        "{told}"
    );
}
