//! Points with names, error on one axis, cost on the other, and the Pareto front.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::look::{DrawError, FONT, fonts};

const SIZE: (u32, u32) = (1100, 720);

/// A point with its name: error, cost.
pub struct Point {
    /// Text beside it.
    pub name: String,
    /// Along x.
    pub error: f64,
    /// Along y.
    pub cost: f64,
}

/// Points of one colour.
pub struct Group {
    /// Text in the legend.
    pub name: String,
    /// Colour.
    pub colour: RGBColor,
    /// Of the dots, pixel.
    pub radius: i32,
    /// Data.
    pub points: Vec<Point>,
}

/// What is drawn: error along x, cost along y, both logarithmic.
pub struct Scatter {
    /// What it shows.
    pub title: String,
    /// Quantity and unit.
    pub x: String,
    /// Quantity and unit.
    pub y: String,
    /// What is drawn.
    pub groups: Vec<Group>,
    /// The line of those that nothing beats, see [`front`].
    pub front: Vec<(f64, f64)>,
}

/// Draws into `name.svg` of a folder.
///
/// # Errors
/// Whatever keeps the file from being written.
pub fn write(folder: &Path, name: &str, scatter: &Scatter) -> Result<(), DrawError> {
    fonts()?;
    let svg = folder.join(format!("{name}.svg"));
    draw(&SVGBackend::new(&svg, SIZE).into_drawing_area(), scatter)
}

/// Best error so far, from the cheapest on.
pub fn front(points: impl Iterator<Item = Point>) -> Vec<(f64, f64)> {
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

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, scatter: &Scatter) -> Result<(), DrawError>
where
    B::ErrorType: 'static,
{
    area.fill(&WHITE)?;
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
        .build_cartesian_2d(errors.log_scale(), costs.log_scale())?;
    chart
        .configure_mesh()
        .x_desc(&scatter.x)
        .y_desc(&scatter.y)
        .x_label_formatter(&|x| {
            if plain { tick(*x) } else { format!("{x:.0e}") }
        })
        .y_label_formatter(&|y| if plain { tick(*y) } else { format!("{y:.0}") })
        .label_style((FONT, 18))
        .axis_desc_style((FONT, 20))
        .light_line_style(WHITE)
        .draw()?;
    chart
        .draw_series(LineSeries::new(
            scatter.front.iter().copied(),
            BLACK.mix(0.5).stroke_width(2),
        ))?
        .label("Pareto front")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.mix(0.5).stroke_width(2)));
    for group in &scatter.groups {
        let (colour, radius) = (group.colour, group.radius);
        let dots = group
            .points
            .iter()
            .map(|point| Circle::new((point.error, point.cost), radius, colour.filled()));
        chart
            .draw_series(dots)?
            .label(&group.name)
            .legend(move |(x, y)| Circle::new((x + 10, y), radius, colour.filled()));
    }
    let at: Vec<(i32, i32)> = points()
        .map(|point| chart.backend_coord(&(point.error, point.cost)))
        .collect();
    let widths: Vec<i32> = points().map(|point| 10 * point.name.len() as i32).collect();
    for (point, place) in points().zip(labels(&at, &widths, SIZE.0 as i32 - 20)) {
        let style = (FONT, 17).into_font().color(&BLACK);
        area.draw(&Text::new(point.name.clone(), place, style))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.9))
        .border_style(BLACK.mix(0.3))
        .label_font((FONT, 18))
        .draw()?;
    area.present()?;
    Ok(())
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
