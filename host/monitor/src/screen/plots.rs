//! Torque against angle, and where the contact is believed to be.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType};

use super::View;
use super::finger::touch_of;
use crate::posture::Drawn;
use crate::state::State;

/// Samples drawn at most; more would not be told apart.
const DRAWN: usize = 600;
/// Points of the posterior's curve.
const POINTS: u8 = 100;

/// Motor torque at the input link (nominal) against angle, with the recorded friction, the threshold of the contact test,
/// and the curve that the estimate predicts.
pub(super) fn curve(
    frame: &mut Frame,
    area: Rect,
    state: &State,
    view: &View,
    finger: &mut (dyn Drawn + '_),
) {
    let (rad_per_count, nm_per_a) = finger.scales();
    let step = (state.samples.len() / DRAWN).max(1);
    let measured: Vec<(f64, f64)> = state
        .samples
        .iter()
        .step_by(step)
        .filter(|sample| sample.duty > 0.0)
        .map(|sample| {
            (
                (sample.counts * rad_per_count).to_degrees(),
                1e3 * nm_per_a * sample.current_a,
            )
        })
        .collect();
    let (low, high) = range(measured.iter().map(|point| point.0), (0.0, 90.0));
    let (_, most) = range(measured.iter().map(|point| point.1), (0.0, 100.0));
    let level = |torque_nm: f64| vec![(low, 1e3 * torque_nm), (high, 1e3 * torque_nm)];
    let friction = state.friction_nm.map(level).unwrap_or_default();
    let threshold = state
        .friction_nm
        .zip(state.samples.back().and_then(|sample| sample.threshold_nm))
        .map(|(friction, threshold)| level(friction + threshold))
        .unwrap_or_default();
    let predicted: Vec<(f64, f64)> = state
        .contact
        .as_ref()
        .and_then(touch_of)
        .map(|touch| finger.curve(touch, 0.2))
        .unwrap_or_default()
        .into_iter()
        .map(|(theta_a_rad, torque_nm)| {
            // What the motor has to give beyond friction; the calibration scales the gears' nominal efficiency.
            let factor = state.torque_factor.map_or(1.0, |factor| factor.0);
            let motor_nm = torque_nm / (NOMINAL_EFFICIENCY * factor);
            (
                theta_a_rad.to_degrees(),
                1e3 * (state.friction_nm.unwrap_or_default() + motor_nm),
            )
        })
        .collect();
    let paint = |colour| view.paint(colour);
    let line = |name, data, colour| {
        Dataset::default()
            .name(name)
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(paint(colour))
            .data(data)
    };
    let datasets = vec![
        Dataset::default()
            .name("motor")
            .marker(Marker::Dot)
            .style(paint(Color::Gray))
            .data(&measured),
        line("friction", &friction, Color::Blue),
        line("threshold", &threshold, Color::Yellow),
        line("estimate", &predicted, Color::Green),
    ];
    let chart = Chart::new(datasets)
        .block(
            Block::bordered()
                .title("motor torque at the input link (nominal), mN m, against angle, deg"),
        )
        .x_axis(axis(low, high))
        .y_axis(axis(0.0, 1.1 * most.max(1.0)))
        .legend_position(Some(ratatui::widgets::LegendPosition::TopLeft));
    frame.render_widget(chart, area);
}

/// Nominal efficiency of the gears, for the drawn prediction alone.
const NOMINAL_EFFICIENCY: f64 = 0.33;

/// Belief over the finger's length, as the reported places and deviations give it: a normal density for each.
pub(super) fn posterior(
    frame: &mut Frame,
    area: Rect,
    state: &State,
    view: &View,
    finger: &mut (dyn Drawn + '_),
) {
    let lengths_mm: Vec<f64> = finger
        .lengths_m()
        .iter()
        .map(|length| 1e3 * length)
        .collect();
    let total: f64 = lengths_mm.iter().sum();
    let base = |phalanx: u32| -> f64 {
        lengths_mm
            .iter()
            .take(phalanx.saturating_sub(1) as usize)
            .sum()
    };
    let places = state
        .contact
        .as_ref()
        .map_or(&[][..], |contact| contact.places.as_slice());
    let density = |at: f64| -> f64 {
        places
            .iter()
            .map(|place| {
                let sigma = place.sigma_mm.max(0.1);
                let z = (at - base(place.phalanx) - place.k_mm) / sigma;
                place.weight * (-0.5 * z * z).exp() / sigma
            })
            .sum()
    };
    // Around the likeliest place, where a density over the whole finger would be a needle.
    let (low, high) = match places.first() {
        Some(place) => {
            let centre = base(place.phalanx) + place.k_mm;
            let half = (5.0 * place.sigma_mm).max(5.0);
            let far = places
                .iter()
                .map(|other| {
                    (base(other.phalanx) + other.k_mm - centre).abs() + 4.0 * other.sigma_mm
                })
                .fold(half, f64::max);
            ((centre - far).max(0.0), (centre + far).min(total))
        }
        None => (0.0, total),
    };
    let points: Vec<(f64, f64)> = (0..=POINTS)
        .map(|n| low + (high - low) * f64::from(n) / f64::from(POINTS))
        .map(|at| (at, density(at)))
        .collect();
    let most = points.iter().map(|point| point.1).fold(1e-6, f64::max);
    let truth: Vec<(f64, f64)> = state
        .truth
        .map(|(phalanx, k_mm, _)| base(phalanx) + k_mm)
        .map(|at| vec![(at, 0.0), (at, most)])
        .unwrap_or_default();
    let joints: Vec<(f64, f64)> = (1..=lengths_mm.len() as u32)
        .map(|phalanx| (base(phalanx), 0.0))
        .collect();
    let datasets = vec![
        Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(view.paint(Color::Green))
            .data(&points),
        Dataset::default()
            .marker(Marker::Dot)
            .graph_type(GraphType::Line)
            .style(view.paint(Color::Magenta))
            .data(&truth),
        Dataset::default().marker(Marker::Block).data(&joints),
    ];
    let chart = Chart::new(datasets)
        .block(Block::bordered().title("where, mm from the first joint"))
        .x_axis(axis(low, high))
        .y_axis(Axis::default().bounds([0.0, 1.1 * most]))
        .legend_position(None);
    frame.render_widget(chart, area);
}

fn axis<'a>(low: f64, high: f64) -> Axis<'a> {
    Axis::default().bounds([low, high]).labels([
        format!("{low:.0}"),
        format!("{:.0}", 0.5 * (low + high)),
        format!("{high:.0}"),
    ])
}

/// Least and largest of some values, or what is given where there are none or they do not differ.
fn range(values: impl Iterator<Item = f64>, otherwise: (f64, f64)) -> (f64, f64) {
    let found = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if found.0 < found.1 { found } else { otherwise }
}
