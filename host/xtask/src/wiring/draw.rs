//! Wires as SVG: a row each, the ends in boxes, the parts between them as symbols.

use std::fmt::Write as _;

use super::{Part, Sheet, Wire};

const WIDTH: i32 = 1120;
/// The boxes of the left ends end here, those of the right ends begin there.
const LEFT: i32 = 250;
const RIGHT: i32 = 850;
const MARGIN: i32 = 20;
/// Between two wires; a part that hangs below needs more.
const ROW: i32 = 46;
const HANGING_ROW: i32 = 112;

/// The whole drawing.
pub fn svg(sheets: &[Sheet]) -> String {
    let mut body = String::new();
    let mut y = 20;
    for sheet in sheets {
        y += 24;
        text(&mut body, MARGIN, y, "start", "title", &sheet.title);
        y += 34;
        for wire in &sheet.wires {
            row(&mut body, wire, y);
            y += height(wire);
        }
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{y}\" viewBox=\"0 0 {WIDTH} {y}\">\n\
         <style>text {{ font: 14px sans-serif; }} .title {{ font: bold 18px sans-serif; }} \
         path, rect {{ fill: none; stroke: black; stroke-width: 1.6; }} .part {{ fill: white; }} \
         .end {{ fill: #eef4fa; }}</style>\n\
         <rect width=\"{WIDTH}\" height=\"{y}\" style=\"fill: white; stroke: none\"/>\n{body}</svg>\n"
    )
}

fn height(wire: &Wire) -> i32 {
    if wire.parts.iter().any(|part| part.to.is_some()) {
        HANGING_ROW
    } else {
        ROW
    }
}

/// Writing to a string cannot fail.
fn line(body: &mut String, element: std::fmt::Arguments<'_>) {
    let _ = writeln!(body, "{element}");
}

fn text(body: &mut String, x: i32, y: i32, anchor: &str, class: &str, words: &str) {
    let words = words
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    line(
        body,
        format_args!(
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" class=\"{class}\">{words}</text>"
        ),
    );
}

fn end(body: &mut String, x: i32, y: i32, width: i32, words: &str) {
    line(
        body,
        format_args!(
            "<rect class=\"end\" x=\"{x}\" y=\"{}\" width=\"{width}\" height=\"28\" rx=\"4\"/>",
            y - 14
        ),
    );
    text(body, x + width / 2, y + 5, "middle", "", words);
}

fn row(body: &mut String, wire: &Wire, y: i32) {
    line(body, format_args!("<path d=\"M{LEFT} {y}H{RIGHT}\"/>"));
    end(body, MARGIN, y, LEFT - MARGIN, &wire.ends[0]);
    end(body, RIGHT, y, WIDTH - MARGIN - RIGHT, &wire.ends[1]);
    let count = i32::try_from(wire.parts.len()).unwrap_or(0);
    for (n, part) in (1..).zip(&wire.parts) {
        let x = LEFT + (RIGHT - LEFT) * n / (count + 1);
        match &part.to {
            None => series(body, part, x, y),
            Some(net) => hanging(body, part, net, x, y),
        }
    }
}

/// In the wire: a capacitor as two plates, anything else as a box.
fn series(body: &mut String, part: &Part, x: i32, y: i32) {
    if part.name.starts_with('C') {
        line(
            body,
            format_args!(
                "<rect class=\"part\" x=\"{}\" y=\"{}\" width=\"8\" height=\"4\" style=\"stroke: white\"/>\
                 <path d=\"M{0} {2}v18M{3} {2}v18\"/>",
                x - 4,
                y - 2,
                y - 9,
                x + 4
            ),
        );
    } else {
        line(
            body,
            format_args!(
                "<rect class=\"part\" x=\"{}\" y=\"{}\" width=\"44\" height=\"16\"/>",
                x - 22,
                y - 8
            ),
        );
    }
    let words = format!("{} {}", part.name, part.value);
    text(body, x, y - 13, "middle", "", &words);
}

/// From the wire down to a net.
fn hanging(body: &mut String, part: &Part, net: &str, x: i32, y: i32) {
    line(
        body,
        format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"4\" height=\"4\" style=\"fill: black\"/><path d=\"M{x} {y}v18\"/>",
            x - 2,
            y - 2
        ),
    );
    if part.name.starts_with('C') {
        line(
            body,
            format_args!(
                "<path d=\"M{x} {y}v28M{0} {1}h20M{0} {2}h20M{x} {2}v20\"/>",
                x - 10,
                y + 28,
                y + 34
            ),
        );
    } else {
        line(
            body,
            format_args!(
                "<rect class=\"part\" x=\"{}\" y=\"{}\" width=\"16\" height=\"32\"/><path d=\"M{x} {}v8\"/>",
                x - 8,
                y + 16,
                y + 48
            ),
        );
    }
    line(
        body,
        format_args!(
            "<path d=\"M{} {}h20M{} {}h12\"/>",
            x - 10,
            y + 56,
            x - 6,
            y + 60
        ),
    );
    text(
        body,
        x + 16,
        y + 36,
        "start",
        "",
        &format!("{} {}", part.name, part.value),
    );
    text(body, x, y + 77, "middle", "", net);
}
