//! `wiring`: draws the tables of docs/HARDWARE.md#wiring, after checking them against each other and against the scenes.

mod draw;

use crate::process::{Failure, Outcome, root};

const SOURCE: &str = "docs/HARDWARE.md";
const DRAWING: &str = "docs/figures/wiring.svg";
const DEFAULTS: &str = "scenes/common/defaults.toml";
const BEGIN: &str = "<!-- wiring: begin -->";
const END: &str = "<!-- wiring: end -->";

/// Pins of the bridge, the thermal pad as the last.
const BRIDGE_PINS: usize = 17;

/// A heading with the table below it.
#[derive(Debug, PartialEq)]
struct Sheet {
    title: String,
    wires: Vec<Wire>,
}

/// A row: two ends and what lies between them.
#[derive(Debug, PartialEq)]
struct Wire {
    ends: [String; 2],
    parts: Vec<Part>,
}

/// A part on the way of a wire.
#[derive(Debug, PartialEq)]
struct Part {
    name: String,
    value: String,
    /// Net at its other end; `None` where it is in series.
    to: Option<String>,
}

impl Part {
    fn parse(text: &str) -> Result<Self, String> {
        let (name, rest) = text
            .split_once(' ')
            .ok_or_else(|| format!("'{text}' is no part with a value"))?;
        let (value, to) = match (rest.strip_suffix(" in series"), rest.rsplit_once(" to ")) {
            (Some(value), _) => (value, None),
            (None, Some((value, net))) => (value, Some(net.to_owned())),
            _ => {
                return Err(format!(
                    "'{text}' ends neither in 'in series' nor in 'to NET'"
                ));
            }
        };
        Ok(Self {
            name: name.to_owned(),
            value: value.to_owned(),
            to,
        })
    }
}

/// The tables between the markers.
fn parse(document: &str) -> Result<Vec<Sheet>, String> {
    let tables = document
        .split_once(BEGIN)
        .and_then(|(_, rest)| rest.split_once(END))
        .ok_or_else(|| format!("{SOURCE} lacks the markers {BEGIN} and {END}"))?
        .0;
    let mut sheets: Vec<Sheet> = Vec::new();
    for line in tables.lines() {
        if let Some(title) = line.strip_prefix("### ") {
            sheets.push(Sheet {
                title: title.to_owned(),
                wires: Vec::new(),
            });
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let (Some(sheet), &[_, left, parts, right, _why, _]) = (sheets.last_mut(), &cells[..])
        else {
            continue;
        };
        if left.starts_with("---") || right.contains("goes to") || right.contains("pin of the") {
            continue;
        }
        let parts = match parts {
            "-" => Vec::new(),
            parts => parts
                .split(';')
                .map(|part| Part::parse(part.trim()))
                .collect::<Result<_, _>>()?,
        };
        sheet.wires.push(Wire {
            ends: [left.to_owned(), right.to_owned()],
            parts,
        });
    }
    Ok(sheets)
}

/// A value such as `6.8 kohm` or `330 uF` in its unit without prefix.
fn number(value: &str) -> Option<f64> {
    let (digits, unit) = value.split_once(' ')?;
    let prefix = match unit {
        "ohm" => 1.0,
        "kohm" => 1e3,
        "uF" => 1e-6,
        "nF" => 1e-9,
        _ => return None,
    };
    Some(digits.parse::<f64>().ok()? * prefix)
}

/// Value of a part, by its name.
fn value(sheets: &[Sheet], name: &str) -> Result<f64, String> {
    let mut parts = sheets
        .iter()
        .flat_map(|sheet| &sheet.wires)
        .flat_map(|wire| &wire.parts);
    parts
        .find(|part| part.name == name)
        .and_then(|part| number(&part.value))
        .ok_or_else(|| format!("no part {name} with a value"))
}

/// A number of a scene file.
fn setting(toml: &str, key: &str) -> Result<f64, String> {
    toml.lines()
        .find_map(|line| {
            let (name, rest) = line.split_once('=')?;
            let value = rest.split('#').next()?.trim();
            (name.trim() == key).then(|| value.parse().ok())?
        })
        .ok_or_else(|| format!("{DEFAULTS} has no number `{key}`"))
}

/// Every pin of the bridge once, every part name with one value, and the values that the firmware computes with.
fn check(sheets: &[Sheet], defaults: &str) -> Result<(), String> {
    let bridge = sheets.first().ok_or("there is no table")?;
    for pin in 1..=BRIDGE_PINS {
        let prefix = format!("{pin} ");
        let wired = bridge.wires.iter();
        let wired = wired.filter(|wire| wire.ends[1].starts_with(&prefix));
        if wired.count() != 1 {
            return Err(format!("pin {pin} of the bridge is not wired exactly once"));
        }
    }
    let parts: Vec<&Part> = sheets
        .iter()
        .flat_map(|sheet| &sheet.wires)
        .flat_map(|wire| &wire.parts)
        .collect();
    for part in &parts {
        if let Some(other) = parts
            .iter()
            .find(|other| other.name == part.name && other.value != part.value)
        {
            return Err(format!(
                "{} is {} and {}",
                part.name, part.value, other.value
            ));
        }
    }
    let sense_ohm = value(sheets, "R1")?;
    let (upper_ohm, lower_ohm) = (value(sheets, "R3")?, value(sheets, "R4")?);
    for (key, wired) in [
        ("resistor_ohm", sense_ohm),
        ("shunt_ohm", value(sheets, "RS")?),
        ("divider", lower_ohm / (lower_ohm + upper_ohm)),
    ] {
        let scene = setting(defaults, key)?;
        if (scene - wired).abs() > 1e-6 * scene {
            return Err(format!(
                "`{key}` is {scene} in {DEFAULTS}, {wired} in {SOURCE}"
            ));
        }
    }
    // Three time constants within a control period of 50 us: a fault is seen in the next one.
    let divider_ohm = upper_ohm * lower_ohm / (upper_ohm + lower_ohm);
    for (ohm, capacitor) in [(sense_ohm, "C1"), (divider_ohm, "C7")] {
        let settled_s = 3.0 * ohm * value(sheets, capacitor)?;
        if settled_s > 50e-6 {
            return Err(format!(
                "{capacitor} settles within {settled_s} s, longer than a control period"
            ));
        }
    }
    Ok(())
}

/// The drawing of a document, checked against the scenes' defaults.
fn drawing(document: &str, defaults: &str) -> Result<String, String> {
    let sheets = parse(document)?;
    check(&sheets, defaults)?;
    Ok(draw::svg(&sheets))
}

/// Draws the tables into docs/figures.
pub fn wiring(arguments: &[String]) -> Outcome {
    if let Some(word) = arguments.first() {
        return Err(Failure::usage(format!("unexpected '{word}'")));
    }
    let read = |file: &str| {
        std::fs::read_to_string(root().join(file))
            .map_err(|error| Failure::new(format!("{file}: {error}")))
    };
    let svg = drawing(&read(SOURCE)?, &read(DEFAULTS)?).map_err(Failure::new)?;
    std::fs::write(root().join(DRAWING), svg)
        .map_err(|error| Failure::new(format!("cannot write {DRAWING}: {error}")))?;
    println!("{DRAWING}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = include_str!("../../../docs/HARDWARE.md");
    const DEFAULT_SCENE: &str = include_str!("../../../scenes/common/defaults.toml");

    #[test]
    fn the_drawing_is_that_of_the_tables() {
        let drawn = drawing(DOCUMENT, DEFAULT_SCENE).expect("tables that hold together");
        assert!(
            drawn == include_str!("../../../docs/figures/wiring.svg"),
            "{DRAWING} is older than the tables of {SOURCE}; run: cargo xtask wiring"
        );
    }

    #[test]
    fn the_pins_are_those_of_the_firmware() {
        let firmware = include_str!("../../../src/board/mod.rs");
        let sheets = parse(DOCUMENT).expect("tables");
        // The variant takes a pin over.
        let ends = sheets[..2].iter().flat_map(|sheet| &sheet.wires);
        let mut pins: Vec<&str> = ends
            .filter_map(|wire| wire.ends[0].split_once(", CN"))
            .map(|(pin, _)| pin)
            .filter(|pin| pin.starts_with('P'))
            .collect();
        for pin in &pins {
            assert!(firmware.contains(&format!("p.{pin}")), "{pin}");
        }
        let wired = pins.len();
        pins.sort_unstable();
        pins.dedup();
        assert_eq!((wired, pins.len()), (9, 9), "{pins:?}");
    }

    #[test]
    fn what_does_not_hold_together_is_refused() {
        for (from, to, complaint) in [
            ("| 16 PMODE |", "| 15 PMODE |", "pin 15"),
            ("R1 6.8 kohm", "R1 4.7 kohm", "resistor_ohm"),
            ("R3 82 kohm", "R3 100 kohm", "divider"),
            ("C7 1 nF to GND; ", "C7 10 nF to GND; ", "C7 settles"),
            ("C8 100 nF", "C1 100 nF", "C1 is"),
            ("C2 22 nF in series", "C2 22 nF", "C2 22 nF"),
        ] {
            let changed = DOCUMENT.replacen(from, to, 1);
            let refused = drawing(&changed, DEFAULT_SCENE).expect_err(to);
            assert!(refused.contains(complaint), "{to}: {refused}");
        }
    }
}
