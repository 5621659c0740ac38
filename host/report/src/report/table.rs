//! The tables, in Markdown.

use std::fmt::Write as _;

use super::row::Row;

fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// A task's candidates, the cheapest first.
pub fn task(rows: &[Row]) -> String {
    let mut rows: Vec<&Row> = rows.iter().collect();
    rows.sort_by(|a, b| {
        a.cost
            .instructions_mean
            .total_cmp(&b.cost.instructions_mean)
    });
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
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {lacking} | {:.0} | {} | {:.0} to {:.0} | {} |",
            short(row.error.error_median),
            short(row.error.error_p99),
            short(row.error.error_max),
            short(row.error.error_rms),
            row.cost.instructions_mean,
            row.cost.instructions_max,
            row.cost.cycles_low,
            row.cost.cycles_high,
            row.flash_bytes,
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
