//! Recordings from an independent engine, replayed by the product's protocol: what the sensing reaches on them stays.

use std::path::{Path, PathBuf};

use palpate_evaluation::recordings::{Class, Plan, World, json, run};

fn data(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data")
        .join(folder)
}

fn plan(only: Option<&str>, uncalibrated: bool) -> Plan {
    Plan {
        directory: data("recordings"),
        only: only.map(str::to_owned),
        uncalibrated,
        scale: false,
    }
}

fn replayed(only: Option<&str>, uncalibrated: bool) -> Vec<World> {
    run("p70", &plan(only, uncalibrated)).expect("the recordings are readable")
}

#[test]
fn contacts_are_felt_in_time_and_placed_within_what_is_claimed() {
    let worlds = replayed(None, false);
    let (mut free, mut located) = (0, 0);
    for line in worlds.iter().flat_map(|world| &world.lines) {
        let trial = &line.trial;
        assert_eq!((line.problem, line.refused), (None, None), "{}", line.name);
        if line.class.calibrates() {
            continue;
        }
        free += usize::from(line.class == Class::Free);
        located += usize::from(trial.answer.place().is_some());
        assert!(!trial.is_early(), "{}: {trial:?}", line.name);
        match line.class {
            Class::Free => assert!(trial.is_clean(), "{}: {trial:?}", line.name),
            Class::Proximal => assert_eq!(trial.answer.phalanx(), Some(1), "{}", line.name),
            _ => {
                let error_m = trial.error_m().expect("located");
                let (_, sigma_m) = trial.answer.place().expect("located");
                // 4 % of the phalanx: the mean over more recordings of the kind is 1.1 +- 1.0 %.
                assert!(error_m.abs() < 2.8e-3, "{}: {error_m} m", line.name);
                assert!(
                    error_m.abs() < 3.0 * sigma_m,
                    "{}: {error_m} {sigma_m}",
                    line.name
                );
                let force = trial.force.expect("told with the place");
                assert!(
                    (force.told_n / force.true_n - 1.0).abs() < 0.25,
                    "{}: {force:?}",
                    line.name
                );
            }
        }
        if let (Some(touched_s), Some(contact)) = (trial.touched_s, trial.truth) {
            assert!(touched_s - contact.time_s < 0.1, "{}: {trial:?}", line.name);
        }
    }
    assert_eq!((free, located), (2, 4), "closings on nothing, and places");
    let calibrated = worlds[0]
        .calibration
        .as_ref()
        .expect("w1 has a press and pins");
    assert_eq!(
        (calibrated.found.presses, calibrated.found.contacts),
        (1, 2)
    );
    assert!(calibrated.torque_factor_z().abs() < 3.0, "{calibrated:?}");
    assert!(calibrated.cable_z().abs() < 3.0, "{calibrated:?}");
}

/// Phalanx 1 was felt late, and what phalanx 2 adds later makes the whole curve that of one contact 2 mm beyond joint 2.
#[test]
fn a_contact_on_phalanx_1_that_another_follows_is_no_place_near_joint_2() {
    let plan = Plan {
        directory: data("wandering"),
        ..plan(None, true)
    };
    let worlds = run("p70", &plan).expect("the recording is readable");
    let [line] = &worlds[0].lines[..] else {
        panic!("one recording");
    };
    assert!(line.trial.touched_s.is_some(), "{:?}", line.trial);
    assert!(line.trial.answer.place().is_none(), "{:?}", line.trial);
}

/// One object stands on springs of 1 N/mm, the others are fixed.
#[test]
fn the_soft_object_is_told_and_the_fixed_ones_are_not() {
    let worlds = run("p70", &plan(Some("w1"), false)).expect("the recordings are readable");
    let lines = worlds.iter().flat_map(|world| &world.lines);
    let mut told = 0;
    for line in lines.filter(|line| matches!(line.class, Class::Distal | Class::Hard)) {
        let object = line.object.expect("a place with its object");
        let [given, sigma] = object.compliance_m_per_n.map(f64::from);
        let expected = line
            .true_object_n_per_m
            .map_or(0.0, |stiffness| 1.0 / stiffness);
        assert!(
            (given - expected).abs() < 2.0 * sigma,
            "{}: {object:?}",
            line.name
        );
        assert!(sigma < 0.6e-3, "{}: {object:?}", line.name);
        assert_eq!(
            object.stiffness_n_per_m().is_some(),
            line.class == Class::Hard,
            "{}: {object:?}",
            line.name
        );
        let error_m = line.trial.error_m().expect("located");
        let (_, sigma_m) = line.trial.answer.place().expect("located");
        assert!(error_m.abs() < 2.0 * sigma_m, "{}: {error_m}", line.name);
        told += 1;
    }
    assert_eq!(told, 3);
}

#[test]
fn a_scale_under_the_pins_sets_the_scale_of_forces() {
    let plan = Plan {
        scale: true,
        ..plan(Some("w1"), false)
    };
    let worlds = run("p70", &plan).expect("the recordings are readable");
    let [world] = &worlds[..] else {
        panic!("one world");
    };
    let scale = world.force_scale.expect("two pins");
    assert!((scale / world.true_springs - 1.0).abs() < 0.1, "{scale}");
    for line in &world.lines {
        if let Some(force) = line.trial.force.filter(|_| line.class == Class::Distal) {
            let off = force.told_n - force.true_n;
            assert!(off.abs() < 0.1 * force.true_n, "{}: {force:?}", line.name);
            assert!(off.abs() < 2.0 * force.sigma_n, "{}: {force:?}", line.name);
        }
    }
    // Nobody read it.
    assert!(replayed(Some("w1"), false)[0].force_scale.is_none());
}

#[test]
fn what_is_told_has_the_keys_that_others_read() {
    let lines = json(&replayed(Some("w4"), true));
    let of = |kind: &str| -> Vec<_> { lines.iter().filter(|line| line["type"] == kind).collect() };
    let recordings = of("recording");
    assert_eq!(recordings.len(), 3);
    for key in [
        "name",
        "cls",
        "verdict",
        "phalanx",
        "k_mm",
        "sigma_mm",
        "touch_s",
        "force_n",
        "true_phalanx",
        "true_k_mm",
        "true_touch_s",
        "true_force_n",
    ] {
        assert!(
            recordings.iter().all(|line| line.get(key).is_some()),
            "{key}"
        );
    }
    let [summary] = of("summary")[..] else {
        panic!("one summary");
    };
    for key in [
        "distal",
        "located",
        "err_mean_pct",
        "err_sd_pct",
        "within2_pct",
        "proximal",
        "proximal_named",
        "free",
        "free_clean",
        "early",
        "unusual",
        "delay_ms",
        "force_err_pct",
    ] {
        assert!(summary.get(key).is_some(), "{key}");
    }
    assert_eq!(
        (summary["distal"].as_u64(), summary["free"].as_u64()),
        (Some(1), Some(1))
    );
}

#[test]
fn a_folder_without_recordings_is_refused_with_its_name() {
    let mut plan = plan(None, false);
    plan.directory = plan.directory.join("../golden");
    let error = run("p70", &plan).expect_err("nothing there");
    assert!(error.contains("golden"), "{error}");
    let error = run("p70", &self::plan(Some("nowhere"), false)).expect_err("no such name");
    assert!(error.contains("nowhere"), "{error}");
}
