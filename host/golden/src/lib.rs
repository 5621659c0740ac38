//! Recomputes the reference files of `tests/data/golden` (docs/MECHANICS.md#reference-files) from where joints and contact
//! points are, what energy the springs hold and how far the input link has turned, with numbers of 77 digits.
//!
//! Nothing of the library is used, and no equation of the source paper after (4), except where a column of a file is one.

#![expect(
    clippy::needless_range_loop,
    reason = "matrices are written with indices, as on paper"
)]

pub mod equilibrium;
pub mod finger;
pub mod forward;
pub mod inputs;
pub mod inverse;
pub mod linear;
pub mod parts;
pub mod real;
pub mod second;
pub mod table;
pub mod value;

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use table::{Error, Row, Table};
use value::Values;

/// Recomputes the outputs of a row.
pub type Family = fn(&Row) -> Values;

/// How a row of a file is recomputed; `None` for a file of another kind.
#[must_use]
pub fn family(file: &str) -> Option<Family> {
    let families: [(&str, Family); 10] = [
        ("preshape_", forward::preshape),
        ("kc_", forward::stiffness),
        ("contact_", forward::step),
        ("inverse_", inverse::inverse),
        ("hard_2p", inverse::hard_two),
        ("hard_3p", inverse::hard_three),
        ("second_", second::second),
        ("actuated_", second::actuated),
        ("static_forces", parts::forces),
        ("fourbar", parts::four_bar),
    ];
    families
        .into_iter()
        .find(|(start, _)| file.starts_with(start))
        .map(|(_, family)| family)
}

/// The values of a row, recomputed by its family. A cell that is no number, and a finger that has no such posture, end in a panic deep in
/// the computation: what it says becomes the error.
fn recomputed(table: &Table, family: Family, index: usize) -> Result<Values, Error> {
    let row = table.row(index);
    RECOMPUTING.set(true);
    let values = catch_unwind(AssertUnwindSafe(|| family(&row)));
    RECOMPUTING.set(false);
    values.map_err(|panic| {
        format!(
            "{}, row {}: cannot be recomputed, expected {}",
            table.name,
            index + 1,
            said(&*panic)
        )
    })
}

thread_local! {
    /// Whether a row is being recomputed on this thread.
    static RECOMPUTING: Cell<bool> = const { Cell::new(false) };
}

/// Whether a row is being recomputed on this thread: a panic then refuses the row and is told as an error.
#[must_use]
pub fn is_recomputing() -> bool {
    RECOMPUTING.get()
}

/// What a panic says: in this crate, what was expected.
fn said(panic: &(dyn Any + Send)) -> &str {
    (panic.downcast_ref::<String>().map(String::as_str))
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("something else")
}

fn known(table: &Table) -> Result<Family, Error> {
    family(&table.name).ok_or_else(|| format!("{}: no kind of reference file", table.name))
}

/// The cell that differs most from its recomputed value.
#[derive(Clone, Debug)]
pub struct Worst {
    /// Relative difference.
    pub deviation: f64,
    /// Row, from 1.
    pub row: usize,
    /// Name of the column.
    pub column: String,
}

/// A file against its recomputed values.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Rows recomputed.
    pub rows: usize,
    /// Cells compared.
    pub cells: usize,
    /// Cells that are the same to the last digit.
    pub equal: usize,
    /// The largest difference.
    pub worst: Worst,
}

/// Recomputes rows and compares all of their outputs.
///
/// # Errors
/// The file is of no known kind, or has a row that cannot be recomputed: which, and why.
pub fn compare(table: &Table, rows: impl Iterator<Item = usize>) -> Result<Comparison, Error> {
    let family = known(table)?;
    let worst = Worst {
        deviation: 0.0,
        row: 0,
        column: String::new(),
    };
    let mut comparison = Comparison {
        rows: 0,
        cells: 0,
        equal: 0,
        worst,
    };
    for index in rows {
        let row = table.row(index);
        comparison.rows += 1;
        for (column, value) in recomputed(table, family, index)?.iter() {
            if !row.has(column) {
                return Err(format!("{}: no column {column}", table.name));
            }
            let deviation = value.deviation(row.text(column));
            comparison.cells += 1;
            comparison.equal += usize::from(deviation == 0.0);
            if deviation > comparison.worst.deviation {
                comparison.worst = Worst {
                    deviation,
                    row: index + 1,
                    column: column.to_owned(),
                };
            }
        }
    }
    Ok(comparison)
}

/// So many rows of a table, evenly spread.
pub fn sample(table: &Table, count: usize) -> impl Iterator<Item = usize> {
    let rows = table.rows.len();
    let count = count.min(rows);
    (0..count).map(move |index| index * rows / count)
}

/// The file's text with its inputs as they are and its outputs recomputed.
///
/// # Errors
/// As [`compare`].
pub fn generate(table: &Table) -> Result<String, Error> {
    let family = known(table)?;
    let mut text = String::new();
    for line in table.comments.iter().chain([&table.columns.join(",")]) {
        text.push_str(line);
        text.push('\n');
    }
    for index in 0..table.rows.len() {
        let row = table.row(index);
        let values = recomputed(table, family, index)?;
        let cells = table.columns.iter().map(|column| {
            values
                .get(column)
                .map_or_else(|| row.text(column).to_owned(), value::Value::written)
        });
        text.push_str(&cells.collect::<Vec<_>>().join(","));
        text.push('\n');
    }
    Ok(text)
}
