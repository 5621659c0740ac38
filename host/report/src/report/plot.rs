//! Error on one axis, cost on the other, the Pareto front drawn.

use std::path::Path;

use anyhow::{Result, anyhow};
use palpate_document::chart::{BLUE, GREEN, GREY, ORANGE};
use palpate_document::scatter::{Group, Point, Scatter, front, write};

use super::delay;
use super::row::Row;

/// Draws a task as SVG into a folder.
pub fn task(folder: &Path, task: &str, rows: &[Row]) -> Result<()> {
    // What cannot run on the chip has no cost to draw.
    let rows: Vec<&Row> = rows.iter().filter(|row| row.on_chip.is_some()).collect();
    type Keep = fn(&&&Row) -> bool;
    let groups: [(&str, _, i32, Keep); 3] = [
        ("chosen", ORANGE, 8, |row| row.chosen),
        ("candidate", BLUE, 5, |row| {
            !row.chosen && row.error.nonfinite == 0
        }),
        ("lacks answers", GREY, 5, |row| {
            !row.chosen && row.error.nonfinite > 0
        }),
    ];
    let point = |row: &&Row| Point {
        name: row.name.clone(),
        error: error(row),
        cost: row.instructions().max(1.0),
    };
    let unit = rows.first().map_or("", |row| row.error.error_unit);
    let whole = rows.iter().filter(|row| row.error.nonfinite == 0);
    let scatter = Scatter {
        title: format!("{task}: error against cost, emulated Cortex-M4F"),
        x: format!("99th percentile of the error over random and hard rows, {unit}"),
        y: "executed instructions a call, mean".to_owned(),
        front: front(whole.map(point)),
        groups: groups
            .into_iter()
            .map(|(name, colour, radius, keep)| Group {
                name: name.to_owned(),
                colour,
                radius,
                points: rows.iter().filter(keep).map(point).collect(),
            })
            .collect(),
    };
    save(folder, task, &scatter)
}

/// Draws delay against error, the user's trade.
pub fn delays(folder: &Path, rows: &[delay::Row]) -> Result<()> {
    let first = |row: &delay::Row| Point {
        name: format!("{} rad/s", row.choice.closing_speed_rad_per_s),
        error: row.first_error_mm[0],
        cost: row.first_ms[0],
    };
    let last = |row: &delay::Row| Point {
        name: row.label(),
        error: row.last_error_mm[0],
        cost: row.last_ms[0],
    };
    // The first place depends on the speed alone: one point each.
    let mut speeds: Vec<&delay::Row> = Vec::new();
    for row in rows {
        let speed = row.choice.closing_speed_rad_per_s;
        if !speeds
            .iter()
            .any(|other| other.choice.closing_speed_rad_per_s == speed)
        {
            speeds.push(row);
        }
    }
    let all = speeds
        .iter()
        .map(|row| first(row))
        .chain(rows.iter().map(last));
    let scatter = Scatter {
        title: "time from first contact against error, simulated".to_owned(),
        x: "median |error| of the place, mm".to_owned(),
        y: "median delay from the true first contact, ms".to_owned(),
        front: front(all),
        groups: vec![
            Group {
                name: "first place told".to_owned(),
                colour: GREEN,
                radius: 9,
                points: speeds.iter().map(|row| first(row)).collect(),
            },
            Group {
                name: "last place: settled, or at the torque's limit".to_owned(),
                colour: BLUE,
                radius: 5,
                points: rows.iter().map(last).collect(),
            },
        ],
    };
    save(folder, "delay", &scatter)
}

fn save(folder: &Path, name: &str, scatter: &Scatter) -> Result<()> {
    write(folder, name, scatter).map_err(|error| anyhow!("{}: {error}", scatter.title))
}

/// Zero has no place on a logarithmic axis: correctly rounded results stand at half a unit in the last place.
fn error(row: &Row) -> f64 {
    row.error.error_p99.max(3e-8)
}
