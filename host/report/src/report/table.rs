//! The tables, in Markdown.

use std::fmt::Write as _;

use super::row::Row;
use palpate_document::table::head;

fn short(value: f64) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// A task's candidates, the cheapest first.
pub fn task(rows: &[Row]) -> String {
    let mut rows: Vec<&Row> = rows.iter().collect();
    rows.sort_by(|a, b| a.instructions().total_cmp(&b.instructions()));
    let unit = rows.first().map_or("", |row| row.error.error_unit);
    let mut text = head(
        "method | median | p99 | max | rms | lacking | instructions, mean | max | cycles | flash, bytes",
    );
    for row in rows {
        let name = if row.chosen {
            format!("**{}**", row.name)
        } else {
            row.name.clone()
        };
        let lacking = if row.error.spurious > 0 {
            format!("{} (+{} spurious)", row.error.nonfinite, row.error.spurious)
        } else {
            row.error.nonfinite.to_string()
        };
        let cost = row.on_chip.map_or(
            "needs the standard library | – | – | –".to_owned(),
            |chip| {
                format!(
                    "{:.0} | {} | {:.0} to {:.0} | {}",
                    chip.cost.instructions_mean,
                    chip.cost.instructions_max,
                    chip.cost.cycles_low,
                    chip.cost.cycles_high,
                    chip.flash_bytes
                )
            },
        );
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {lacking} | {cost} |",
            short(row.error.error_median),
            short(row.error.error_p99),
            short(row.error.error_max),
            short(row.error.error_rms),
        );
    }
    let _ = writeln!(text, "\nErrors: {unit}.");
    text
}

/// Why a row stands: the nearest cheaper one, whose error is larger, and the cheapest one with less error, which costs more.
fn rivals<'a>(rows: &'a [Row], chosen: &Row) -> [Option<&'a Row>; 2] {
    let rivals = || {
        rows.iter().filter(|row| {
            row.task == chosen.task && row.name != chosen.name && row.on_chip.is_some()
        })
    };
    let cheaper = rivals()
        .filter(|row| row.instructions() < chosen.instructions())
        .max_by(|a, b| a.instructions().total_cmp(&b.instructions()));
    let nearer = rivals()
        .filter(|row| row.error.nonfinite == 0 && row.error.error_max < chosen.error.error_max)
        .min_by(|a, b| a.instructions().total_cmp(&b.instructions()));
    [cheaper, nearer]
}

/// What the code uses, and the numbers that say why.
pub fn choices(rows: &[Row]) -> String {
    let mut text = head(
        "task | chosen | instructions | largest error | next cheaper | cheapest with less error | where and why",
    );
    for row in rows.iter().filter(|row| row.chosen) {
        let [cheaper, nearer] = rivals(rows, row).map(|rival| {
            rival.map_or("none".to_owned(), |rival| {
                let lacking = match rival.error.nonfinite {
                    0 => String::new(),
                    count => format!(", lacks {count}"),
                };
                format!(
                    "{}: {:.0}, {}{lacking}",
                    rival.name,
                    rival.instructions(),
                    short(rival.error.error_max)
                )
            })
        });
        let _ = writeln!(
            text,
            "| {} | {} | {:.0} | {} {} | {cheaper} | {nearer} | {} |",
            row.task,
            row.name,
            row.instructions(),
            short(row.error.error_max),
            row.error.error_unit,
            row.why.unwrap_or_default()
        );
    }
    text
}
