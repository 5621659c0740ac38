//! What becomes of a contact, told next to the truth. A few grasps in `workshop`, with both engines; the figures of
//! docs/SECOND_CONTACTS.md#changes-that-were-told are those of `cargo xtask experiments --only changes`.
//! `PALPATE_HOLDS=100 PALPATE_WORLD=harsh@mujoco ... -- --nocapture` prints every closing.

use palpate::app::console::command::Command;
use palpate::app::console::settings::Setting;
use palpate_plant::{Grasp, Shape, World};
use palpate_scenes::P70Hold;
use palpate_simulation::changes::{GRASPS, KINDS, Moved, Score, Scores, finger};
use palpate_simulation::places::{PIN_SHARES, calibrated};
use rayon::prelude::*;

/// So many grasps, ten on each drawn finger.
fn scores(world: &str, count: usize, prints: bool) -> Scores {
    let world = World::named(world).expect("a world");
    let fingers = count.div_ceil(GRASPS);
    let scores: Vec<Scores> = (0..fingers)
        .into_par_iter()
        .map(|index| {
            let grasps = GRASPS.min(count - GRASPS * index);
            finger::<P70Hold>(
                &world,
                1 + index as u64,
                grasps,
                |grasp, name, happened, outcome| {
                    if prints {
                        println!(
                            "{index}.{grasp} {name}: {happened:?} {:?} {:?} {:?}",
                            outcome.verdict, outcome.followed, outcome.fault
                        );
                    }
                },
            )
            .expect("grasps")
        })
        .collect();
    scores.iter().fold(Scores::default(), Scores::with)
}

fn print(scores: &Scores) {
    for ((name, _), score) in KINDS.iter().zip(&scores.kinds) {
        println!(
            "{name}: {} happened, {} told ({} right, {} in 50 ms, {} both); of {} large ones {}; delay median {:.0}, 90 % {:.0}, \
             largest {:.0} ms; {} told before",
            score.happened,
            score.told,
            score.right,
            score.in_time,
            score.right_in_time,
            score.large,
            score.large_told,
            score.delay_ms(0.5),
            score.delay_ms(0.9),
            score.delay_ms(1.0),
            score.early
        );
    }
    println!(
        "{} contacts rolled by {:.1} mm (mean): told with an error of {:.2} mm (mean), {:.0} % within two deviations; {:.2} mm if \
         taken as where they began; {} not told",
        scores.moved.len(),
        1e3 * scores.mean(|moved| moved.way_m),
        1e3 * scores.mean(|moved| moved.error_m),
        scores.within2_pct(),
        1e3 * scores.mean(|moved| moved.began_error_m),
        scores.unmoved
    );
}

#[test]
fn what_becomes_of_a_contact_is_told_and_a_quiet_one_stays_quiet() {
    let count = std::env::var("PALPATE_HOLDS").map(|n| n.parse().expect("a number"));
    let world = std::env::var("PALPATE_WORLD").unwrap_or_else(|_| "workshop".to_owned());
    let is_small = count.is_err();
    let scores = scores(&world, count.unwrap_or(10), !is_small);
    print(&scores);
    let [quiet, gives, goes, pushed, _, goes_held, pushed_held, _] = &scores.kinds;
    assert!(quiet.happened > 0 && goes.happened > 0);
    assert_eq!(quiet.early, 0, "told of a quiet hold");
    if !is_small {
        return;
    }
    for score in [gives, goes, pushed, goes_held] {
        assert_eq!(score.early, 0, "told before");
        let is_told = |score: &Score| score.large > 0 && score.large_told == score.large;
        assert!(is_told(score), "{score:?}");
    }
    for gone in [goes, goes_held] {
        assert_eq!(gone.right_in_time, gone.happened, "{gone:?}");
    }
    // The worm holds the push, and the motor stands: there is nothing to tell it from.
    assert_eq!(pushed_held.told, 0);
    assert!(scores.mean(|moved| moved.error_m) < 3e-3 && scores.within2_pct() > 80.0);
}

/// A finger that probes with little torque closes on afterwards for the force that is wanted: the place is told of where it stands then.
#[test]
fn a_contact_has_come_to_where_the_motor_stands() {
    let world = World::named("workshop").expect("a world");
    let moved: Vec<Moved> = (1..=4u64)
        .into_par_iter()
        .flat_map_iter(|seed| {
            let finger = calibrated::<P70Hold>(&world, seed, PIN_SHARES).expect("a finger");
            let (mut simulation, ..) = finger;
            let probe = Command::Set(Setting::ProbeTorque, 0.1);
            simulation.slow().coordinator.command(probe).expect("set");
            simulation.idle(0.01);
            [0.025, 0.04].map(|k_m| {
                let shape = Shape::Cylinder { diameter_m: 0.02 };
                let grasp = Grasp::touching(2, k_m, 0.8, shape);
                let outcome = simulation.close(&grasp).expect("a grasp");
                simulation.open().expect("an opening");
                Moved::of(&outcome).unwrap_or_else(|| panic!("{seed} {k_m}: {outcome:?}"))
            })
        })
        .collect();
    let scores = Scores {
        moved,
        ..Scores::default()
    };
    let off_mm = 1e3 * scores.mean(|moved| moved.error_m);
    let way_mm = 1e3 * scores.mean(|moved| moved.way_m);
    println!("{off_mm:.2} mm off after {way_mm:.1} mm");
    assert!(off_mm < 2.5);
}
