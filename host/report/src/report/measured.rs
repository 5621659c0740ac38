//! Counts of the emulator while the bench image ran: the image's own lines, and the cycles of its functions.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::Deserialize;
use serde_json::Value;

use super::row::Cost;
use palpate_image::Image;

/// What a function cost, as the emulator counts it.
#[derive(Deserialize)]
struct Count {
    name: String,
    cycles_low_mean: f64,
    cycles_high_mean: f64,
}

/// A candidate on the chip.
pub struct Measured {
    /// Task.
    pub task: String,
    /// Candidate.
    pub name: String,
    /// Of its results.
    pub checksum: u32,
    /// Where its function is.
    pub address: u32,
    /// What a call costs.
    pub cost: Cost,
}

/// Mean cycles of a function, low and high.
type Cycles = HashMap<String, (f64, f64)>;

/// Reads what `palpate-emulator bench --json` printed for this image.
pub fn read(path: &Path, image: &Image) -> Result<Vec<Measured>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let (mut events, mut cycles) = (Vec::new(), Cycles::new());
    for line in text.lines() {
        // By hand and not as a tagged enum: through one, serde loses numbers once any program of the workspace asks serde_json for
        // `arbitrary_precision`.
        let value: Value = serde_json::from_str(line)
            .with_context(|| format!("not what the emulator prints: {line}"))?;
        match value.get("type").and_then(Value::as_str) {
            // A log line of the image.
            Some("event") => events.push(value),
            Some("count") => {
                let count: Count = serde_json::from_value(value)?;
                let mean = (count.cycles_low_mean, count.cycles_high_mean);
                cycles.insert(count.name, mean);
            }
            _ => {}
        }
    }
    let name = |event: &Value| event.get("name").and_then(Value::as_str).map(str::to_owned);
    if !events
        .iter()
        .any(|event| name(event).as_deref() == Some("bench done"))
    {
        bail!(
            "the run on the emulated chip did not end: {:?}",
            events.last()
        );
    }
    events
        .iter()
        .filter(|event| name(event).as_deref() == Some("bench") && event.get("task").is_some())
        .map(|event| one(event, image, &cycles))
        .collect()
}

fn one(fields: &Value, image: &Image, cycles: &Cycles) -> Result<Measured> {
    let field = |key: &str| {
        fields
            .get(key)
            .with_context(|| format!("no {key} in {fields:?}"))
    };
    let text = |key: &str| -> Result<String> {
        Ok(field(key)?
            .as_str()
            .with_context(|| format!("{key} is no text"))?
            .to_owned())
    };
    let number = |key: &str| -> Result<u64> {
        field(key)?
            .as_u64()
            .with_context(|| format!("{key} is no count"))
    };
    let of = |address: u32| {
        image
            .symbol_at(address)
            .and_then(|symbol| cycles.get(&symbol.name()))
            .copied()
            .unwrap_or((f64::NAN, f64::NAN))
    };
    let address = |key: &str| anyhow::Ok(u32::try_from(number(key)?)? & !1);
    let (address, nothing) = (address("address")?, address("nothing")?);
    let (own, nothing) = (of(address), of(nothing));
    let cycles_low = own.0 - nothing.0;
    Ok(Measured {
        task: text("task")?,
        // The event has a name of its own.
        name: text("field_name")?,
        checksum: u32::try_from(number("checksum")?)?,
        address,
        cost: Cost {
            instructions_mean: number("total")? as f64 / number("calls")?.max(1) as f64,
            instructions_max: number("max")?,
            cycles_low,
            // A function of one instruction costs no more than the empty one.
            cycles_high: (own.1 - nothing.1).max(cycles_low),
        },
    })
}
