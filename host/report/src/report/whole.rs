//! Whole-path figures: cost of the firmware in a simulated grasp on the emulated chip.

use palpate_document::table::head;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Core clock, hertz.
const CLOCK_HZ: f64 = 170e6;

/// An interrupt or a function, over the whole grasp.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Part {
    /// `interrupt`, `function`, or `without`: the calls of a function in which no curve fit ran.
    #[serde(skip_serializing)]
    pub kind: String,
    /// Interrupt or function.
    pub name: String,
    /// Finished calls.
    pub calls: u64,
    /// Mean executed instructions.
    pub instructions_mean: f64,
    /// Most instructions of a call.
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
    /// Other grasps, in words, and the longest update of the sensing in each, instructions.
    others: Vec<(String, u64)>,
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

/// Reads what `palpate-emulator sim --json --counts` printed, with every figure that is needed.
pub fn read(path: &Path) -> Result<Grasp> {
    let grasp = parse(path)?;
    grasp.complete()?;
    Ok(grasp)
}

fn parse(path: &Path) -> Result<Grasp> {
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

/// What a reader asks for, by name.
pub const CONTROL: &str = "control interrupt";
/// Every update.
pub const UPDATE: &str = "sensing update, all";
/// The typical update: a fit runs some hundred times a contact, and what a motion has shown of friction is taken over once after it, in
/// steps of which the longest is the longest update of all.
pub const TYPICAL: &str = "sensing update without a fit";
/// The rare one.
pub const WITH_FIT: &str = "sensing update with a step of the fit";

/// The bisection that turns a tangent stiffness into a place.
pub const BISECTION: &str = "bisection of a contact's place, a root";

/// A figure: its name, what kind of count it is, and the part of a function's name that identifies it; the first one present.
struct Known {
    what: &'static str,
    kind: &'static str,
    names: &'static [(&'static str, &'static str)],
}

const FIGURES: &[Known] = &[
    Known {
        what: CONTROL,
        kind: "interrupt",
        names: &[("ADC1_2", "")],
    },
    Known {
        what: TYPICAL,
        kind: "without",
        names: &[("sensing::sensor::Sensor", "::update")],
    },
    Known {
        what: UPDATE,
        kind: "function",
        names: &[("sensing::sensor::Sensor", "::update")],
    },
    Known {
        what: WITH_FIT,
        kind: "with",
        names: &[("sensing::sensor::Sensor", "::update")],
    },
    Known {
        what: "fit: some points of a pass along the curve",
        kind: "function",
        names: &[("sensing::locator::fit", "::go_on")],
    },
    Known {
        what: BISECTION,
        kind: "function",
        names: &[("numeric::bisect", "::bisect_quadratic")],
    },
    Known {
        what: "fit: the places of a slope, where it starts",
        kind: "function",
        names: &[("sensing::locator::starts", "find")],
    },
    Known {
        what: "fit: the same, with where it leads to",
        kind: "function",
        names: &[("sensing::locator::fit", "::step")],
    },
];

/// The figures without which the page would lie by leaving them out.
const NEEDED: &[&str] = &[CONTROL, TYPICAL, UPDATE, BISECTION];

impl Grasp {
    fn seconds(&self) -> f64 {
        self.summary
            .get("emulated_s")
            .and_then(Value::as_f64)
            .unwrap_or(f64::NAN)
    }

    /// The parts that a reader asks for.
    pub fn figures(&self) -> Vec<Figure> {
        let found = |known: &Known| {
            known.names.iter().find_map(|(name, end)| {
                // Of several with such a name, the one that is called.
                let fits = |part: &&Part| {
                    part.kind == known.kind
                        && part.calls > 0
                        && part.name.contains(name)
                        && part.name.contains(end)
                };
                self.parts.iter().filter(fits).max_by_key(|part| part.calls)
            })
        };
        FIGURES
            .iter()
            .filter_map(|known| Some(self.figure(known.what, found(known)?.clone())))
            .collect()
    }

    /// One of them.
    pub fn of(&self, what: &str) -> Option<Figure> {
        self.figures()
            .into_iter()
            .find(|figure| figure.what == what)
    }

    /// What is missing, or was never called: the firmware's functions were renamed, or inlined.
    fn complete(&self) -> Result<()> {
        for what in NEEDED {
            if self.of(what).is_none() {
                bail!(
                    "the emulator counted no call of: {what}. Was its function renamed, inlined or not called?"
                );
            }
        }
        Ok(())
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

    /// Deepest use of all stacks together, bytes: an interrupt comes on top of a task.
    pub fn stack_bytes(&self) -> u64 {
        self.stacks.iter().map(|stack| stack.used_bytes).sum()
    }

    /// Adds what the emulator counted during another grasp, of which only the longest update is told: WORDS=FILE.
    pub fn add(&mut self, other: &str) -> Result<()> {
        let (words, path) = other
            .split_once('=')
            .with_context(|| format!("'{other}' is not WORDS=FILE"))?;
        let update = parse(Path::new(path))?.of(UPDATE);
        let update = update.with_context(|| format!("{path}: no {UPDATE} was counted"))?;
        self.others
            .push((words.to_owned(), update.part.instructions_max));
        Ok(())
    }

    /// The longest update of the sensing, of this grasp and the others, instructions.
    pub fn longest_update(&self) -> Option<u64> {
        let own = self.of(UPDATE)?.part.instructions_max;
        self.others
            .iter()
            .map(|(_, longest)| *longest)
            .chain([own])
            .max()
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
            "One grasp of the default scene, {:.1} s, on the emulated chip.\n\n{}",
            self.seconds(),
            head("part | calls | instructions, mean | max | cycles, mean | processor, %")
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
        if !self.others.is_empty() {
            let each = |(words, longest): &(String, u64)| format!("{longest} {words}");
            let each: Vec<_> = self.others.iter().map(each).collect();
            let _ = writeln!(
                text,
                "\nLongest update of the sensing in other grasps, instructions: {}.",
                each.join(", ")
            );
        }
        text.push('\n');
        text += &head("stack | used, bytes | of");
        for stack in &self.stacks {
            let _ = writeln!(
                text,
                "| {} | {} | {} |",
                stack.name, stack.used_bytes, stack.size_bytes
            );
        }
        let _ = writeln!(text, "| together | {} | |", self.stack_bytes());
        let number = |key: &str| self.summary.get(key).and_then(Value::as_f64);
        if let (Some(touch), Some(located)) = (self.at("touch"), self.at("located")) {
            let _ = writeln!(
                text,
                "\nLocated for the last time {:.2} s after Touch.",
                located - touch
            );
        }
        if let (Some(k), Some(truth)) = (number("k_mm"), number("true_k_mm")) {
            let _ = writeln!(text, "Estimate {k:.2} mm, simulated truth {truth:.2} mm.");
        }
        text
    }
}

#[cfg(test)]
mod tests;
