//! The screen: which part stands where, and what is written into the plain ones.

mod finger;
mod plots;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};

use crate::command_line::CommandLine;
use crate::figure::Role;
use crate::posture::FingerView;
use crate::state::State;
use crate::stream::Level;

/// What of the screen is chosen by keys.
#[derive(Clone, Debug)]
pub struct View {
    /// Least level of the log shown.
    pub level: Level,
    /// Text that a shown log line contains.
    pub filter: String,
    /// Log lines scrolled back from the newest.
    pub back: usize,
    /// Colours may be used.
    pub colour: bool,
    /// The help is shown.
    pub help: bool,
    /// A recording is being written to this file.
    pub recording: Option<String>,
    /// What the keys go to.
    pub focus: Focus,
}

/// What the keys go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Focus {
    /// Single letters are actions.
    Keys,
    /// Letters are written to the command line.
    Command,
    /// Letters are written to the log's filter.
    Filter,
}

impl View {
    /// A style that is plain where there is no colour.
    fn paint(&self, colour: Color) -> Style {
        if self.colour {
            Style::new().fg(colour)
        } else {
            Style::new()
        }
    }

    /// The colour of what is drawn, or the terminal's own.
    fn colour_of(&self, role: Role) -> Color {
        if !self.colour {
            return Color::Reset;
        }
        match role {
            Role::Measured => Color::White,
            Role::Estimate => Color::Green,
            Role::Alternative | Role::Threshold => Color::Yellow,
            Role::Truth => Color::Magenta,
            Role::Friction => Color::Blue,
        }
    }
}

const HELP: &str = "r run   s stop   o open   c clear   f record friction   k calibrate cable   t status\n\
                    w record to a file   : command line (Tab completes, arrows recall)   / filter the log\n\
                    l level of the log   PgUp PgDn scroll the log   ? this help   q quit";

/// Draws everything. At 80 by 24 every part is still there.
pub fn draw(
    frame: &mut Frame,
    state: &State,
    view: &View,
    command: &CommandLine,
    finger: Option<&mut (dyn FingerView + 'static)>,
) {
    let [head, body, log, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Fill(3),
        Constraint::Fill(2),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let [left, right] =
        Layout::horizontal([Constraint::Percentage(45), Constraint::Fill(1)]).areas(body);
    let [curve, lower] = Layout::vertical([Constraint::Fill(3), Constraint::Fill(2)]).areas(right);
    let [posterior, numbers] =
        Layout::horizontal([Constraint::Fill(1), Constraint::Length(26)]).areas(lower);
    header(frame, head, state, view);
    match finger {
        Some(finger) => {
            plots::curve(frame, curve, state, view, finger);
            plots::posterior(frame, posterior, state, view, finger);
            finger::draw(frame, left, state, view, finger);
        }
        None => {
            let text = "waiting for the boot line, which names the scene (or pass --scene)";
            frame.render_widget(
                Paragraph::new(text)
                    .wrap(ratatui::widgets::Wrap { trim: true })
                    .block(Block::bordered().title("finger")),
                left,
            );
        }
    }
    values(frame, numbers, state, view);
    if view.help {
        let text = Paragraph::new(HELP).block(Block::bordered().title("keys"));
        frame.render_widget(text, log);
    } else {
        events(frame, log, state, view);
    }
    footer(frame, foot, view, command);
}

fn header(frame: &mut Frame, area: Rect, state: &State, view: &View) {
    let mut spans = vec![
        Span::from(" palpate ").add_modifier(Modifier::REVERSED),
        Span::from(format!(" {} ", state.scene.as_deref().unwrap_or("-"))),
        Span::styled(
            format!(
                " {} ",
                if state.sequence.is_empty() {
                    "-"
                } else {
                    &state.sequence
                }
            ),
            view.paint(Color::Cyan),
        ),
        Span::from(format!(" {:9.3} s ", state.time_s)),
    ];
    if let Some(fault) = &state.fault {
        let style = view.paint(Color::Red).add_modifier(Modifier::BOLD);
        spans.push(Span::styled(format!(" FAULT {fault} (c clears) "), style));
    }
    if let Some(file) = &view.recording {
        spans.push(Span::styled(
            format!(" recording to {file} "),
            view.paint(Color::Yellow),
        ));
    }
    if state.ended {
        spans.push(Span::from(" source ended "));
    }
    frame.render_widget(Line::from(spans), area);
}

/// A number with its unit, or a dash.
fn shown(value: Option<f64>, digits: usize, unit: &str) -> String {
    value.map_or_else(|| format!("- {unit}"), |v| format!("{v:.digits$} {unit}"))
}

fn values(frame: &mut Frame, area: Rect, state: &State, view: &View) {
    let last = state.samples.back();
    let contact = state.contact.as_ref();
    let place = contact.and_then(|contact| contact.places.first());
    let judged = match (contact, place) {
        (None, _) => "no contact".to_owned(),
        (Some(_), Some(place)) => format!(
            "phalanx {} {:.1} ± {:.1} mm",
            place.phalanx, place.k_mm, place.sigma_mm
        ),
        (Some(contact), None) => contact.why.clone().unwrap_or_else(|| "touch".to_owned()),
    };
    let mut lines = vec![
        Line::styled(
            judged,
            view.paint(Color::Green).add_modifier(Modifier::BOLD),
        ),
        Line::from(format!(
            "force    {}",
            shown(contact.and_then(|c| c.force_n), 2, "N")
        )),
        Line::from(format!(
            "radius   {}",
            shown(contact.and_then(|c| c.radius_mm), 1, "mm")
        )),
        Line::from(format!(
            "current  {}",
            shown(last.map(|s| 1e3 * s.current_a), 1, "mA")
        )),
        Line::from(match last.and_then(|sample| sample.evidence) {
            Some((evidence, threshold)) => format!("evidence {evidence:.1} of {threshold:.1}"),
            None => "evidence -".to_owned(),
        }),
        Line::from(format!("supply   {}", shown(state.supply_v, 2, "V"))),
        Line::from(format!("winding  {}", shown(state.winding_c, 1, "°C"))),
    ];
    if let Some((phalanx, k_mm, _)) = state.truth {
        lines.insert(
            1,
            Line::from(format!("true     phalanx {phalanx} {k_mm:.1} mm")),
        );
    }
    if let Some(stiffness) = contact.and_then(|contact| contact.object.as_ref()) {
        lines.push(Line::from(format!("object   {stiffness}")));
    }
    if let Some((factor, sigma)) = state.torque_factor {
        lines.push(Line::from(format!("factor   {factor:.3} ± {sigma:.3}")));
    }
    if state.dropped > 0 {
        lines.push(Line::styled(
            format!("{} log records lost", state.dropped),
            view.paint(Color::Yellow),
        ));
    }
    frame.render_widget(
        Paragraph::new(lines).block(Block::bordered().title("contact")),
        area,
    );
}

fn events(frame: &mut Frame, area: Rect, state: &State, view: &View) {
    let rows = usize::from(area.height.saturating_sub(2));
    let mut lines: Vec<Line> = state
        .log
        .iter()
        .rev()
        .filter(|line| line.level >= view.level && line.text.contains(&view.filter))
        .skip(view.back)
        .take(rows)
        .map(|line| {
            let style = match line.level {
                Level::Error => view.paint(Color::Red),
                Level::Warn => view.paint(Color::Yellow),
                Level::Info => Style::new(),
                Level::Debug => view.paint(Color::DarkGray),
            };
            let time = line
                .time_s
                .map_or_else(|| " ".repeat(10), |time_s| format!("{time_s:10.3}"));
            Line::styled(format!("{time} {} {}", line.level.name(), line.text), style)
        })
        .collect();
    lines.reverse();
    let mut title = format!("log, from {}", view.level.name().trim());
    if !view.filter.is_empty() || view.focus == Focus::Filter {
        title.push_str(&format!(", with '{}'", view.filter));
    }
    if view.back > 0 {
        title.push_str(&format!(", {} back", view.back));
    }
    frame.render_widget(
        Paragraph::new(lines).block(Block::bordered().title(title)),
        area,
    );
}

fn footer(frame: &mut Frame, area: Rect, view: &View, command: &CommandLine) {
    match view.focus {
        Focus::Keys => frame.render_widget(
            Line::from(" ? help  : command  r run  s stop  w record  q quit"),
            area,
        ),
        Focus::Filter => frame.render_widget(Line::from(format!("/{}", view.filter)), area),
        Focus::Command => {
            let offered: Vec<&str> = command.candidates().take(6).map(str::trim).collect();
            let line = Line::from(vec![
                Span::from(format!(":{}", command.text())),
                Span::styled(
                    format!("   {}", offered.join("  ")),
                    view.paint(Color::DarkGray),
                ),
            ]);
            frame.render_widget(line, area);
            let column = u16::try_from(command.cursor()).unwrap_or(u16::MAX);
            frame.set_cursor_position((area.x.saturating_add(1).saturating_add(column), area.y));
        }
    }
}
