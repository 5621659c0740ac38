//! The finger in its posture, with the contact, its band of two deviations, and the force.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::Block;
use ratatui::widgets::canvas::{Canvas, Circle, Line};

use super::View;
use crate::figure;
use crate::posture::FingerView;
use crate::state::State;

/// A terminal's cell is about twice as high as wide.
const CELL_ASPECT: f64 = 2.0;

pub(super) fn draw(
    frame: &mut Frame,
    area: Rect,
    state: &State,
    view: &View,
    finger: &mut (dyn FingerView + 'static),
) {
    let theta_a_rad = state
        .samples
        .back()
        .map_or(0.0, |sample| sample.counts * finger.scales().rad_per_count);
    let picture =
        figure::points_at(state, finger, theta_a_rad).map(|points| figure::posture(&points, state));
    let reach: f64 = finger.lengths_m().iter().sum();
    let (width, height) = (
        f64::from(area.width.saturating_sub(2).max(1)),
        f64::from(area.height.saturating_sub(2).max(1)) * CELL_ASPECT,
    );
    // The finger's half plane with a margin, enlarged along one axis so that a circle is round.
    let (wanted_x, wanted_y) = (2.1 * reach, 1.3 * reach);
    let scale = (wanted_x / width).max(wanted_y / height);
    let (half_x, size_y) = (0.5 * scale * width, scale * height);
    let canvas = Canvas::default()
        .block(Block::bordered().title(format!("finger, {:.1}°", theta_a_rad.to_degrees())))
        .marker(Marker::Braille)
        .x_bounds([-half_x, half_x])
        .y_bounds([-0.15 * reach, size_y - 0.15 * reach])
        .paint(|context| {
            let Some(picture) = &picture else {
                context.print(0.0, 0.0, "no such posture");
                return;
            };
            for stroke in &picture.strokes {
                context.draw(&Line {
                    x1: stroke.from[0],
                    y1: stroke.from[1],
                    x2: stroke.to[0],
                    y2: stroke.to[1],
                    color: view.colour_of(stroke.role),
                });
            }
            for &([x, y], radius) in &picture.circles {
                context.draw(&Circle {
                    x,
                    y,
                    radius,
                    color: if view.colour {
                        Color::White
                    } else {
                        Color::Reset
                    },
                });
            }
            if let Some([x, y]) = picture.truth {
                context.print(x, y, "×");
            }
        });
    frame.render_widget(canvas, area);
}
