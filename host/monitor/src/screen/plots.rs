//! Torque against angle, and where the contact is believed to be.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::symbols::Marker;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, LegendPosition, Paragraph, Wrap};

use super::View;
use crate::figure::{self, Series, range};
use crate::posture::FingerView;
use crate::state::State;

/// Points drawn of a series at most; more would not be told apart.
const DRAWN: usize = 600;

/// Torque against angle.
pub(super) fn curve(
    frame: &mut Frame,
    area: Rect,
    state: &State,
    view: &View,
    finger: &(dyn FingerView + 'static),
) {
    let series = thinned(figure::torque(state, finger));
    let all = || series.iter().flat_map(|series| series.points.iter());
    let (low, high) = range(all().map(|point| point.0), (0.0, 90.0));
    let (_, most) = range(all().map(|point| point.1), (0.0, 100.0));
    let chart = Chart::new(datasets(&series, view))
        .block(Block::bordered().title(figure::TORQUE_AXES))
        .x_axis(axis(low, high))
        .y_axis(axis(0.0, 1.1 * most.max(1.0)))
        .legend_position(Some(LegendPosition::TopLeft));
    frame.render_widget(chart, area);
}

/// Belief in the contact location.
pub(super) fn posterior(
    frame: &mut Frame,
    area: Rect,
    state: &State,
    view: &View,
    finger: &(dyn FingerView + 'static),
) {
    let Some(belief) = figure::belief(state, finger) else {
        let text = Paragraph::new("no contact located yet")
            .wrap(Wrap { trim: true })
            .block(Block::bordered().title("where"));
        frame.render_widget(text, area);
        return;
    };
    let most = belief
        .series
        .iter()
        .flat_map(|series| series.points.iter().map(|point| point.1))
        .fold(1e-6, f64::max);
    let (low, high) = belief.range_mm;
    let chart = Chart::new(datasets(&belief.series, view))
        .block(Block::bordered().title(belief.axis.as_str()))
        .x_axis(axis(low, high))
        .y_axis(Axis::default().bounds([0.0, 1.1 * most]))
        .legend_position(None);
    frame.render_widget(chart, area);
}

fn thinned(mut series: Vec<Series>) -> Vec<Series> {
    for series in &mut series {
        let step = series.points.len().div_ceil(DRAWN).max(1);
        series.points = series.points.iter().copied().step_by(step).collect();
    }
    series
}

fn datasets<'a>(series: &'a [Series], view: &View) -> Vec<Dataset<'a>> {
    series
        .iter()
        .filter(|series| !series.points.is_empty())
        .map(|series| {
            let set = Dataset::default()
                .name(series.name)
                .style(view.paint(view.colour_of(series.role)))
                .data(&series.points);
            if series.joined {
                set.marker(Marker::Braille).graph_type(GraphType::Line)
            } else {
                set.marker(Marker::Dot)
            }
        })
        .collect()
}

fn axis<'a>(low: f64, high: f64) -> Axis<'a> {
    Axis::default().bounds([low, high]).labels([
        format!("{low:.0}"),
        format!("{:.0}", 0.5 * (low + high)),
        format!("{high:.0}"),
    ])
}
