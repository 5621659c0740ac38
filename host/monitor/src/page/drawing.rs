//! Small drawings as inline SVG in the page's own colours, so that they follow it into dark mode and onto paper; a plotting
//! crate writes colours of its own.

use std::fmt::Write;

use crate::posture::Points;
use crate::state::Contact;

/// Size of a drawing, pixels.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 260.0;
/// Room for the axes' numbers.
const MARGIN: f64 = 38.0;
/// Points of a series that are drawn at most.
const DRAWN: usize = 700;

/// Points that belong together.
pub(super) struct Series<'a> {
    name: &'static str,
    colour: &'static str,
    joined: bool,
    points: &'a [(f64, f64)],
}

impl<'a> Series<'a> {
    /// Single points.
    pub(super) fn points(
        name: &'static str,
        colour: &'static str,
        points: &'a [(f64, f64)],
    ) -> Self {
        Self {
            name,
            colour,
            joined: false,
            points,
        }
    }

    /// A line through them.
    pub(super) fn line(name: &'static str, colour: &'static str, points: &'a [(f64, f64)]) -> Self {
        Self {
            joined: true,
            ..Self::points(name, colour, points)
        }
    }
}

/// Least and largest of the finite values, kept apart.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low < high {
        (low, high)
    } else if low.is_finite() {
        (low - 1.0, low + 1.0)
    } else {
        (0.0, 1.0)
    }
}

/// Series over common axes.
pub(super) fn plot(series: &[Series]) -> String {
    let all = || series.iter().flat_map(|series| series.points.iter());
    let (x0, x1) = range(all().map(|point| point.0));
    let (y0, y1) = range(all().map(|point| point.1).chain([0.0]));
    let px = |x: f64| MARGIN + (x - x0) / (x1 - x0) * (WIDTH - MARGIN - 8.0);
    let py = |y: f64| HEIGHT - 22.0 - (y - y0) / (y1 - y0) * (HEIGHT - 40.0);
    let mut svg = open();
    for tick in 0..=4 {
        let share = f64::from(tick) / 4.0;
        let (x, y) = (x0 + share * (x1 - x0), y0 + share * (y1 - y0));
        let _ = write!(
            svg,
            "<line x1=\"{MARGIN}\" x2=\"{WIDTH}\" y1=\"{0:.1}\" y2=\"{0:.1}\" stroke=\"var(--faint)\" stroke-width=\".3\"/>\
             <text x=\"{1:.1}\" y=\"{2}\" text-anchor=\"middle\">{3}</text>\
             <text x=\"{4}\" y=\"{5:.1}\" text-anchor=\"end\">{6}</text>",
            py(y),
            px(x),
            HEIGHT - 6.0,
            label(x, x1 - x0),
            MARGIN - 4.0,
            py(y) + 3.5,
            label(y, y1 - y0)
        );
    }
    for (row, series) in series.iter().enumerate() {
        let step = series.points.len().div_ceil(DRAWN).max(1);
        let shown = series
            .points
            .iter()
            .step_by(step)
            .filter(|point| point.0.is_finite() && point.1.is_finite());
        if series.joined {
            let path: Vec<String> = shown
                .map(|&(x, y)| format!("{:.1},{:.1}", px(x), py(y)))
                .collect();
            let _ = write!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"var(--{})\" stroke-width=\"1.6\"/>",
                path.join(" "),
                series.colour
            );
        } else {
            for &(x, y) in shown {
                let _ = write!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"1\" fill=\"var(--{})\"/>",
                    px(x),
                    py(y),
                    series.colour
                );
            }
        }
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{}\" fill=\"var(--{})\">{}</text>",
            MARGIN + 6.0,
            14 + 13 * row,
            series.colour,
            series.name
        );
    }
    svg.push_str("</svg>");
    svg
}

/// The finger as drawn points, with the contact's two-deviation band, the force, and the truth where it is known.
pub(super) fn posture(
    points: &Points,
    contact: Option<&Contact>,
    truth: Option<(u32, f64, f64)>,
) -> String {
    let (x0, x1) = range(points.iter().map(|point| point[0]));
    let (y0, y1) = range(points.iter().map(|point| point[1]));
    let scale = (WIDTH - 60.0) / (x1 - x0).max((y1 - y0) * WIDTH / HEIGHT).max(0.08);
    let (middle_x, middle_y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let to = |point: [f64; 2]| {
        (
            0.5 * WIDTH + 0.8 * scale * (point[0] - middle_x),
            0.5 * HEIGHT - 0.8 * scale * (point[1] - middle_y),
        )
    };
    let mut svg = open();
    let path: Vec<String> = points
        .iter()
        .map(|&point| {
            let (x, y) = to(point);
            format!("{x:.1},{y:.1}")
        })
        .collect();
    let _ = write!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"var(--faint)\" stroke-opacity=\".45\" stroke-width=\"{:.1}\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\"/>",
        path.join(" "),
        (0.8 * scale * 0.012).max(3.0)
    );
    for &point in points {
        let (x, y) = to(point);
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"var(--ink)\"/>"
        );
    }
    // A point on a phalanx, lifted to its palm side.
    let on = |phalanx: u32, k_mm: f64, lift_m: f64| {
        let first = usize::try_from(phalanx).ok()?.checked_sub(1)?;
        let (from, end) = (*points.get(first)?, *points.get(first + 1)?);
        let (dx, dy) = (end[0] - from[0], end[1] - from[1]);
        let length = dx.hypot(dy);
        let share = (1e-3 * k_mm / length).clamp(0.0, 1.0);
        Some(to([
            from[0] + share * dx - lift_m * dy / length,
            from[1] + share * dy + lift_m * dx / length,
        ]))
    };
    for place in contact.map_or(&[][..], |contact| contact.places.as_slice()) {
        let (low, high) = (
            on(place.phalanx, place.k_mm - 2.0 * place.sigma_mm, 0.008),
            on(place.phalanx, place.k_mm + 2.0 * place.sigma_mm, 0.008),
        );
        if let (Some(low), Some(high)) = (low, high) {
            let _ = write!(
                svg,
                "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"var(--green)\" stroke-width=\"4\" stroke-linecap=\"round\"/>",
                low.0, low.1, high.0, high.1
            );
        }
        let (head, tail) = (
            on(place.phalanx, place.k_mm, 0.006),
            on(place.phalanx, place.k_mm, 0.034),
        );
        if let (Some(head), Some(tail)) = (head, tail) {
            let _ = write!(
                svg,
                "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"var(--green)\" stroke-width=\"1.5\" marker-end=\"url(#head)\"/>",
                tail.0, tail.1, head.0, head.1
            );
        }
    }
    if let Some((x, y)) = truth.and_then(|(phalanx, k_mm, _)| on(phalanx, k_mm, 0.006)) {
        let _ = write!(
            svg,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"var(--red)\">×</text>",
            y + 4.0
        );
    }
    svg.push_str("</svg>");
    svg
}

fn open() -> String {
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-size=\"10\" fill=\"var(--ink)\" font-family=\"system-ui,sans-serif\" role=\"img\">\
         <defs><marker id=\"head\" orient=\"auto\" markerWidth=\"7\" markerHeight=\"7\" refX=\"6\" refY=\"3\">\
         <path d=\"M0,0 L6,3 L0,6 z\" fill=\"var(--green)\"/></marker></defs>"
    )
}

/// A number with the digits that its axis needs.
fn label(value: f64, span: f64) -> String {
    let digits = if span >= 20.0 {
        0
    } else if span >= 2.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$}")
}
