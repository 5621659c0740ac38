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

/// A target of the whole path.
#[derive(Clone, Debug, Serialize)]
pub struct Target {
    /// `target`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Of what.
    pub what: &'static str,
    /// Mean over the grasp.
    pub measured: f64,
    /// At most this was wanted.
    pub most: f64,
    /// Of both.
    pub unit: &'static str,
    /// Reached.
    pub met: bool,
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

/// The part of a sensing update that is asked for once a block of a contact, not at every sample.
const FIT: &str = "curve fit, one step";
const CONTROL: &str = "control interrupt";
const UPDATE: &str = "sensing update";
const TYPICAL: &str = "sensing update, its fits left out";

/// Figures by the part of a name that tells them.
const FIGURES: &[(&str, &str, &str)] = &[
    (CONTROL, "ADC1_2", ""),
    (UPDATE, "sensing::sensor::Sensor", "::update"),
    (FIT, "sensing::sensor::known::Known", "::refine"),
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
        let part = |&(what, name, end): &(&'static str, &str, &str)| {
            let fits = |part: &&Part| part.name.contains(name) && part.name.contains(end);
            Some((what, self.parts.iter().find(fits)?.clone()))
        };
        let mut parts: Vec<(&'static str, Part)> = FIGURES.iter().filter_map(part).collect();
        let of = |what: &str| {
            parts
                .iter()
                .find(|part| part.0 == what)
                .map(|part| part.1.clone())
        };
        if let (Some(update), Some(fit)) = (of(UPDATE), of(FIT)) {
            let share = fit.calls as f64 / update.calls.max(1) as f64;
            let typical = Part {
                name: update.name.clone(),
                calls: update.calls,
                instructions_mean: update.instructions_mean - share * fit.instructions_mean,
                // Which calls had no fit in them is not known.
                instructions_max: update.instructions_max,
                cycles_low_mean: update.cycles_low_mean - share * fit.cycles_low_mean,
                cycles_high_mean: update.cycles_high_mean - share * fit.cycles_high_mean,
            };
            parts.push((TYPICAL, typical));
        }
        parts
            .into_iter()
            .map(|(what, part)| self.figure(what, part))
            .collect()
    }

    fn figure(&self, what: &'static str, part: Part) -> Figure {
        let share = |cycles: f64| 100.0 * cycles * part.calls as f64 / (CLOCK_HZ * self.seconds());
        Figure {
            kind: "path",
            what,
            load_low_percent: share(part.cycles_low_mean),
            load_high_percent: share(part.cycles_high_mean),
            part,
        }
    }

    /// Targets of the whole path: what, measured, wanted at most, unit.
    pub fn targets(&self) -> Vec<Target> {
        let figures = self.figures();
        let of = |what: &str| figures.iter().find(|figure| figure.what == what);
        let instructions = |what| of(what).map_or(f64::NAN, |figure| figure.part.instructions_mean);
        let load: f64 = [CONTROL, TYPICAL]
            .map(|what| of(what).map_or(f64::NAN, |figure| figure.load_high_percent))
            .iter()
            .sum();
        let target = |what, measured, most, unit| Target {
            kind: "target",
            what,
            measured,
            most,
            unit,
            met: measured <= most,
        };
        vec![
            target(CONTROL, instructions(CONTROL), CONTROL_MOST, "instructions"),
            target(TYPICAL, instructions(TYPICAL), SENSING_MOST, "instructions"),
            target(
                "both, upper cycle bracket",
                load,
                LOAD_MOST_PERCENT,
                "% of the processor",
            ),
        ]
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
        text += "\n| target | measured | at most | |\n|---|---|---|---|\n";
        for target in self.targets() {
            let Target {
                what,
                measured,
                most,
                unit,
                met,
                ..
            } = target;
            let verdict = if met { "met" } else { "**missed**" };
            let _ = writeln!(
                text,
                "| {what}, {unit} | {measured:.1} | {most:.0} | {verdict} |"
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
