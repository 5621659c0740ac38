//! Charts with lines and marks on two axes.

use std::path::Path;

use plotters::coord::Shift;
use plotters::element::IntoDynElement;
use plotters::prelude::*;
use plotters::style::FontStyle;

use crate::look::{FONT, fonts};

pub use crate::look::{AMBER, BLUE, DrawError, GREEN, GREY, ORANGE, PINK, SKY};
pub use plotters::style::RGBColor;

/// Size of every figure, pixel.
const SIZE: (u32, u32) = (960, 620);
/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Solid line.
    Line,
    /// Thin dashed line.
    Dashes,
    /// Filled circles.
    Dots,
    /// Open circles.
    Rings,
    /// Upright crosses.
    Crosses,
}

/// Points with a look; an empty label keeps it out of the legend.
#[derive(Clone, Debug)]
pub struct Series {
    /// Text in the legend.
    pub label: String,
    /// Colour.
    pub colour: RGBColor,
    /// Look.
    pub mark: Mark,
    /// Data; points that are not finite interrupt a line.
    pub points: Vec<(f64, f64)>,
    /// Half lengths of vertical error bars, one a point, or none.
    pub bars: Vec<f64>,
}

impl Series {
    /// A series without error bars.
    pub fn new(
        label: impl Into<String>,
        colour: RGBColor,
        mark: Mark,
        points: Vec<(f64, f64)>,
    ) -> Self {
        Self {
            label: label.into(),
            colour,
            mark,
            points,
            bars: Vec::new(),
        }
    }
}

/// Where the legend goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legend {
    /// Top left corner.
    UpperLeft,
    /// Top right corner.
    UpperRight,
    /// Bottom right corner.
    LowerRight,
}

/// A chart with two axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Quantity and unit.
    pub x_label: String,
    /// Quantity and unit.
    pub y_label: String,
    /// Ends of the axis.
    pub x: (f64, f64),
    /// Ends of the axis; both positive if it is logarithmic.
    pub y: (f64, f64),
    /// Decades along y.
    pub log_y: bool,
    /// Place of the legend.
    pub legend: Legend,
    /// What is drawn, first at the back.
    pub series: Vec<Series>,
}

/// Writes `charts` side by side as `name.svg` into `directory`.
///
/// # Errors
/// Whatever keeps the files from being written.
pub fn write(directory: &Path, name: &str, charts: &[Chart]) -> Result<(), DrawError> {
    fonts()?;
    std::fs::create_dir_all(directory)?;
    let size = (SIZE.0 * charts.len().max(1) as u32, SIZE.1);
    let svg = directory.join(format!("{name}.svg"));
    row(&SVGBackend::new(&svg, size).into_drawing_area(), charts)
}

fn row<B: DrawingBackend>(area: &DrawingArea<B, Shift>, charts: &[Chart]) -> Result<(), DrawError>
where
    B::ErrorType: 'static,
{
    area.fill(&WHITE)?;
    for (chart, part) in charts
        .iter()
        .zip(area.split_evenly((1, charts.len().max(1))))
    {
        draw(&part, chart)?;
    }
    area.present()?;
    Ok(())
}

/// Both kinds of axes end here.
macro_rules! draw_on {
    ($area:expr, $chart:expr, $y:expr, $format:expr) => {{
        let chart = $chart;
        let mut context = ChartBuilder::on($area)
            .caption(&chart.title, (FONT, 22).into_font().style(FontStyle::Bold))
            .margin(14)
            .margin_right(28)
            .x_label_area_size(54)
            .y_label_area_size(78)
            .build_cartesian_2d(chart.x.0..chart.x.1, $y)?;
        context
            .configure_mesh()
            .x_desc(&chart.x_label)
            .y_desc(&chart.y_label)
            .axis_desc_style((FONT, 19))
            .label_style((FONT, 16))
            .y_label_formatter(&$format)
            .light_line_style(RGBColor(240, 240, 240))
            .bold_line_style(RGBColor(215, 215, 215))
            .draw()?;
        for series in &chart.series {
            let colour = series.colour;
            let inside = |&(x, y): &(f64, f64)| {
                (chart.x.0..=chart.x.1).contains(&x) && (chart.y.0..=chart.y.1).contains(&y)
            };
            for (point, bar) in series.points.iter().zip(&series.bars) {
                let (low, high) = (point.1 - bar, point.1 + bar);
                context.draw_series([PathElement::new(
                    [
                        (point.0, low.max(chart.y.0)),
                        (point.0, high.min(chart.y.1)),
                    ],
                    colour.mix(0.45).stroke_width(2),
                )])?;
            }
            let shown = || series.points.iter().copied().filter(inside);
            let stroke = |width: u32| colour.stroke_width(width);
            let drawn = match series.mark {
                Mark::Line | Mark::Dashes => {
                    let mut first = None;
                    for run in series.points.split(|point| !inside(point)) {
                        if run.len() < 2 {
                            continue;
                        }
                        let points = run.iter().copied();
                        let annotation = if series.mark == Mark::Line {
                            context.draw_series(LineSeries::new(points, stroke(3)))?
                        } else {
                            context.draw_series(DashedLineSeries::new(points, 9, 6, stroke(2)))?
                        };
                        if first.is_none() {
                            first = Some(());
                            label(annotation, series);
                        }
                    }
                    continue;
                }
                Mark::Dots => {
                    context.draw_series(shown().map(|p| Circle::new(p, 4, colour.filled())))?
                }
                Mark::Rings => {
                    context.draw_series(shown().map(|p| Circle::new(p, 5, stroke(2))))?
                }
                Mark::Crosses => {
                    context.draw_series(shown().map(|p| Cross::new(p, 5, stroke(2))))?
                }
            };
            label(drawn, series);
        }
        let position = match chart.legend {
            Legend::UpperLeft => SeriesLabelPosition::UpperLeft,
            Legend::UpperRight => SeriesLabelPosition::UpperRight,
            Legend::LowerRight => SeriesLabelPosition::LowerRight,
        };
        if chart.series.iter().any(|series| !series.label.is_empty()) {
            context
                .configure_series_labels()
                .position(position)
                .margin(14)
                .label_font((FONT, 16))
                .background_style(WHITE.mix(0.88))
                .border_style(RGBColor(190, 190, 190))
                .draw()?;
        }
    }};
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, chart: &Chart) -> Result<(), DrawError>
where
    B::ErrorType: 'static,
{
    if chart.log_y {
        let range = (chart.y.0..chart.y.1).log_scale();
        draw_on!(area, chart, range, |value: &f64| plain(*value));
    } else {
        draw_on!(area, chart, chart.y.0..chart.y.1, |value: &f64| plain(
            *value
        ));
    }
    Ok(())
}

/// A tick's number without needless digits.
fn plain(value: f64) -> String {
    let rounded = (value * 1e6).round() * 1e-6;
    let text = format!("{rounded:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

fn label<'a, B: DrawingBackend + 'a>(
    annotation: &mut plotters::chart::SeriesAnno<'a, B>,
    series: &Series,
) {
    if series.label.is_empty() {
        return;
    }
    let (colour, mark) = (series.colour, series.mark);
    annotation
        .label(&series.label)
        .legend(move |(x, y)| match mark {
            Mark::Line => {
                PathElement::new([(x, y), (x + 22, y)], colour.stroke_width(3)).into_dyn()
            }
            // One stroke: a composed element would have to own its backend.
            Mark::Dashes => {
                PathElement::new([(x, y), (x + 9, y)], colour.stroke_width(2)).into_dyn()
            }
            Mark::Dots => Circle::new((x + 11, y), 4, colour.filled()).into_dyn(),
            Mark::Rings => Circle::new((x + 11, y), 5, colour.stroke_width(2)).into_dyn(),
            Mark::Crosses => Cross::new((x + 11, y), 5, colour.stroke_width(2)).into_dyn(),
        });
}
