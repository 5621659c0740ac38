//! The library against the reference files of `tests/data/golden`.

use std::path::Path;

fn check(name: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/golden")
        .join(name);
    let report = crate::golden_files::evaluate(&path).unwrap_or_else(|error| panic!("{error}"));
    let mut lines = format!(
        "{}: {} rows, {} misclassified",
        report.file,
        report.rows,
        report.misclassified.len()
    );
    for quantity in &report.quantities {
        lines += &format!("\n  {quantity}");
    }
    for (line, what) in report.misclassified.iter().take(5) {
        lines += &format!("\n  line {line}: {what}");
    }
    println!("{lines}");
    assert!(report.passes(), "{lines}");
}

macro_rules! golden {
    ($($name:ident),* $(,)?) => { $(#[test] fn $name() { check(concat!(stringify!($name), ".csv")); })* };
}

#[allow(non_snake_case)]
mod files {
    use super::check;
    golden!(
        kc_2T,
        kc_2L,
        kc_3T,
        kc_3L,
        inverse_2T,
        inverse_2L,
        inverse_3T,
        inverse_3L,
        inverse_folded_2T,
        inverse_folded_2L,
        inverse_folded_3T,
        hard_2p,
        hard_3p,
        contact_2T,
        contact_2L,
        contact_3T,
        contact_3L,
        preshape_2T,
        preshape_2L,
        preshape_3T,
        preshape_3L,
        kc_4L,
        kc_5T,
        kc_6L,
        inverse_4L,
        inverse_5T,
        inverse_6T,
        contact_4L,
        contact_5T,
        second_3T,
        second_3L,
        actuated_3T,
        preshape_4L,
        preshape_6T,
        fourbar,
        static_forces,
    );
}
