//! The reference files agree with what positions and energy give.

use std::path::Path;

use palpate_golden::table::Table;
use palpate_golden::{compare, family, generate, sample};
use rayon::prelude::*;

/// Rows of a file. The steps after contact solve a posture for each part of the step: they take longest.
const ROWS: usize = 2;
const ROWS_AFTER_CONTACT: usize = 1;
/// Relative difference of two roundings to f64.
const ROUNDING: f64 = 4.5e-16;

fn tables() -> Vec<Table> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/golden");
    let entries = std::fs::read_dir(folder).expect("the reference files");
    let mut tables: Vec<Table> = entries
        .map(|entry| {
            Table::read(&entry.expect("a readable entry").path()).expect("a reference file")
        })
        .collect();
    tables.sort_by(|a, b| a.name.cmp(&b.name));
    tables
}

#[test]
fn every_file_is_reproduced_to_its_last_digit() {
    let tables = tables();
    assert_eq!(tables.len(), 36, "files");
    tables.into_par_iter().for_each(|table| {
        assert!(
            family(&table.name).is_some(),
            "{} cannot be recomputed",
            table.name
        );
        let rows = if table.name.starts_with("contact") || table.name.starts_with("second") {
            ROWS_AFTER_CONTACT
        } else {
            ROWS
        };
        let found = compare(&table, sample(&table, rows)).expect("rows that can be recomputed");
        println!(
            "{}: {} of {} cells equal in {} rows",
            table.name, found.equal, found.cells, found.rows
        );
        assert!(
            found.rows == rows && found.cells >= 3 * rows,
            "{}: nothing compared",
            table.name
        );
        assert!(
            found.worst.deviation <= ROUNDING,
            "{}: {:?}",
            table.name,
            found.worst
        );
    });
}

#[test]
fn a_wrong_digit_is_found() {
    let mut table = tables()
        .into_iter()
        .find(|table| table.name == "hard_2p")
        .expect("hard_2p");
    table.rows.truncate(1);
    let worst = |table: &Table| compare(table, 0..1).expect("a sound row").worst;
    assert_eq!(worst(&table).deviation, 0.0);
    let column = table
        .columns
        .iter()
        .position(|column| column == "k_minus")
        .expect("a column");
    let value: f64 = table.rows[0][column].parse().expect("a number");
    table.rows[0][column] = (value * (1.0 + 1e-14)).to_string();
    let found = worst(&table);
    assert_eq!((found.column.as_str(), found.row), ("k_minus", 1));
}

#[test]
fn a_row_that_cannot_be_recomputed_is_named() {
    let all = tables();
    let broken = |name: &str, change: &dyn Fn(&mut Table)| {
        let mut table = all.iter().find(|table| table.name == name).cloned();
        let table = table.as_mut().expect("a reference file");
        table.rows.truncate(1);
        change(table);
        let compared = compare(table, 0..1).expect_err("a refusal");
        assert_eq!(generate(table).expect_err("a refusal"), compared);
        compared
    };
    let cell = |column: &'static str, text: &'static str| {
        move |table: &mut Table| {
            let index = table.columns.iter().position(|name| name == column);
            table.rows[0][index.expect("a column")] = text.to_owned();
        }
    };
    let told = broken("preshape_2T", &cell("l1", "one"));
    assert_eq!(
        told,
        "preshape_2T, row 1: cannot be recomputed, expected a number in l1"
    );
    let told = broken("preshape_2T", &|table| {
        table.columns.retain(|name| name != "r2");
    });
    assert!(
        told.contains("row 1") && told.contains("a column r2"),
        "{told}"
    );
    broken("kc_2T", &cell("K2", "nan"));
    let told = broken("fourbar", &|table| table.name = "unknown".to_owned());
    assert_eq!(told, "unknown: no kind of reference file");
}

#[test]
fn files_are_written_as_they_are() {
    for mut table in tables()
        .into_iter()
        .filter(|table| table.name.ends_with("_2T") && !table.name.starts_with("con"))
    {
        table.rows.truncate(4);
        let text = generate(&table).expect("rows that can be recomputed");
        let rows: Vec<&str> = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .skip(1)
            .collect();
        assert_eq!(rows.len(), table.rows.len(), "{}", table.name);
        let cells = rows.iter().flat_map(|row| row.split(','));
        for (cell, expected) in cells.zip(table.rows.iter().flatten()) {
            // The rounding of zero differs from one evaluation to another.
            let is_zero = |text: &str| text.parse().is_ok_and(|value: f64| value.abs() < 1e-30);
            assert!(
                cell == expected || is_zero(cell) && is_zero(expected),
                "{}: {cell} {expected}",
                table.name
            );
        }
    }
}
