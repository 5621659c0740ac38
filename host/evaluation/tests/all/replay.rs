//! A recording made in the simulation, written as a file and read back, tells what the firmware told.

use palpate::scene::Scene;
use palpate::sensing::{Directive, Event};
use palpate_evaluation::replay::{NoFriction, Preparation, Replay, Replayer, Source};
use palpate_evaluation::trace::{read, resample};
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::{HEADER, Outcome, Row, Simulation};

fn csv(rows: &[Row]) -> String {
    let mut file = format!("{HEADER}\n");
    for row in rows {
        file.push_str(&row.csv());
        file.push('\n');
    }
    file
}

fn p70() -> Replayer {
    Replayer::of("p70").expect("one of the scenes")
}

fn replayed(file: &str) -> Replay {
    let (rows, _) = read(file.as_bytes()).expect("the file is well formed");
    let before = Preparation {
        friction: None,
        calibration: P70::UNCALIBRATED,
    };
    (p70().replay)(&resample(&rows, 0).samples, &before, Directive::Watch)
}

/// The direction of drive is read from duty and motion, so that a few samples more or less enter: uncalibrated, the place
/// is known to some 3 mm.
const SAME_M: f64 = 2.5e-3;

/// A friction record and then a contact, as one file.
fn recording() -> (Vec<Row>, Outcome) {
    let mut simulation =
        Simulation::<P70>::new(&Parameters::default(), 9).expect("the defaults are valid");
    simulation.traced = true;
    let mut rows = simulation
        .prepare()
        .expect("an idle finger records friction")
        .trace;
    let pin = Shape::Cylinder { diameter_m: 0.012 };
    let outcome = simulation
        .close(&Grasp::touching(2, 0.034, 0.7, pin))
        .expect("the object is clear of the open finger");
    rows.extend_from_slice(&outcome.trace);
    (rows, outcome)
}

fn place_m(events: impl Iterator<Item = Event>) -> Option<f64> {
    events
        .filter_map(|event| match event {
            Event::Located {
                phalanx: 2, k_m, ..
            } => Some(f64::from(k_m)),
            _ => None,
        })
        .last()
}

#[test]
fn a_file_tells_what_the_firmware_told() {
    let (rows, outcome) = recording();
    let live = place_m(outcome.events.iter().map(|(_, event)| *event)).expect("located live");

    let whole = replayed(&csv(&rows));
    assert!(matches!(whole.friction, Source::Within(_)));
    let found = place_m(whole.told.iter().map(|told| told.event)).expect("located from the file");
    assert!(
        (found - live).abs() < SAME_M,
        "{found} m from the file, {live} m live"
    );

    // Half the rows, none at an even distance.
    let thinned: Vec<Row> = rows
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 3 != 1)
        .map(|(_, row)| *row)
        .collect();
    let found = place_m(replayed(&csv(&thinned)).told.iter().map(|told| told.event));
    let found = found.expect("located from fewer rows");
    assert!(
        (found - live).abs() < SAME_M,
        "{found} m from fewer rows, {live} m live"
    );
}

#[test]
fn no_free_closing_no_contact() {
    let (_, outcome) = recording();
    // The grasp alone: nothing in it is free all the way.
    let grasp = replayed(&csv(&outcome.trace));
    assert!(
        matches!(grasp.friction, Source::None(NoFriction::NoFreeClosing(_))),
        "{:?}",
        grasp.friction
    );
    assert!(place_m(grasp.told.iter().map(|told| told.event)).is_none());
}

/// The rows with every second one left out while the finger opens, and no time left between: it opens twice as fast.
fn opened_fast(rows: &[Row]) -> Vec<Row> {
    let opens = |at: usize| rows[at].duty < 0.0;
    let mut time_s = rows[0].time_s;
    let mut fast = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        if opens(at) && at % 2 == 1 {
            continue;
        }
        fast.push(Row { time_s, ..*row });
        time_s += 1e-3;
    }
    fast
}

#[test]
fn an_opening_at_another_speed_is_no_obstacle() {
    let (rows, outcome) = recording();
    let live = place_m(outcome.events.iter().map(|(_, event)| *event)).expect("located live");
    let replayed = replayed(&csv(&opened_fast(&rows)));
    assert!(
        matches!(replayed.friction, Source::Within(_)),
        "{:?}",
        replayed.friction
    );
    let found = place_m(replayed.told.iter().map(|told| told.event)).expect("located");
    assert!((found - live).abs() < SAME_M, "{found} m, {live} m live");
}

#[test]
fn recordings_of_a_press_and_of_a_pin_calibrate() {
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/recordings");
    let samples = |name: &str| {
        let file = palpate_evaluation::recordings::open(&folder.join(name)).expect(name);
        resample(&read(file).expect(name).0, 0).samples
    };
    let mut calibration = P70::UNCALIBRATED;
    let pin = Directive::Calibrate {
        phalanx: 2,
        k_m: 0.021,
    };
    let steps = [
        ("w1_press.csv.gz", Directive::CalibrateCable),
        ("w1_pin21.csv.gz", pin),
    ];
    for (name, purpose) in steps {
        let before = Preparation {
            friction: None,
            calibration,
        };
        let found = (p70().replay)(&samples(name), &before, purpose);
        assert!(
            matches!(found.friction, Source::Within(_)),
            "{name}: {:?}",
            found.friction
        );
        calibration = found.calibration;
    }
    assert_eq!((calibration.presses, calibration.contacts), (1, 1));
    assert!(calibration.torque_factor_sigma < 0.5 * P70::UNCALIBRATED.torque_factor_sigma);
}
