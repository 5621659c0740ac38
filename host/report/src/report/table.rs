//! The tables, in Markdown.

use std::fmt::Write as _;

use super::row::Row;

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
    let mut text = "| method | median | p99 | max | rms | lacking | instructions, mean | max | cycles | flash, bytes |\n\
                    |---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
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

/// What the firmware uses, and why.
pub fn choices(rows: &[Row]) -> String {
    let mut text = "| task | chosen | where and why |\n|---|---|---|\n".to_owned();
    for row in rows.iter().filter(|row| row.chosen) {
        let _ = writeln!(
            text,
            "| {} | {} | {} |",
            row.task,
            row.name,
            row.why.unwrap_or_default()
        );
    }
    text
}
