//! The finger in its posture, with the contact, its band of two deviations, and the force.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::Block;
use ratatui::widgets::canvas::{Canvas, Circle, Context, Line};

use super::View;
use crate::posture::{Drawn, Points, Touch};
use crate::state::{Contact, Place, State};

/// Half the thickness of a phalanx, metre, as drawn.
const HALF_THICKNESS_M: f64 = 0.006;
/// Length of the arrow of one newton, metre.
const ARROW_M_PER_N: f64 = 0.015;
/// A terminal's cell is about twice as high as wide.
const CELL_ASPECT: f64 = 2.0;

/// The contact as the mechanics wants it, from the last word on it.
pub(crate) fn touch_of(contact: &Contact) -> Option<Touch> {
    let place = contact.places.first()?;
    Some(Touch {
        theta_a_rad: contact.touch_rad?,
        phalanx: place.phalanx,
        k_m: 1e-3 * place.k_mm,
        radius_m: 1e-3 * contact.radius_mm.unwrap_or(0.0),
    })
}

pub(super) fn draw(
    frame: &mut Frame,
    area: Rect,
    state: &State,
    view: &View,
    finger: &mut (dyn Drawn + '_),
) {
    let theta_a_rad = state
        .samples
        .back()
        .map_or(0.0, |sample| sample.counts * finger.scales().0);
    let contact = state.contact.as_ref();
    let points = finger
        .points(theta_a_rad, contact.and_then(touch_of))
        .or_else(|| finger.points(theta_a_rad, None));
    let reach: f64 = finger.lengths_m().iter().sum();
    let (width, height) = (
        f64::from(area.width.saturating_sub(2).max(1)),
        f64::from(area.height.saturating_sub(2).max(1)) * CELL_ASPECT,
    );
    // The finger's half plane with a margin, enlarged along one axis so that a circle is round.
    let (wanted_x, wanted_y) = (2.1 * reach, 1.3 * reach);
    let scale = (wanted_x / width).max(wanted_y / height);
    let (half_x, size_y) = (0.5 * scale * width, scale * height);
    let colour = |colour| if view.colour { colour } else { Color::Reset };
    let canvas = Canvas::default()
        .block(Block::bordered().title(format!("finger, {:.1}°", theta_a_rad.to_degrees())))
        .marker(Marker::Braille)
        .x_bounds([-half_x, half_x])
        .y_bounds([-0.15 * reach, size_y - 0.15 * reach])
        .paint(|context| {
            let Some(points) = &points else {
                context.print(0.0, 0.0, "no such posture");
                return;
            };
            phalanges(context, points, colour(Color::White));
            let Some(contact) = contact else { return };
            for (rank, place) in contact.places.iter().enumerate() {
                let shade = colour(if rank == 0 {
                    Color::Green
                } else {
                    Color::Yellow
                });
                mark(context, points, place, contact.force_n, shade);
            }
            if let Some((phalanx, k_mm, _)) = state.truth
                && let Some((at, _)) = along(points, phalanx, 1e-3 * k_mm)
            {
                context.print(at[0], at[1], "×");
            }
        });
    frame.render_widget(canvas, area);
}

fn phalanges(context: &mut Context, points: &Points, colour: Color) {
    for pair in points.windows(2) {
        let ([x1, y1], [x2, y2]) = (pair[0], pair[1]);
        let length = (x2 - x1).hypot(y2 - y1).max(f64::MIN_POSITIVE);
        let (nx, ny) = (
            -(y2 - y1) / length * HALF_THICKNESS_M,
            (x2 - x1) / length * HALF_THICKNESS_M,
        );
        for side in [-1.0, 1.0] {
            context.draw(&Line {
                x1: x1 + side * nx,
                y1: y1 + side * ny,
                x2: x2 + side * nx,
                y2: y2 + side * ny,
                color: colour,
            });
        }
        context.draw(&Circle {
            x: x1,
            y: y1,
            radius: HALF_THICKNESS_M,
            color: colour,
        });
    }
    if let Some([x, y]) = points.last() {
        context.draw(&Circle {
            x: *x,
            y: *y,
            radius: HALF_THICKNESS_M,
            color: colour,
        });
    }
}

/// A place on a phalanx and the unit vector to its palm side.
fn along(points: &Points, phalanx: u32, k_m: f64) -> Option<([f64; 2], [f64; 2])> {
    let first = usize::try_from(phalanx).ok()?.checked_sub(1)?;
    let ([x1, y1], [x2, y2]) = (*points.get(first)?, *points.get(first + 1)?);
    let length = (x2 - x1).hypot(y2 - y1);
    let share = (k_m / length).clamp(0.0, 1.0);
    let normal = [-(y2 - y1) / length, (x2 - x1) / length];
    Some(([x1 + share * (x2 - x1), y1 + share * (y2 - y1)], normal))
}

fn mark(
    context: &mut Context,
    points: &Points,
    place: &Place,
    force_n: Option<f64>,
    colour: Color,
) {
    let at = |k_mm: f64| along(points, place.phalanx, 1e-3 * k_mm.max(0.0));
    let (Some((low, normal)), Some((high, _)), Some((middle, _))) = (
        at(place.k_mm - 2.0 * place.sigma_mm),
        at(place.k_mm + 2.0 * place.sigma_mm),
        at(place.k_mm),
    ) else {
        return;
    };
    // The band lies on the palm side's surface.
    let surface = |point: [f64; 2], lift: f64| {
        [
            point[0] + (HALF_THICKNESS_M + lift) * normal[0],
            point[1] + (HALF_THICKNESS_M + lift) * normal[1],
        ]
    };
    let mut line = |from: [f64; 2], to: [f64; 2]| {
        context.draw(&Line {
            x1: from[0],
            y1: from[1],
            x2: to[0],
            y2: to[1],
            color: colour,
        });
    };
    line(surface(low, 0.002), surface(high, 0.002));
    line(surface(low, 0.0), surface(low, 0.004));
    line(surface(high, 0.0), surface(high, 0.004));
    if let Some(force_n) = force_n.filter(|force| *force > 0.0) {
        // The object presses on the phalanx, against its normal.
        let tail = surface(middle, 0.004 + (ARROW_M_PER_N * force_n).min(0.06));
        let head = surface(middle, 0.0);
        line(tail, head);
        let side = [normal[1], -normal[0]];
        for wing in [-1.0, 1.0] {
            let from = [
                head[0] + 0.006 * normal[0] + wing * 0.003 * side[0],
                head[1] + 0.006 * normal[1] + wing * 0.003 * side[1],
            ];
            line(from, head);
        }
    }
}
