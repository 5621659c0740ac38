//! Results as JSON lines and as a table.

use serde_json::{Map, Value, json};

use super::world::{Calibrated, Line, World};
use crate::score::{Answer, Scores};

/// A figure rounded for reading, or null.
fn number(value: f64) -> Value {
    if value.is_finite() {
        json!((value * 1e4).round() / 1e4)
    } else {
        Value::Null
    }
}

/// The one word for a line.
fn word(line: &Line) -> &'static str {
    if line.class.calibrates() {
        return "none";
    }
    match line.trial.answer {
        Answer::Located { .. } => "located",
        Answer::Ambiguous { .. } => "ambiguous",
        Answer::Proximal => "proximal",
        Answer::NotLocated => "not-located",
        Answer::Nothing if line.trial.unusual => "unusual",
        Answer::Nothing => "none",
    }
}

fn line_json(line: &Line) -> Value {
    let trial = &line.trial;
    let (k_m, sigma_m) = trial.answer.place().unwrap_or((f64::NAN, f64::NAN));
    let truth = line.truth;
    let mut value = json!({
        "type": "recording", "name": line.name, "cls": line.class.name(), "verdict": word(line),
        "phalanx": trial.answer.phalanx(), "k_mm": number(1e3 * k_m), "sigma_mm": number(1e3 * sigma_m),
        "touch_s": trial.touched_s.map(number),
        "force_n": number(trial.force.map_or(f64::NAN, |force| force.told_n)),
        "force_sigma_n": number(trial.force.map_or(f64::NAN, |force| force.sigma_n)),
        "true_phalanx": truth.map_or(0, |contact| contact.phalanx),
        "true_k_mm": truth.map(|contact| number(1e3 * contact.k_m)),
        "true_touch_s": truth.map(|contact| number(contact.time_s)),
        "true_force_n": number(line.true_force_n),
        "early": trial.is_early() && !line.class.calibrates(), "unusual": trial.unusual,
        "err_pct": trial.error_m().and_then(|error| Some(number(100.0 * error / truth?.length_m))),
    });
    if let Value::Object(fields) = &mut value {
        if line.class.calibrates() {
            fields.insert("calibrated".into(), json!(line.refused.is_none()));
        }
        if let Some(object) = &line.object {
            let [compliance, sigma] = object.compliance_m_per_n;
            let stiffness = object.stiffness_n_per_m().map_or(f64::NAN, f64::from);
            for (key, value) in [
                ("object_n_per_m", stiffness),
                ("object_least_n_per_m", object.least_n_per_m().into()),
                ("object_compliance_mm_per_n", 1e3 * f64::from(compliance)),
                ("object_compliance_sigma_mm_per_n", 1e3 * f64::from(sigma)),
                ("object_share", object.share[0].into()),
                (
                    "true_object_n_per_m",
                    line.true_object_n_per_m.unwrap_or(f64::NAN),
                ),
            ] {
                fields.insert(key.into(), number(value));
            }
            fields.insert("object_relative".into(), json!(object.relative().name()));
        }
        if let Some(why) = line.refused {
            fields.insert("refused".into(), json!(format!("{why:?}")));
        }
        if let Some(problem) = line.problem {
            fields.insert("problem".into(), json!(problem));
        }
    }
    value
}

fn scores_json(kind: &str, world: Option<&str>, scores: &Scores) -> Value {
    let mut fields = Map::new();
    fields.insert("type".into(), json!(kind));
    if let Some(world) = world {
        fields.insert("world".into(), json!(world));
    }
    if let Ok(Value::Object(all)) = serde_json::to_value(scores) {
        fields.extend(all.into_iter().map(|(key, value)| {
            let rounded = value
                .as_f64()
                .filter(|_| value.is_f64())
                .map_or(value, number);
            (key, rounded)
        }));
    }
    Value::Object(fields)
}

fn calibration_json(world: &str, calibrated: &Calibrated) -> Value {
    let found = &calibrated.found;
    json!({
        "type": "calibration", "world": world, "contacts": found.contacts, "presses": found.presses,
        "torque_factor": number(found.torque_factor.into()),
        "torque_factor_sigma": number(found.torque_factor_sigma.into()),
        "true_torque_factor": number(calibrated.true_torque_factor),
        "torque_factor_err_pct": number(calibrated.torque_factor_err_pct()),
        "torque_factor_z": number(calibrated.torque_factor_z()),
        "cable_rad_per_nm": number(found.cable_rad_per_nm.into()),
        "cable_sigma_rad_per_nm": number(found.cable_sigma_rad_per_nm.into()),
        "true_cable_rad_per_nm": number(calibrated.true_cable_rad_per_nm),
        "cable_z": number(calibrated.cable_z()),
    })
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    f64::sqrt(sum / count)
}

fn total(worlds: &[World]) -> Scores {
    Scores::of(worlds.iter().flat_map(World::counted))
}

/// One JSON object a line: each recording, each world and its calibration, and the summary of all at the end.
#[must_use]
pub fn json(worlds: &[World]) -> Vec<Value> {
    let mut out = Vec::new();
    for world in worlds {
        out.extend(world.lines.iter().map(line_json));
        if let Some(calibrated) = &world.calibration {
            out.push(calibration_json(&world.name, calibrated));
        }
        if let Some(scale) = world.force_scale {
            out.push(json!({
                "type": "force-scale", "world": world.name, "force_scale": number(scale),
                "true_springs": number(world.true_springs),
            }));
        }
        out.push(scores_json("world", Some(&world.name), &world.scores()));
    }
    let mut summary = scores_json("summary", None, &total(worlds));
    if let Value::Object(fields) = &mut summary {
        let calibrated = || worlds.iter().filter_map(|world| world.calibration.as_ref());
        let mut add = |key: &str, value: f64| fields.insert(key.into(), number(value));
        add(
            "torque_factor_err_rms_pct",
            root_mean_square(calibrated().map(Calibrated::torque_factor_err_pct)),
        );
        add(
            "torque_factor_z_rms",
            root_mean_square(calibrated().map(Calibrated::torque_factor_z)),
        );
        add(
            "cable_z_rms",
            root_mean_square(calibrated().map(Calibrated::cable_z)),
        );
    }
    out.push(summary);
    out
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value
        .filter(|value| value.is_finite())
        .map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

fn line_text(line: &Line) -> String {
    let trial = &line.trial;
    let truth = line.truth;
    let place = trial.answer.place();
    let error_pct = trial
        .error_m()
        .and_then(|error| Some(100.0 * error / truth?.length_m));
    let delay_ms = trial
        .touched_s
        .and_then(|touched| Some(1e3 * (touched - truth?.time_s)));
    let mut notes = Vec::new();
    if trial.is_early() && !line.class.calibrates() {
        notes.push(
            if truth.is_some() {
                "early"
            } else {
                "false alarm"
            }
            .to_owned(),
        );
    }
    if trial.unusual {
        notes.push("unusual".to_owned());
    }
    if let Some(why) = line.refused {
        notes.push(format!("refused: {why:?}"));
    }
    notes.extend(line.problem.map(str::to_owned));
    notes.extend(line.object.as_ref().map(|object| {
        let [compliance, sigma] = object.compliance_m_per_n;
        let stiffness = line.true_object_n_per_m;
        format!(
            "object {:.2} +- {:.2} mm/N (true {:.2}), against the finger {}",
            1e3 * compliance,
            1e3 * sigma,
            stiffness.map_or(0.0, |stiffness| 1e3 / stiffness),
            object.relative().name(),
        )
    }));
    format!(
        "{:<14} {:<9} {:<12} {:>7} {:>6} {:>7} {:>7} {:>8} {:>6} {:>6}  {}\n",
        line.name,
        line.class.name(),
        word(line),
        or_dash(place.map(|(k, _)| 1e3 * k), 1),
        or_dash(place.map(|(_, sigma)| 1e3 * sigma), 2),
        or_dash(truth.map(|contact| 1e3 * contact.k_m), 1),
        or_dash(error_pct, 2),
        or_dash(delay_ms, 0),
        or_dash(trial.force.map(|force| force.told_n), 2),
        or_dash(trial.force.map(|force| force.true_n), 2),
        notes.join(", "),
    )
}

fn scores_text(name: &str, scores: &Scores) -> String {
    format!(
        "{name:<8} distal located {}/{}, |error| {} +- {} % (95 % {}, max {}), within 1/2 sigma {}/{} %, mean z^2 {}\n\
         {:<8} proximal named {}/{}, free clean {}/{}, early {}, missed {}, unusual {}, wrong phalanx {}\n\
         {:<8} delay median {} ms (90 % {}, max {}), force off by {} % (mean {}, 95 % {})\n",
        scores.located,
        scores.distal,
        or_dash(scores.err_mean_pct, 2),
        or_dash(scores.err_sd_pct, 2),
        or_dash(scores.err_95_pct, 1),
        or_dash(scores.err_max_pct, 1),
        or_dash(scores.within1_pct, 0),
        or_dash(scores.within2_pct, 0),
        or_dash(scores.z2_mean, 2),
        "",
        scores.proximal_named,
        scores.proximal,
        scores.free_clean,
        scores.free,
        scores.early,
        scores.missed,
        scores.unusual,
        scores.wrong_phalanx,
        "",
        or_dash(scores.delay_ms, 0),
        or_dash(scores.delay_90_ms, 0),
        or_dash(scores.delay_max_ms, 0),
        or_dash(scores.force_err_pct, 1),
        or_dash(scores.force_err_mean_pct, 1),
        or_dash(scores.force_err_95_pct, 1),
    )
}

/// A table for people.
#[must_use]
pub fn text(worlds: &[World]) -> String {
    let mut out = format!(
        "{:<14} {:<9} {:<12} {:>7} {:>6} {:>7} {:>7} {:>8} {:>6} {:>6}\n",
        "name",
        "class",
        "verdict",
        "k, mm",
        "sigma",
        "true k",
        "err, %",
        "delay ms",
        "F, N",
        "true F"
    );
    for world in worlds {
        for line in &world.lines {
            out.push_str(&line_text(line));
        }
    }
    out.push('\n');
    for world in worlds {
        out.push_str(&scores_text(&world.name, &world.scores()));
        if let Some(calibrated) = &world.calibration {
            out.push_str(&format!(
                "{:<8} torque factor {:.4} +- {:.2} % (true {:.4}, z {:.1}), cable {:.4} +- {:.4} rad/(N m) (true {:.4}, \
                 z {:.1})\n",
                "",
                calibrated.found.torque_factor,
                100.0 * calibrated.found.torque_factor_sigma,
                calibrated.true_torque_factor,
                calibrated.torque_factor_z(),
                calibrated.found.cable_rad_per_nm,
                calibrated.found.cable_sigma_rad_per_nm,
                calibrated.true_cable_rad_per_nm,
                calibrated.cable_z(),
            ));
        }
        if let Some(scale) = world.force_scale {
            out.push_str(&format!(
                "{:<8} forces by a scale {:.1} % of those with the scene's springs (true springs {:.1} %)\n",
                "",
                100.0 * scale,
                100.0 * world.true_springs
            ));
        }
    }
    out.push_str(&scores_text("all", &total(worlds)));
    out
}
