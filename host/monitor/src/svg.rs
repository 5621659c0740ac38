//! A screen of the monitor as an SVG picture, for documents: what a terminal would show, cell by cell.

use std::fmt::Write;

use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};

/// Size of a cell and room around the screen, pixels.
const WIDTH: u16 = 8;
const HEIGHT: u16 = 17;
const MARGIN: u16 = 8;
/// Where letters stand in a cell, from its top.
const BASELINE: u16 = 13;
const INK: &str = "#d0d0d0";
const PAPER: &str = "#16181c";
/// The first of the 256 Braille patterns.
const BRAILLE: u32 = 0x2800;

/// Draws a screen.
#[must_use]
pub fn of(screen: &Buffer) -> String {
    let area = screen.area;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"monospace\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n",
        area.width * WIDTH + 2 * MARGIN,
        area.height * HEIGHT + 2 * MARGIN
    );
    for row in 0..area.height {
        let cells: Vec<&Cell> = (0..area.width)
            .filter_map(|column| screen.cell((area.x + column, area.y + row)))
            .collect();
        let mut column = 0;
        while column < cells.len() {
            // Neighbours that look the same are one piece of text.
            let end = (column..cells.len())
                .find(|&at| look(cells[at]) != look(cells[column]))
                .unwrap_or(cells.len());
            piece(&mut svg, &cells[column..end], column, row);
            column = end;
        }
    }
    svg.push_str("</svg>\n");
    svg
}

/// What two cells of one piece share: colours, and whether they are dots, text or blank.
fn look(cell: &Cell) -> (Color, Color, Modifier, Kind) {
    (cell.fg, cell.bg, cell.modifier, Kind::of(cell))
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Blank,
    Dots,
    Text,
}

impl Kind {
    fn of(cell: &Cell) -> Self {
        match cell.symbol().chars().next() {
            None | Some(' ') => Self::Blank,
            Some(letter) if pattern(letter).is_some() => Self::Dots,
            Some(_) => Self::Text,
        }
    }
}

/// The dots of a Braille letter as bits.
fn pattern(letter: char) -> Option<u32> {
    u32::from(letter)
        .checked_sub(BRAILLE)
        .filter(|&bits| bits < 256)
}

fn piece(svg: &mut String, cells: &[&Cell], column: usize, row: u16) {
    let Some(first) = cells.first() else { return };
    let reversed = first.modifier.contains(Modifier::REVERSED);
    let fill = if reversed { PAPER } else { colour(first.fg) };
    let left = MARGIN + WIDTH * column as u16;
    let top = MARGIN + HEIGHT * row;
    let width = WIDTH * cells.len() as u16;
    // Writing to a String cannot fail.
    if reversed {
        let _ = writeln!(
            svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{HEIGHT}\" fill=\"{INK}\"/>"
        );
    }
    match Kind::of(first) {
        Kind::Blank => {}
        Kind::Text => {
            let text: String = cells.iter().map(|cell| cell.symbol()).collect();
            let text = text.replace('&', "&amp;").replace('<', "&lt;");
            let bold = if first.modifier.contains(Modifier::BOLD) {
                " font-weight=\"bold\""
            } else {
                ""
            };
            let baseline = top + BASELINE;
            let _ = writeln!(
                svg,
                "<text x=\"{left}\" y=\"{baseline}\" textLength=\"{width}\" fill=\"{fill}\"{bold}>{text}</text>"
            );
        }
        Kind::Dots => {
            for (index, cell) in cells.iter().enumerate() {
                let bits = cell.symbol().chars().next().and_then(pattern);
                dots(
                    svg,
                    bits.unwrap_or(0),
                    left + WIDTH * index as u16,
                    top,
                    fill,
                );
            }
        }
    }
}

/// Two columns of four dots; the lowest row has the highest bits.
fn dots(svg: &mut String, bits: u32, left: u16, top: u16, fill: &str) {
    const ROWS: [[u32; 2]; 4] = [[0, 3], [1, 4], [2, 5], [6, 7]];
    for (row, columns) in (0_u16..).zip(ROWS) {
        for (column, bit) in (0_u16..).zip(columns) {
            if bits >> bit & 1 == 1 {
                let (x, y) = (left + 2 + 4 * column, top + 2 + 4 * row);
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{x}\" cy=\"{y}\" r=\"1.6\" fill=\"{fill}\"/>"
                );
            }
        }
    }
}

/// A terminal's colours on dark ground.
fn colour(colour: Color) -> &'static str {
    match colour {
        Color::Red => "#e06c75",
        Color::Green => "#98c379",
        Color::Yellow => "#e5c07b",
        Color::Blue => "#61afef",
        Color::Magenta => "#c678dd",
        Color::Cyan => "#56b6c2",
        Color::White => "#fff",
        Color::DarkGray => "#7f848e",
        _ => INK,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;
    use ratatui::style::Style;

    #[test]
    fn cells_of_one_look_are_one_text_and_braille_is_dots() {
        let mut screen = Buffer::empty(Rect::new(0, 0, 6, 1));
        screen.set_string(0, 0, "a<b", Style::new().fg(Color::Green));
        screen.set_string(4, 0, "\u{2801}\u{2880}", Style::new());
        let svg = of(&screen);
        assert!(
            svg.contains("textLength=\"24\" fill=\"#98c379\">a&lt;b</text>"),
            "{svg}"
        );
        // Upper left dot of one cell, lower right dot of the next.
        assert!(svg.contains("<circle cx=\"42\" cy=\"10\""), "{svg}");
        assert!(svg.contains("<circle cx=\"54\" cy=\"22\""), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 2);
    }
}
