//! What a page about a recording is made of: the lines that the firmware would have logged, as `sim --json` has them.

use std::error::Error;
use std::path::Path;

use palpate::app::console::settings::Setting;
use palpate::sample::{Drive, Sample};
use palpate::sensing::{Event, Settings};
use palpate_evaluation::replay::{Replay, fields};
use serde_json::{Value, json};

use super::{Options, event_json};

/// Every so many samples of a recording are written for a page.
const PAGE_SAMPLES: usize = 2;

/// Writes them, where they are asked for.
pub fn leave(found: &Replay, recorded: &[Sample], options: &Options) -> Result<(), Box<dyn Error>> {
    if let Some(path) = &options.events {
        let lines = lines(found, recorded, options);
        let lines: Vec<String> = lines.iter().map(|line| format!("{line}\n")).collect();
        std::fs::write(path, lines.concat())
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    Ok(())
}

/// The scene, settings and calibration, then samples and events in the order of their times, then the truth if it lies beside the
/// recording (`NAME.json` beside `NAME.csv.gz`).
fn lines(found: &Replay, recorded: &[Sample], options: &Options) -> Vec<Value> {
    let mut lines = vec![json!({"type": "event", "name": "boot", "scene": options.scene})];
    lines.extend(settings(&found.settings));
    lines.extend(known_before(found));
    let mut told = found.lines().into_iter().peekable();
    let mut evidence = found.evidence.iter().peekable();
    for (index, sample) in recorded.iter().enumerate() {
        while let Some((time_us, fields)) = told.next_if(|told| told.0 <= sample.time_us) {
            lines.push(event_json(fields, time_us as f64 * 1e-6));
        }
        let news = evidence.next_if(|news| news.0 <= sample.time_us);
        if news.is_none() && index % PAGE_SAMPLES > 0 {
            continue;
        }
        let drive = match sample.drive {
            Drive::Closing => 1,
            Drive::Opening => -1,
            Drive::Idle => 0,
        };
        let mut line = json!({
            "type": "event", "name": "sample", "time_us": sample.time_us, "counts": sample.position_counts,
            "current_a": sample.current_a, "drive": drive,
        });
        if let Some((_, found)) = news {
            line["residual_mnm"] = json!(1e3 * found.residual_nm);
            line["evidence"] = json!(found.ln_ratio);
            line["threshold"] = json!(found.threshold);
        }
        lines.push(line);
    }
    lines.extend(told.map(|(time_us, fields)| event_json(fields, time_us as f64 * 1e-6)));
    if let Some((phalanx, k_mm)) = truth_beside(&options.file) {
        lines.push(json!({"type": "truth", "phalanx": phalanx, "k_mm": k_mm, "force_n": 0.0}));
    }
    lines
}

/// The settings that the sensing has, in the words of the command `show`.
fn settings(settings: &Settings) -> Vec<Value> {
    [
        (Setting::ClosingSpeed, settings.speed_rad_per_s),
        (Setting::ProbeTorque, settings.torque_limit_nm),
        (Setting::WantedDeviation, settings.wanted_sigma_m),
        (Setting::Sensitivity, settings.false_contacts_per_thousand),
    ]
    .map(|(setting, value_si)| {
        let (name, range, unit) = (setting.name(), setting.range(), setting.unit());
        let value = range.to_user(value_si);
        json!({"type": "event", "name": format!("answer {name} {value:.3} {unit} ({range})")})
    })
    .to_vec()
}

/// A calibration that the recording began with: one that it made is among its events.
fn known_before(found: &Replay) -> Option<Value> {
    let calibration = found.calibration;
    let made = |event: &Event| matches!(event, Event::Calibrated { .. });
    let known = calibration.contacts > 0 || calibration.presses > 0;
    if !known || found.told.iter().any(|told| made(&told.event)) {
        return None;
    }
    Some(event_json(fields(&Event::Calibrated { calibration }), 0.0))
}

/// Where a recording's contact began, told by the file beside it.
fn truth_beside(recording: &Path) -> Option<(u64, f64)> {
    let name = recording.file_name()?.to_str()?;
    let name = name.strip_suffix(".gz").unwrap_or(name);
    let beside = recording.with_file_name(format!("{}.json", name.strip_suffix(".csv")?));
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(beside).ok()?).ok()?;
    let contact = truth.get("contact")?;
    Some((
        contact.get("phalanx_first")?.as_u64()?,
        contact.get("k_first_mm")?.as_f64()?,
    ))
}
