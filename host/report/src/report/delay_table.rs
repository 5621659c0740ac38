//! Delay against error as tables, in Markdown.

use std::fmt::Write as _;

use super::delay::{CLOSINGS, Choice, FINGERS, Row, USUAL};
use palpate_document::table::head;

/// For docs/RESULTS.md: the careful, the scene's own, and two hasty choices.
pub const SHOWN: [Choice; 4] = [
    Choice {
        closing_speed_rad_per_s: 0.15,
        wanted_deviation_mm: 0.2,
        ..USUAL
    },
    USUAL,
    Choice {
        closing_speed_rad_per_s: 0.6,
        wanted_deviation_mm: 1.0,
        ..USUAL
    },
    Choice {
        closing_speed_rad_per_s: 0.6,
        wanted_deviation_mm: 3.0,
        ..USUAL
    },
];

/// Some of the rows, in few columns.
pub fn short_table(rows: &[Row]) -> String {
    let mut text = head(
        "`closing-speed`, `wanted-deviation` | touch after, ms | first place after, ms | its error, mm | last \
         place after, ms | its error, mm",
    );
    for row in SHOWN
        .iter()
        .filter_map(|choice| rows.iter().find(|row| row.choice == *choice))
    {
        let _ = writeln!(
            text,
            "| {} rad/s, {} mm | {:.0} | {:.0} | {:.2} | {:.0} | {:.2} |",
            row.choice.closing_speed_rad_per_s,
            row.choice.wanted_deviation_mm,
            row.touch_ms[0],
            row.first_ms[0],
            row.first_error_mm[0],
            row.last_ms[0],
            row.last_error_mm[0],
        );
    }
    text
}

/// The table.
pub fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "Simulated: {FINGERS} calibrated fingers, {CLOSINGS} closings of each a row, on cylinders of 4 to 40 mm. Times from the\n\
         plant's true first contact until the firmware tells, milliseconds; |error| of k in mm; median / 90 %. First: the\n\
         first place told; last: settled, or at the torque's limit. The chip's time for a fit is not in the delays.\n\n\
         {}",
        head(
            "closing-speed, rad/s | wanted-deviation, mm | probe-torque, mNm | touch | first place | its error | last place \
             | its error | largest | located | settled"
        )
    );
    let ms = |[median, most]: [f64; 2]| format!("{median:.0} / {most:.0}");
    let mm = |[median, most]: [f64; 2]| format!("{median:.2} / {most:.2}");
    for row in rows {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {:.2} | {} of {} | {} |",
            row.choice.closing_speed_rad_per_s,
            row.choice.wanted_deviation_mm,
            row.choice.probe_torque_mnm,
            ms(row.touch_ms),
            ms(row.first_ms),
            mm(row.first_error_mm),
            ms(row.last_ms),
            mm(row.last_error_mm),
            row.last_error_mm_max,
            row.located,
            row.closings,
            row.settled,
        );
    }
    text
}
