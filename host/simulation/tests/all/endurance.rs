//! Many grasps in one piece, while the time passes 2^32 microseconds: nothing drifts, nothing wraps wrongly.
//!
//! The controller first stands until shortly before that time, some 71 minutes. Then the finger grasps and opens, again and again, for
//! 600 s (40 s, unless `PALPATE_ENDURANCE_S` says otherwise; `cargo xtask test` says 600). In that time the 16-bit encoder counter
//! wraps hundreds of times. The 32-bit position starts near its wrap, so that the homing motion crosses it.

use palpate::drive::Demand;
use palpate::drive::io::{EncoderCount, Inputs};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::{Outcome, Simulation};

/// When the grasps begin, microsecond: friction is recorded first, the grasps then cross 2^32.
const BEGIN_US: u64 = (1 << 32) - 50_000_000;

/// Where the controller's zero lies in the plant's own counts.
fn zero(simulation: &mut Simulation<P70>) -> i64 {
    let position = simulation.controller().status().position_counts;
    simulation.plant().encoder_count() - i64::from(position)
}

/// Samples follow each other by a millisecond exactly, over all motions.
fn follow(outcome: &Outcome, last_us: &mut Option<u64>) {
    for (_, sample) in &outcome.samples {
        if let Some(last_us) = *last_us {
            assert_eq!(sample.time_us, last_us + 1000);
        }
        *last_us = Some(sample.time_us);
    }
}

#[test]
fn grasp_after_grasp_leaves_everything_where_it_was() {
    let seconds: f64 = std::env::var("PALPATE_ENDURANCE_S").map_or(40.0, |number| {
        number.parse().expect("PALPATE_ENDURANCE_S is a number")
    });
    let mut simulation = Simulation::<P70>::new(&Parameters::default(), 3).expect("defaults");

    // Shift the position to its lower end, then take back what the demand would otherwise ask for once more.
    let still = Inputs {
        encoder: EncoderCount(simulation.plant().encoder_count() as u16),
        ..Inputs::default()
    };
    let shift = Demand {
        zero: 1,
        zero_at_counts: i32::MAX - 100,
        clear: 1,
        ..Demand::default()
    };
    simulation.controller().step(&still, &shift);
    // The status is that of the last sample.
    while simulation.controller().sample().is_none() {
        simulation.controller().step(&still, &Demand::default());
    }
    assert!(simulation.controller().status().position_counts < i32::MIN + 1000);
    assert!(!simulation.controller().status().homed);
    while simulation.controller().status().time_us < BEGIN_US {
        simulation.controller().step(&still, &Demand::default());
    }

    let mut last_us = None;
    let prepared = simulation.prepare().expect("accepted");
    assert_eq!(prepared.fault, None);
    follow(&prepared, &mut last_us);
    let first = zero(&mut simulation);
    let (mut lowest, mut highest, mut grasps) = (first, first, 0u32);
    let mut wraps = 0;
    while simulation.plant().time_s() < seconds {
        let k_m = 0.01 + 0.001 * f64::from(grasps % 50);
        let grasp = Grasp::touching(2, k_m, 0.8, Shape::Cylinder { diameter_m: 0.01 });
        for outcome in [simulation.close(&grasp), simulation.open()] {
            let outcome = outcome.expect("accepted");
            let time_s = simulation.plant().time_s();
            assert_eq!(outcome.fault, None, "grasp {grasps}, {time_s} s");
            follow(&outcome, &mut last_us);
            wraps += outcome
                .samples
                .windows(2)
                .filter(|pair| pair[0].1.position_counts >> 16 != pair[1].1.position_counts >> 16)
                .count();
        }
        lowest = lowest.min(zero(&mut simulation));
        highest = highest.max(zero(&mut simulation));
        grasps += 1;
    }
    println!(
        "{:.0} s, {grasps} grasps, {wraps} wraps of the counter, zero {lowest} to {highest}, at first {first}, at last {}",
        simulation.plant().time_s(),
        zero(&mut simulation)
    );
    // Homed once, at first: from there on not one count may be lost.
    assert_eq!((lowest, highest), (first, first), "the zero has moved");
    assert!(wraps > 4);
    let last_us = last_us.expect("samples");
    assert!(last_us > BEGIN_US, "{last_us}");
    assert!(seconds < 60.0 || last_us > 1 << 32, "{last_us}");
}
