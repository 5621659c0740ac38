//! Error on one axis, cost on the other, the Pareto front drawn.

use std::path::Path;

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;

use super::row::Row;

const SIZE: (u32, u32) = (1100, 720);
/// Colours that remain apart for colour-blind readers.
const CHOSEN: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
const OTHER: RGBColor = RGBColor(0x00, 0x72, 0xB2);
const LACKING: RGBColor = RGBColor(0x99, 0x99, 0x99);

/// The name under which plots ask for the font that they bring along.
const FONT: &str = "sans-serif";

/// Draws a task as SVG and PNG into a folder.
pub fn task(folder: &Path, task: &str, rows: &[Row]) -> Result<()> {
    plotters::style::register_font(FONT, FontStyle::Normal, dejavu::sans::regular())
        .map_err(|_| anyhow!("the font is unreadable"))?;
    // What cannot run on the chip has no cost to draw.
    let rows: Vec<Row> = rows
        .iter()
        .filter(|row| row.on_chip.is_some())
        .cloned()
        .collect();
    let rows = rows.as_slice();
    let svg = folder.join(format!("{task}.svg"));
    let png = folder.join(format!("{task}.png"));
    draw(SVGBackend::new(&svg, SIZE).into_drawing_area(), task, rows)?;
    draw(
        BitMapBackend::new(&png, SIZE).into_drawing_area(),
        task,
        rows,
    )
}

/// Zero has no place on a logarithmic axis: correctly rounded results stand at half a unit in the last place.
fn error(row: &Row) -> f64 {
    row.error.error_p99.max(3e-8)
}

fn cost(row: &Row) -> f64 {
    row.instructions().max(1.0)
}

/// Best error so far, from the cheapest candidate on.
fn front(rows: &[Row]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<&Row> = rows.iter().filter(|row| row.error.nonfinite == 0).collect();
    sorted.sort_by(|a, b| {
        cost(a)
            .total_cmp(&cost(b))
            .then(error(a).total_cmp(&error(b)))
    });
    let mut line: Vec<(f64, f64)> = Vec::new();
    for row in sorted {
        match line.last() {
            Some(&(best, _)) if error(row) >= best => {}
            // A staircase: until the next candidate costs this much, the last one's error is the best there is.
            Some(&(best, _)) => line.extend([(best, cost(row)), (error(row), cost(row))]),
            None => line.push((error(row), cost(row))),
        }
    }
    line
}

/// Places for the labels: right of the points, moved down until none covers another.
fn labels(points: &[(i32, i32)], widths: &[i32], right: i32) -> Vec<(i32, i32)> {
    const HEIGHT: i32 = 19;
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_key(|&i| points[i].1);
    let mut placed: Vec<(i32, i32, i32)> = Vec::new();
    let mut result = vec![(0, 0); points.len()];
    for i in order {
        let (x, y) = points[i];
        let x = if x + 12 + widths[i] > right {
            x - 12 - widths[i]
        } else {
            x + 12
        };
        let mut y = y - HEIGHT / 2;
        while let Some(&(_, other, _)) = placed.iter().find(|&&(from, other, to)| {
            from < x + widths[i] && x < to && (other - y).abs() < HEIGHT
        }) {
            y = other + HEIGHT;
        }
        placed.push((x, y, x + widths[i]));
        result[i] = (x, y);
    }
    result
}

fn draw<B: DrawingBackend>(area: DrawingArea<B, Shift>, task: &str, rows: &[Row]) -> Result<()> {
    paint(&area, task, rows)
        .and_then(|()| area.present().map_err(|e| e.to_string()))
        .map_err(|e| anyhow!("{task}: {e}"))
}

fn paint<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    task: &str,
    rows: &[Row],
) -> Result<(), String> {
    let text = |e: DrawingAreaErrorKind<B::ErrorType>| e.to_string();
    area.fill(&WHITE).map_err(text)?;
    let range = |values: &mut dyn Iterator<Item = f64>, spare: f64| {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        low / spare..high * spare
    };
    let errors = range(&mut rows.iter().map(error), 3.0);
    let costs = range(&mut rows.iter().map(cost), 2.0);
    let unit = rows.first().map_or("", |row| row.error.error_unit);
    let mut chart = ChartBuilder::on(area)
        .caption(
            format!("{task}: error against cost, emulated Cortex-M4F"),
            (FONT, 26),
        )
        .margin(18)
        .x_label_area_size(58)
        .y_label_area_size(92)
        .build_cartesian_2d(errors.log_scale(), costs.log_scale())
        .map_err(text)?;
    chart
        .configure_mesh()
        .x_desc(format!(
            "99th percentile of the error over random and hard rows, {unit}"
        ))
        .y_desc("executed instructions a call, mean")
        .x_label_formatter(&|x| format!("{x:.0e}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .label_style((FONT, 18))
        .axis_desc_style((FONT, 20))
        .light_line_style(WHITE)
        .draw()
        .map_err(text)?;
    chart
        .draw_series(LineSeries::new(front(rows), BLACK.mix(0.5).stroke_width(2)))
        .map_err(text)?
        .label("Pareto front")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.mix(0.5).stroke_width(2)));
    type Keep = fn(&&Row) -> bool;
    let groups: [(&str, RGBColor, Keep); 3] = [
        ("chosen", CHOSEN, |row| row.chosen),
        ("candidate", OTHER, |row| {
            !row.chosen && row.error.nonfinite == 0
        }),
        ("lacks answers", LACKING, |row| {
            !row.chosen && row.error.nonfinite > 0
        }),
    ];
    for (name, colour, keep) in groups {
        let radius = if name == "chosen" { 8 } else { 5 };
        let points = rows
            .iter()
            .filter(keep)
            .map(|row| Circle::new((error(row), cost(row)), radius, colour.filled()));
        chart
            .draw_series(points)
            .map_err(text)?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 10, y), radius, colour.filled()));
    }
    let at: Vec<(i32, i32)> = rows
        .iter()
        .map(|row| chart.backend_coord(&(error(row), cost(row))))
        .collect();
    let widths: Vec<i32> = rows.iter().map(|row| 10 * row.name.len() as i32).collect();
    for (row, place) in rows.iter().zip(labels(&at, &widths, SIZE.0 as i32 - 20)) {
        let style = (FONT, 17).into_font().color(&BLACK);
        area.draw(&Text::new(row.name.clone(), place, style))
            .map_err(text)?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.9))
        .border_style(BLACK.mix(0.3))
        .label_font((FONT, 18))
        .draw()
        .map_err(text)
}
