use super::{BISECTION, CONTROL, TYPICAL, UPDATE, WITH_FIT, read};

fn count(kind: &str, name: &str, calls: u64, mean: f64, max: u64) -> String {
    serde_json::json!({
        "type": "count", "kind": kind, "name": name, "calls": calls, "instructions_min": 1,
        "instructions_mean": mean, "instructions_max": max, "cycles_low_mean": mean, "cycles_high_mean": 2.0 * mean,
    })
    .to_string()
}

const BISECT: &str = "palpate::numeric::bisect::bisect_quadratic";
const NAME: &str = "<palpate::sensing::sensor::Sensor<X>>::update";

fn grasp(lines: &[String]) -> anyhow::Result<super::Grasp> {
    let id = format!("palpate-whole-{}-{:x}", std::process::id(), lines.len());
    let path = std::env::temp_dir().join(id);
    std::fs::write(&path, lines.join("\n"))?;
    let grasp = read(&path);
    std::fs::remove_file(&path)?;
    grasp
}

#[test]
fn the_typical_update_is_one_without_a_fit_and_those_with_one_have_a_maximum_of_their_own() {
    let grasp = grasp(&[
        count("interrupt", "ADC1_2", 2000, 500.0, 580),
        count("function", NAME, 100, 1300.0, 100_300),
        count("function", BISECT, 7, 240.0, 241),
        count("without", NAME, 99, 300.0, 100_300),
        count("with", NAME, 1, 60_000.0, 60_000),
        r#"{"type":"summary","emulated_s":0.1}"#.to_owned(),
    ])
    .expect("complete");
    let typical = grasp.of(TYPICAL).expect("there").part;
    assert_eq!((typical.calls, typical.instructions_max), (99, 100_300));
    let with_fit = grasp.of(WITH_FIT).expect("there").part;
    assert_eq!((with_fit.calls, with_fit.instructions_max), (1, 60_000));
    // 500 instructions, 2 cycles each, 20 kHz, of 170 MHz.
    let control = grasp.of(CONTROL).expect("there");
    assert!((control.load_high_percent - 11.7647).abs() < 1e-3);
    assert!(grasp.of(UPDATE).is_some());
}

#[test]
fn a_grasp_without_a_bisection_is_an_error() {
    let lines = [
        count("interrupt", "ADC1_2", 2000, 500.0, 580),
        count("function", NAME, 100, 1300.0, 100_300),
        count("without", NAME, 99, 300.0, 700),
        count("function", BISECT, 0, 0.0, 0),
    ];
    let error = grasp(&lines).err().expect("it was never called");
    assert!(error.to_string().contains(BISECTION), "{error}");
}

#[test]
fn a_function_that_was_not_counted_is_an_error_not_an_empty_row() {
    let lines = [count("interrupt", "ADC1_2", 1, 1.0, 1)];
    let error = grasp(&lines).err().expect("no sensing update");
    assert!(error.to_string().contains(TYPICAL), "{error}");
}

#[test]
fn the_longest_update_is_that_of_all_grasps() {
    let mut whole = grasp(&[
        count("interrupt", "ADC1_2", 2000, 500.0, 580),
        count("function", NAME, 100, 1300.0, 100_300),
        count("function", BISECT, 7, 240.0, 241),
        count("without", NAME, 99, 300.0, 700),
    ])
    .expect("complete");
    assert_eq!(whole.longest_update(), Some(100_300));
    let path = std::env::temp_dir().join(format!("palpate-other-{}", std::process::id()));
    for longest in [90_000, 120_000] {
        std::fs::write(&path, count("function", NAME, 100, 1300.0, longest)).expect("written");
        whole
            .add(&format!("at 8 mm={}", path.display()))
            .expect("counted");
        assert_eq!(whole.longest_update(), Some(longest.max(100_300)));
    }
    std::fs::write(&path, count("interrupt", "ADC1_2", 1, 1.0, 1)).expect("written");
    assert!(whole.add(&format!("nothing={}", path.display())).is_err());
    assert!(whole.add("no file").is_err());
    std::fs::remove_file(&path).expect("removed");
}
