//! Whole-path figures: what the firmware costs as it runs a simulated grasp on the emulated chip.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Core clock, hertz.
const CLOCK_HZ: f64 = 170e6;
/// Limits: mean instructions of the control interrupt and of a sensing update, share of the processor of both.
const CONTROL_MOST: f64 = 600.0;
const SENSING_MOST: f64 = 1500.0;
const LOAD_MOST_PERCENT: f64 = 15.0;

/// An interrupt or a function, over the whole grasp.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Part {
    /// Interrupt or function.
    pub name: String,
    /// Finished calls.
    pub calls: u64,
    /// Mean executed instructions.
    pub instructions_mean: f64,
    /// Dearest call.
    pub instructions_max: u64,
    /// Mean cycles, lower bracket.
    pub cycles_low_mean: f64,
    /// Mean cycles, upper bracket.
    pub cycles_high_mean: f64,
}

/// A stack and how deep it got.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Stack {
    /// Which.
    pub name: String,
    /// Deepest use, bytes.
    pub used_bytes: u64,
    /// Room, bytes.
    pub size_bytes: u64,
}

/// What a run said.
#[derive(Default)]
pub struct Grasp {
    parts: Vec<Part>,
    /// The stacks.
    pub stacks: Vec<Stack>,
    events: Vec<Value>,
    summary: Value,
}

/// A line of the report.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// `path`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its cost.
    #[serde(flatten)]
    pub part: Part,
    /// Share of the processor by the lower and upper bracket, percent of the grasp's time.
    pub load_low_percent: f64,
    /// Upper bracket.
    pub load_high_percent: f64,
}

/// Reads what `palpate-emulator sim --json --counts` printed.
pub fn read(path: &Path) -> Result<Grasp> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut grasp = Grasp::default();
    for line in text.lines() {
        let value: Value = serde_json::from_str(line)
            .with_context(|| format!("not what the emulator prints: {line}"))?;
        match value.get("type").and_then(Value::as_str) {
            Some("count") => grasp.parts.push(serde_json::from_value(value)?),
            Some("stack") => grasp.stacks.push(serde_json::from_value(value)?),
            Some("event") => grasp.events.push(value),
            Some("summary") => grasp.summary = value,
            _ => {}
        }
    }
    Ok(grasp)
}

/// Figures by the part of a name that tells them.
const FIGURES: &[(&str, &str, &str)] = &[
    ("control interrupt", "ADC1_2", ""),
    ("sensing update", "sensing::sensor::Sensor", "::update"),
    ("curve fit, one step", "sensing::sensor::Sensor", "::refine"),
    (
        "curve fit, one hypothesis followed",
        "sensing::fit::Hypothesis",
        "::follow",
    ),
    ("tangent places", "::places", ""),
];

impl Grasp {
    fn seconds(&self) -> f64 {
        self.summary
            .get("emulated_s")
            .and_then(Value::as_f64)
            .unwrap_or(f64::NAN)
    }

    /// The parts that a reader asks for.
    pub fn figures(&self) -> Vec<Figure> {
        let share =
            |cycles: f64, calls: u64| 100.0 * cycles * calls as f64 / (CLOCK_HZ * self.seconds());
        FIGURES
            .iter()
            .filter_map(|&(what, name, end)| {
                let part = self.parts.iter().find(|part| {
                    part.name.contains(name)
                        && (end.is_empty() || part.name.contains(&format!("{end}")))
                })?;
                Some(Figure {
                    kind: "path",
                    what,
                    part: part.clone(),
                    load_low_percent: share(part.cycles_low_mean, part.calls),
                    load_high_percent: share(part.cycles_high_mean, part.calls),
                })
            })
            .collect()
    }

    /// What misses the limits.
    pub fn check(&self) -> Vec<String> {
        let figures = self.figures();
        let mut wrong = Vec::new();
        let mut load = 0.0;
        for (what, most) in [
            ("control interrupt", CONTROL_MOST),
            ("sensing update", SENSING_MOST),
        ] {
            match figures.iter().find(|figure| figure.what == what) {
                None => wrong.push(format!("the grasp does not show the {what}")),
                Some(figure) => {
                    load += figure.load_high_percent;
                    if figure.part.instructions_mean > most {
                        wrong.push(format!(
                            "{what}: {:.0} instructions on average, {most:.0} are allowed",
                            figure.part.instructions_mean
                        ));
                    }
                }
            }
        }
        if load > LOAD_MOST_PERCENT {
            wrong.push(format!("control and sensing take {load:.1} % of the processor, {LOAD_MOST_PERCENT} % are allowed"));
        }
        wrong
    }

    fn at(&self, name: &str) -> Option<f64> {
        let event = self
            .events
            .iter()
            .rev()
            .find(|event| event.get("name").and_then(Value::as_str) == Some(name))?;
        event.get("t_s")?.as_f64()
    }

    /// The tables.
    pub fn text(&self) -> String {
        let mut text = format!(
            "One grasp of the default scene, {:.1} s, on the emulated chip.\n\n\
             | part | calls | instructions, mean | max | cycles, mean | processor, % |\n|---|---|---|---|---|---|\n",
            self.seconds()
        );
        for figure in self.figures() {
            let part = &figure.part;
            let _ = writeln!(
                text,
                "| {} | {} | {:.0} | {} | {:.0} to {:.0} | {:.2} to {:.2} |",
                figure.what,
                part.calls,
                part.instructions_mean,
                part.instructions_max,
                part.cycles_low_mean,
                part.cycles_high_mean,
                figure.load_low_percent,
                figure.load_high_percent,
            );
        }
        text += "\n| stack | used, bytes | of |\n|---|---|---|\n";
        for stack in &self.stacks {
            let _ = writeln!(
                text,
                "| {} | {} | {} |",
                stack.name, stack.used_bytes, stack.size_bytes
            );
        }
        let number = |key: &str| self.summary.get(key).and_then(Value::as_f64);
        if let (Some(touch), Some(located)) = (self.at("touch"), self.at("located")) {
            let _ = writeln!(text, "\nLocated {:.2} s after Touch.", located - touch);
        }
        if let (Some(k), Some(truth)) = (number("k_mm"), number("true_k_mm")) {
            let _ = writeln!(text, "Estimate {k:.2} mm, simulated truth {truth:.2} mm.");
        }
        text
    }
}
