//! A grasp as one page that a person can send: no network, readable on paper and in the dark.

mod drawing;

use std::fmt::Write;

use crate::figure;
use crate::posture::FingerView;
use crate::state::State;
use crate::stream::{Event, Level, Message};
use drawing::{plot, posture};

/// What a page tells, gathered from a stream.
#[derive(Debug, Default)]
pub struct GraspPage {
    state: State,
    events: Vec<Event>,
    /// Answers to `show`: a setting a line.
    settings: Vec<String>,
    summary: Option<serde_json::Map<String, serde_json::Value>>,
}

impl GraspPage {
    /// Takes a message of the stream.
    pub fn take(&mut self, message: Message) {
        match &message {
            Message::Event(event) if event.name.starts_with("answer") => {
                let text = event.text();
                let answer = text.trim_start_matches("answer").trim();
                if answer != "ok" && !answer.starts_with("kept") {
                    self.settings.push(answer.to_owned());
                }
            }
            Message::Event(event) => self.events.push(event.clone()),
            Message::Note(text) => {
                if let Ok(serde_json::Value::Object(object)) = serde_json::from_str(text)
                    && object.get("type").and_then(|kind| kind.as_str()) == Some("summary")
                {
                    self.summary = Some(object);
                }
            }
            Message::Sample(_) | Message::Truth { .. } => {}
        }
        self.state.take(message);
    }

    /// Scene that the firmware named.
    #[must_use]
    pub fn scene(&self) -> Option<&str> {
        self.state.scene.as_deref()
    }

    /// The page, as HTML.
    #[must_use]
    pub fn html(&self, title: &str, mut finger: Option<Box<dyn FingerView>>) -> String {
        // A browser that obeys the policy fetches nothing: what is to be seen is in the page.
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
             <title>{0}</title>\n<style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n",
            escape(title)
        );
        // Writing to a String cannot fail.
        let _ = write!(
            page,
            "<p class=\"verdict\">{}</p>\n{}",
            self.verdict(),
            self.truth()
        );
        if let Some(finger) = finger.as_deref_mut() {
            page.push_str("<div class=\"figures\">\n");
            for (caption, svg) in self.figures(finger) {
                let _ = writeln!(
                    page,
                    "<figure>{svg}<figcaption>{}</figcaption></figure>",
                    escape(&caption)
                );
            }
            page.push_str("</div>\n");
        }
        page.push_str(&self.calibration());
        page.push_str(&self.table());
        if !self.settings.is_empty() {
            page.push_str("<h2>Settings</h2>\n<pre>");
            for line in &self.settings {
                let _ = writeln!(page, "{}", escape(line));
            }
            page.push_str("</pre>\n");
        }
        page.push_str("</body></html>\n");
        page
    }

    fn verdict(&self) -> String {
        let Some(contact) = &self.state.contact else {
            return match &self.state.fault {
                Some(fault) => format!("Fault: {}. The bridge is off.", escape(fault)),
                None => "No contact was felt.".to_owned(),
            };
        };
        let force = contact
            .force_n
            .map_or(String::new(), |force| format!(", force {force:.2} N"));
        let radius = contact
            .radius_mm
            .filter(|radius| radius.is_finite())
            .map_or(String::new(), |radius| {
                format!(", effective contact radius {radius:.1} mm")
            });
        let object = contact
            .object
            .as_ref()
            .map_or(String::new(), |stiffness| format!(", object {stiffness}"));
        match contact.places.as_slice() {
            [] => format!(
                "A contact was felt and not located: {}.",
                escape(contact.why.as_deref().unwrap_or("no word on it"))
            ),
            [place] => format!(
                "Contact on phalanx {}, <b>{:.1} ± {:.1} mm</b> from its joint{force}{radius}{object}.",
                place.phalanx, place.k_mm, place.sigma_mm
            ),
            [first, second, ..] => format!(
                "Two places explain the contact: phalanx {}, {:.1} ± {:.1} mm, or phalanx {}, {:.1} ± {:.1} mm{force}.",
                first.phalanx,
                first.k_mm,
                first.sigma_mm,
                second.phalanx,
                second.k_mm,
                second.sigma_mm
            ),
        }
    }

    fn truth(&self) -> String {
        let number = |key: &str| self.summary.as_ref()?.get(key)?.as_f64();
        let summed_up = number("true_phalanx").zip(number("true_k_mm"));
        let streamed = self
            .state
            .truth
            .map(|(phalanx, k_mm, _)| (f64::from(phalanx), k_mm));
        let Some((phalanx, k_mm)) = summed_up.or(streamed) else {
            return match self.summary {
                Some(_) => "<p>Simulated: nothing touched the finger.</p>\n".to_owned(),
                None => String::new(),
            };
        };
        let places = self
            .state
            .contact
            .iter()
            .flat_map(|contact| &contact.places);
        let error = places
            .filter(|place| f64::from(place.phalanx) == phalanx)
            .map(|place| place.k_mm - k_mm)
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))
            .map_or(String::new(), |off_mm| {
                format!(" The estimate is {off_mm:+.2} mm off.")
            });
        format!("<p>The truth is phalanx {phalanx:.0}, {k_mm:.2} mm.{error}</p>\n")
    }

    fn figures(&self, finger: &mut (dyn FingerView + 'static)) -> Vec<(String, String)> {
        let rad_per_count = finger.scales().rad_per_count;
        let touch = figure::touch_of(&self.state, finger);
        let last_rad = self
            .state
            .samples
            .iter()
            .rev()
            .find(|sample| sample.duty > 0.0)
            .map_or(0.0, |sample| sample.counts * rad_per_count);
        let at_rad = touch.map_or(last_rad, |touch| last_rad.max(touch.theta_a_rad));
        let mut figures = Vec::new();
        if let Some(points) = figure::points_at(&self.state, finger, at_rad) {
            let caption = format!(
                "The finger with its input link at {:.1}°: the band reaches two deviations to either side, the arrow the force{}",
                at_rad.to_degrees(),
                if self.state.truth.is_some() {
                    ", × the truth"
                } else {
                    ""
                }
            );
            figures.push((caption, posture(&figure::posture(&points, &self.state))));
        }
        let torque = figure::torque(&self.state, finger);
        if torque.iter().any(|series| !series.points.is_empty()) {
            let caption = format!(
                "{}: at the input link, as the nominal gears would bring it there",
                capital(figure::TORQUE_AXES)
            );
            figures.push((caption, plot(&torque)));
        }
        let evidence = figure::evidence(&self.state, finger);
        if evidence.iter().any(|series| !series.points.is_empty()) {
            figures.push((capital(figure::EVIDENCE_AXES), plot(&evidence)));
        }
        if let Some(belief) = figure::belief(&self.state, finger) {
            let caption = format!(
                "Belief in the contact location, {}: a normal density with the mean and deviation of each place",
                belief.axis
            );
            figures.push((caption, plot(&belief.series)));
        }
        figures
    }

    fn calibration(&self) -> String {
        let Some((factor, sigma)) = self.state.torque_factor else {
            // A record from before may hold one, which the log does not tell.
            let loaded =
                |event: &Event| event.name == "record" && event.field("state") == Some("loaded");
            return if self.events.iter().any(loaded) {
                String::new()
            } else {
                "<p>Not calibrated: the scene's torque factor and cable are assumed.</p>\n"
                    .to_owned()
            };
        };
        let cable = self.state.cable_rad_per_nm.filter(|cable| *cable > 0.0);
        let cable = cable.map_or_else(String::new, |rad_per_nm| {
            format!(", cable {:.1} mrad/(N m)", 1e3 * rad_per_nm)
        });
        format!("<p>Calibrated: torque factor {factor:.3} ± {sigma:.3}{cable}.</p>\n")
    }

    fn table(&self) -> String {
        let mut table = "<h2>Events</h2>\n<table><thead><tr><th>time, s</th><th>level</th><th>event</th><th>values</th></tr></thead><tbody>\n".to_owned();
        for event in &self.events {
            let time = event
                .time_s
                .map_or(String::new(), |time_s| format!("{time_s:.3}"));
            let class = match event.level {
                Level::Warn => " class=\"warn\"",
                Level::Error => " class=\"error\"",
                Level::Debug | Level::Info => "",
            };
            let values: Vec<String> = event
                .fields
                .iter()
                .map(|(key, value)| {
                    format!("{}&nbsp;=&nbsp;{}", escape(key), escape(&short(value)))
                })
                .collect();
            let _ = writeln!(
                table,
                "<tr{class}><td>{time}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                event.level.name().trim().to_lowercase(),
                escape(&event.name),
                values.join(", ")
            );
        }
        table.push_str("</tbody></table>\n");
        table
    }
}

/// A number with the digits that a person reads; anything else as it is.
fn short(value: &str) -> String {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() && value.contains('.') => format!("{number:.4}")
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
        _ => value.to_owned(),
    }
}

/// With a capital letter, as a sentence begins.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// Text that cannot be taken for markup.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

const STYLE: &str = "
:root{--ink:#222;--faint:#666;--paper:#fff;--green:#187a3c;--blue:#2a5db0;--red:#b3261e;--amber:#8a6100}
@media (prefers-color-scheme:dark){:root{--ink:#ddd;--faint:#999;--paper:#16181c;--green:#63c487;--blue:#86aef0;--red:#ff8a80;--amber:#e0b050}}
@media print{:root{--ink:#000;--faint:#666;--paper:#fff;--green:#060;--blue:#036;--red:#900;--amber:#640}figure,tr{break-inside:avoid}}
body{color:var(--ink);background:var(--paper);font:15px/1.45 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem}
h1{font-size:1.4rem}h2{font-size:1.1rem}.verdict{font-size:1.15rem}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));gap:1rem}figure{margin:0}figcaption{color:var(--faint);font-size:.85rem}
svg{width:100%;height:auto}table{border-collapse:collapse;width:100%;font-size:.85rem}
th{white-space:nowrap}td,th{text-align:left;padding:.15rem .5rem;border-bottom:1px solid color-mix(in srgb,var(--faint) 35%,transparent);vertical-align:top}
.warn{color:var(--amber)}.error{color:var(--red)}pre{font-size:.85rem;white-space:pre-wrap}
@media print{body{margin:0;font-size:11px}.figures{grid-template-columns:1fr 1fr}}
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::parse;

    fn page(lines: &[&str]) -> GraspPage {
        let mut page = GraspPage::default();
        for line in lines {
            page.take(parse(line).expect("a line"));
        }
        page
    }

    #[test]
    fn a_page_tells_place_and_truth() {
        let html = page(&[
            "0.1 [INFO ] boot version=1 scene=p70",
            "2.1 [INFO ] located phalanx=2 k_mm=30.52 sigma_mm=0.61 force_n=0.8 settled=true",
            r#"{"type":"summary","verdict":"located","phalanx":2,"k_mm":30.52,"true_phalanx":2,"true_k_mm":30.0}"#,
        ])
        .html("A grasp", None);
        assert!(html.contains("<b>30.5 ± 0.6 mm</b>"), "{html}");
        assert!(html.contains("+0.52 mm off"));
    }

    #[test]
    fn a_fault_that_was_cleared_is_no_verdict() {
        let mut lines = vec!["state name=fault from=close", "fault number=12 name=stall"];
        assert!(page(&lines).html("", None).contains("Fault: stall."));
        lines.extend(["state name=idle from=fault", "state name=close from=home"]);
        let html = page(&lines).html("", None);
        assert!(html.contains("No contact was felt."), "{html}");
    }

    #[test]
    fn a_page_tells_how_stiff_the_object_is() {
        let html = page(&[
            "2.1 [INFO ] located phalanx=2 k_mm=30.52 sigma_mm=0.61 force_n=0.8 settled=true",
            "2.2 [INFO ] object relative=stiffer stiffness_n_per_mm=0.528 least_n_per_mm=0.41",
        ])
        .html("A grasp", None);
        assert!(html.contains("force 0.80 N, object 0.53 N/mm."), "{html}");
    }

    #[test]
    fn what_comes_from_outside_is_no_markup() {
        let html = page(&["<script>alert(1)</script> key=<b>"]).html("<i>", None);
        assert!(!html.contains("<script>") && !html.contains("<b>") && !html.contains("<i>"));
    }
}
