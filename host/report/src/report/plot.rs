//! Error on one axis, cost on the other, the Pareto front drawn.

use std::path::Path;

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;

use super::delay;
use super::row::Row;

const SIZE: (u32, u32) = (1100, 720);
/// Colours that remain apart for colour-blind readers.
const CHOSEN: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
const OTHER: RGBColor = RGBColor(0x00, 0x72, 0xB2);
const LACKING: RGBColor = RGBColor(0x99, 0x99, 0x99);
/// First places and last ones.
const FIRST: RGBColor = RGBColor(0x00, 0x9E, 0x73);

/// The name under which plots ask for the font that they bring along.
const FONT: &str = "sans-serif";

/// A point with its name: error, cost.
struct Point {
    name: String,
    error: f64,
    cost: f64,
}

/// Points of one colour.
struct Group {
    name: &'static str,
    colour: RGBColor,
    radius: i32,
    points: Vec<Point>,
}

/// What is drawn: error along x, cost along y, both logarithmic.
struct Scatter {
    title: String,
    x: String,
    y: &'static str,
    groups: Vec<Group>,
    front: Vec<(f64, f64)>,
}

/// Draws a task as SVG into a folder.
pub fn task(folder: &Path, task: &str, rows: &[Row]) -> Result<()> {
    // What cannot run on the chip has no cost to draw.
    let rows: Vec<&Row> = rows.iter().filter(|row| row.on_chip.is_some()).collect();
    type Keep = fn(&&&Row) -> bool;
    let groups: [(&str, RGBColor, i32, Keep); 3] = [
        ("chosen", CHOSEN, 8, |row| row.chosen),
        ("candidate", OTHER, 5, |row| {
            !row.chosen && row.error.nonfinite == 0
        }),
        ("lacks answers", LACKING, 5, |row| {
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
        y: "executed instructions a call, mean",
        front: front(whole.map(point)),
        groups: groups
            .into_iter()
            .map(|(name, colour, radius, keep)| Group {
                name,
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
        y: "median delay from the true first contact, ms",
        front: front(all),
        groups: vec![
            Group {
                name: "first place told",
                colour: FIRST,
                radius: 9,
                points: speeds.iter().map(|row| first(row)).collect(),
            },
            Group {
                name: "last place: settled, or at the torque's limit",
                colour: OTHER,
                radius: 5,
                points: rows.iter().map(last).collect(),
            },
        ],
    };
    save(folder, "delay", &scatter)
}

fn save(folder: &Path, name: &str, scatter: &Scatter) -> Result<()> {
    plotters::style::register_font(FONT, FontStyle::Normal, dejavu::sans::regular())
        .map_err(|_| anyhow!("the font is unreadable"))?;
    let svg = folder.join(format!("{name}.svg"));
    draw(SVGBackend::new(&svg, SIZE).into_drawing_area(), scatter)
}

/// Zero has no place on a logarithmic axis: correctly rounded results stand at half a unit in the last place.
fn error(row: &Row) -> f64 {
    row.error.error_p99.max(3e-8)
}

/// Best error so far, from the cheapest on.
fn front(points: impl Iterator<Item = Point>) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = points.map(|point| (point.error, point.cost)).collect();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0)));
    let mut line: Vec<(f64, f64)> = Vec::new();
    for (error, cost) in sorted {
        match line.last() {
            Some(&(best, _)) if error >= best => {}
            // A staircase: until the next candidate costs this much, the last one's error is the best there is.
            Some(&(best, _)) => line.extend([(best, cost), (error, cost)]),
            None => line.push((error, cost)),
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

/// Label of a line of the mesh: 1, 2 and 5 of every decade, there is no room for more.
fn tick(value: f64) -> String {
    let leading = value / 10_f64.powf(value.log10().floor());
    if [1.0, 2.0, 5.0, 10.0]
        .iter()
        .any(|label| (leading - label).abs() < 1e-6)
    {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        String::new()
    }
}

fn draw<B: DrawingBackend>(area: DrawingArea<B, Shift>, scatter: &Scatter) -> Result<()> {
    paint(&area, scatter)
        .and_then(|()| area.present().map_err(|e| e.to_string()))
        .map_err(|e| anyhow!("{}: {e}", scatter.title))
}

fn paint<B: DrawingBackend>(area: &DrawingArea<B, Shift>, scatter: &Scatter) -> Result<(), String> {
    let text = |e: DrawingAreaErrorKind<B::ErrorType>| e.to_string();
    area.fill(&WHITE).map_err(text)?;
    let points = || scatter.groups.iter().flat_map(|group| &group.points);
    let range = |values: &mut dyn Iterator<Item = f64>, spare: f64| {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        low / spare..high * spare
    };
    let errors = range(&mut points().map(|point| point.error), 3.0);
    let costs = range(&mut points().map(|point| point.cost), 2.0);
    let plain = errors.start >= 1e-3;
    let mut chart = ChartBuilder::on(area)
        .caption(&scatter.title, (FONT, 26))
        .margin(18)
        .x_label_area_size(58)
        .y_label_area_size(92)
        .build_cartesian_2d(errors.log_scale(), costs.log_scale())
        .map_err(text)?;
    chart
        .configure_mesh()
        .x_desc(&scatter.x)
        .y_desc(scatter.y)
        .x_label_formatter(&|x| {
            if plain { tick(*x) } else { format!("{x:.0e}") }
        })
        .y_label_formatter(&|y| if plain { tick(*y) } else { format!("{y:.0}") })
        .label_style((FONT, 18))
        .axis_desc_style((FONT, 20))
        .light_line_style(WHITE)
        .draw()
        .map_err(text)?;
    chart
        .draw_series(LineSeries::new(
            scatter.front.iter().copied(),
            BLACK.mix(0.5).stroke_width(2),
        ))
        .map_err(text)?
        .label("Pareto front")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.mix(0.5).stroke_width(2)));
    for group in &scatter.groups {
        let (colour, radius) = (group.colour, group.radius);
        let dots = group
            .points
            .iter()
            .map(|point| Circle::new((point.error, point.cost), radius, colour.filled()));
        chart
            .draw_series(dots)
            .map_err(text)?
            .label(group.name)
            .legend(move |(x, y)| Circle::new((x + 10, y), radius, colour.filled()));
    }
    let at: Vec<(i32, i32)> = points()
        .map(|point| chart.backend_coord(&(point.error, point.cost)))
        .collect();
    let widths: Vec<i32> = points().map(|point| 10 * point.name.len() as i32).collect();
    for (point, place) in points().zip(labels(&at, &widths, SIZE.0 as i32 - 20)) {
        let style = (FONT, 17).into_font().color(&BLACK);
        area.draw(&Text::new(point.name.clone(), place, style))
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

#[cfg(test)]
mod tests {
    use super::{Point, front, tick};

    #[test]
    fn ticks_are_few_and_short() {
        let shown: Vec<String> = (1..=10).map(|n| tick(0.1 * f64::from(n))).collect();
        assert_eq!(shown.join(" "), "0.1 0.2   0.5     1");
        assert_eq!(tick(2000.0), "2000");
    }

    #[test]
    fn the_front_is_a_staircase_of_those_that_nothing_beats() {
        let point = |error, cost| Point {
            name: String::new(),
            error,
            cost,
        };
        let points = [
            point(1.0, 30.0),
            point(4.0, 10.0),
            point(2.0, 40.0),
            point(5.0, 20.0),
        ];
        assert_eq!(
            front(points.into_iter()),
            [(4.0, 10.0), (4.0, 30.0), (1.0, 30.0)]
        );
    }
}
