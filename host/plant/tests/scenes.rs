//! docs/MANUAL.md#scenes says what `default.toml` holds.

use palpate_plant::{FingerParameters, Parameters};

fn page() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/MANUAL.md"))
        .expect("docs/MANUAL.md")
}

/// The cells of the row that begins with `name`.
fn cells(page: &str, name: &str) -> Vec<String> {
    let line = page
        .lines()
        .find(|line| line.starts_with(&format!("| {name} |")))
        .expect(name);
    line.split('|')
        .skip(2)
        .map(|cell| cell.trim().to_owned())
        .collect()
}

/// The numbers of a cell, in order.
fn numbers(cell: &str) -> Vec<f64> {
    let word = |c: char| !(c.is_ascii_digit() || c == '.');
    cell.split(word)
        .map(|w| w.trim_matches('.'))
        .filter_map(|w| w.parse().ok())
        .collect()
}

#[test]
fn fingers_are_as_documented() {
    let page = page();
    let fingers = Parameters::default().finger;
    let each: [&FingerParameters; 4] = [
        &fingers.p70,
        &fingers.tendon2,
        &fingers.tendon3,
        &fingers.linkage3,
    ];
    for (i, finger) in each.into_iter().enumerate() {
        let check = |row: &str, skip: usize, scale: f64, expected: &[f64]| {
            let found = numbers(&cells(&page, row)[i]);
            assert!(found.len() >= skip + expected.len(), "{row}: {found:?}");
            for (found, expected) in found[skip..].iter().zip(expected) {
                assert!(
                    (found - expected * scale).abs() < 0.006,
                    "{row}, column {i}: {found} {}",
                    expected * scale
                );
            }
        };
        check("phalanges, mm", 0, 1e3, &finger.length_m);
        check("springs, N m/rad", 0, 1.0, &finger.spring_nm_per_rad);
        let rest = if finger.spring_nm_per_rad[0] == 0.0 {
            &finger.rest_deg[1..]
        } else {
            &finger.rest_deg[..]
        };
        check("rest angles, deg", 0, 1.0, rest);
        check(
            "travel of the input link, rad",
            0,
            1.0,
            &[finger.travel_rad],
        );
        if finger.pulley_m.is_empty() {
            for stage in 0..finger.lever_m.len() {
                let bars = [
                    finger.lever_m[stage],
                    finger.coupler_m[stage],
                    finger.driven_m[stage],
                ];
                check("transmission, mm", 3 * stage, 1e3, &bars);
            }
        } else {
            check("transmission, mm", 0, 1e3, &finger.pulley_m);
        }
    }
}
