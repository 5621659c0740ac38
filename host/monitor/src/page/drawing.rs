//! Small drawings as inline SVG in the page's own colours, so that they follow it into dark mode and onto paper; a plotting
//! crate writes colours of its own.

use std::fmt::Write;

use crate::figure::{Picture, Role, Series, range};

/// Size of a drawing, pixels.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 260.0;
/// Room for the axes' numbers.
const MARGIN: f64 = 38.0;
/// Points of a series that are drawn at most.
const DRAWN: usize = 700;

/// The page's colour of what is drawn.
fn colour(role: Role) -> &'static str {
    match role {
        Role::Measured => "ink",
        Role::Estimate => "green",
        Role::Alternative | Role::Threshold => "amber",
        Role::Truth => "red",
        Role::Friction => "blue",
    }
}

/// Series over common axes.
pub(super) fn plot(series: &[Series]) -> String {
    let all = || series.iter().flat_map(|series| series.points.iter());
    let (x0, x1) = range(all().map(|point| point.0), (0.0, 1.0));
    let (y0, y1) = range(all().map(|point| point.1).chain([0.0]), (0.0, 1.0));
    let px = |x: f64| MARGIN + (x - x0) / (x1 - x0) * (WIDTH - MARGIN - 8.0);
    let py = |y: f64| HEIGHT - 22.0 - (y - y0) / (y1 - y0) * (HEIGHT - 40.0);
    let mut svg = open();
    for x in ticks(x0, x1) {
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            px(x),
            HEIGHT - 6.0,
            label(x, x1 - x0)
        );
    }
    for y in ticks(y0, y1) {
        let _ = write!(
            svg,
            "<line x1=\"{MARGIN}\" x2=\"{WIDTH}\" y1=\"{0:.1}\" y2=\"{0:.1}\" stroke=\"var(--faint)\" stroke-width=\".3\"/>\
             <text x=\"{1}\" y=\"{2:.1}\" text-anchor=\"end\">{3}</text>",
            py(y),
            MARGIN - 4.0,
            py(y) + 3.5,
            label(y, y1 - y0)
        );
    }
    let shown = series.iter().filter(|one| !one.points.is_empty());
    let mut row = 0;
    for series in shown {
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
                "<polyline points=\"{}\" fill=\"none\" stroke=\"var(--{})\" stroke-width=\"1.6\" stroke-linejoin=\"round\"/>",
                path.join(" "),
                colour(series.role)
            );
        } else {
            for &(x, y) in shown {
                let _ = write!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"1\" fill=\"var(--{})\"/>",
                    px(x),
                    py(y),
                    colour(series.role)
                );
            }
        }
        if series.name.is_empty() {
            continue;
        }
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{}\" fill=\"var(--{})\">{}</text>",
            MARGIN + 6.0,
            14 + 13 * row,
            colour(series.role),
            series.name
        );
        row += 1;
    }
    svg.push_str("</svg>");
    svg
}

/// The finger with the contact, as large as fits.
pub(super) fn posture(picture: &Picture) -> String {
    let ends = || picture.strokes.iter().flat_map(|s| [s.from, s.to]);
    let (x0, x1) = range(ends().map(|point| point[0]), (0.0, 0.1));
    let (y0, y1) = range(ends().map(|point| point[1]), (0.0, 0.1));
    let scale = ((WIDTH - 40.0) / (x1 - x0)).min((HEIGHT - 30.0) / (y1 - y0));
    let (middle_x, middle_y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let to = |point: [f64; 2]| {
        (
            0.5 * WIDTH + scale * (point[0] - middle_x),
            0.5 * HEIGHT - scale * (point[1] - middle_y),
        )
    };
    let mut svg = open();
    for &(centre, radius) in &picture.circles {
        let (x, y) = to(centre);
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"none\" stroke=\"var(--ink)\"/>",
            scale * radius
        );
    }
    for stroke in &picture.strokes {
        let ((xa, ya), (xb, yb)) = (to(stroke.from), to(stroke.to));
        let width = if stroke.role == Role::Measured {
            1.0
        } else {
            2.0
        };
        let _ = write!(
            svg,
            "<line x1=\"{xa:.1}\" y1=\"{ya:.1}\" x2=\"{xb:.1}\" y2=\"{yb:.1}\" stroke=\"var(--{})\" \
             stroke-width=\"{width}\" stroke-linecap=\"round\"/>",
            colour(stroke.role)
        );
    }
    if let Some(at) = picture.truth {
        let (x, y) = to(at);
        let _ = write!(
            svg,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"14\" fill=\"var(--red)\">×</text>",
            y + 5.0
        );
    }
    svg.push_str("</svg>");
    svg
}

fn open() -> String {
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-size=\"10\" fill=\"var(--ink)\" font-family=\"system-ui,sans-serif\" role=\"img\">"
    )
}

/// Some four round numbers within a range.
fn ticks(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let wanted = (high - low) / 4.0;
    let ten = 10f64.powf(wanted.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * ten)
        .into_iter()
        .find(|step| *step >= wanted)
        .unwrap_or(wanted);
    let first = (low / step).ceil();
    (0..10)
        .map(move |n| step * (first + f64::from(n)))
        .take_while(move |tick| *tick <= high)
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
