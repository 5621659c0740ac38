//! `replay`: the sensing on a recording.

mod page;
mod teaching;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Args;
use palpate::sample::{Drive, Sample};
use palpate::sensing::{Calibration, Directive, Event};
use palpate_evaluation::replay::{self, Comparison, Preparation, Replayer, Source};
use palpate_evaluation::trace::Streamed;
use palpate_evaluation::{recordings, trace};
use serde_json::{Value, json};

use crate::scene;
use teaching::Teaching;

/// Of the command line.
#[derive(Args)]
pub struct Options {
    /// CSV (or CSV.gz) with columns time_s, encoder_counts, current_a (signed, or with a column duty for its sign).
    file: PathBuf,
    /// The finger of the recording: one of scenes/*.toml, by name or file.
    #[arg(long, default_value = palpate_scenes::NAMES[0], value_parser = scene::named)]
    scene: String,
    /// Recording of a free closing and opening, instead of one searched in FILE.
    #[arg(long)]
    friction: Option<PathBuf>,
    /// Recording that calibrates first: of a press against the closing stop, or FILE@MM of a pin at MM of the last phalanx.
    /// May be given several times; they are used in that order.
    #[arg(long, value_name = "FILE[@MM]")]
    calibrate: Vec<Teaching>,
    /// Encoder count at the opening stop.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    zero_counts: i64,
    /// Voltage at the motor at a duty of 1, volt, 1 to 60, where FILE has a column duty that is a share of the supply: the back-EMF that
    /// follows tells the torque constant of a finger that no pin has calibrated.
    #[arg(long, value_name = "V", value_parser = volt)]
    supply_v: Option<f64>,
    /// One JSON object a line instead of text.
    #[arg(long)]
    json: bool,
    /// Write one page about the grasp, with pictures, that can be sent.
    #[arg(long = "html", id = "html", value_name = "FILE.html", value_parser = palpate_cli::by_xtask)]
    _html: Option<PathBuf>,
    /// Write events and samples as JSON lines: what --html is made of.
    #[arg(long, hide = true, value_name = "FILE")]
    events: Option<PathBuf>,
}

/// A supply's voltage.
fn volt(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|volt| (1.0..=60.0).contains(volt))
        .ok_or_else(|| format!("'{text}' is no voltage of a supply in volt, 1 to 60"))
}

/// Samples of a recording; what was odd about it goes to standard error, or is printed as JSON.
fn samples(
    file: &Path,
    sensing: &Replayer,
    options: &Options,
) -> Result<Vec<Sample>, Box<dyn Error>> {
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let (rows, findings) = trace::read(recordings::open(file)?).map_err(|error| named(&error))?;
    let mut resampled = trace::resample(&rows, options.zero_counts);
    if let Some(supply_v) = options.supply_v {
        let ohm = f64::from(sensing.motor_ohm);
        trace::back_emf_from_duty(
            &mut resampled.samples,
            &rows,
            trace::Supply { supply_v, ohm },
        );
    }
    if options.json {
        let gaps: Vec<_> = resampled
            .gaps
            .iter()
            .map(|gap| [gap.from_s, gap.to_s])
            .collect();
        println!(
            "{}",
            json!({
                "type": "recording", "file": file.display().to_string(), "rows": findings.rows,
                "repeated": findings.repeated, "backward": findings.backward,
                "sign_from_duty": findings.sign_from_duty, "interval_s": resampled.interval_s,
                "interpolated": resampled.interpolated, "gaps_s": gaps, "cut_at_s": resampled.cut_at_s,
                "samples": resampled.samples.len(),
            })
        );
    } else {
        println!(
            "recording rows={} repeated={} backward={} sign_from_duty={} interval_ms={:.3} interpolated={} gaps={} \
             samples={}",
            findings.rows,
            findings.repeated,
            findings.backward,
            findings.sign_from_duty,
            1e3 * resampled.interval_s,
            resampled.interpolated,
            resampled.gaps.len(),
            resampled.samples.len(),
        );
        for gap in &resampled.gaps {
            println!("gap from_s={:.4} to_s={:.4}", gap.from_s, gap.to_s);
        }
        if let Some(cut_at_s) = resampled.cut_at_s {
            println!("cut at_s={cut_at_s}");
        }
    }
    if resampled.samples.is_empty() {
        return Err(named(&"the rows are too far apart: no two within 0.2 s").into());
    }
    Ok(resampled.samples)
}

fn tell(found: &replay::Replay, recorded: &[Sample], options: &Options) {
    let second = |index: usize| recorded.get(index).map_or(0.0, |s| s.time_us as f64 * 1e-6);
    let (source, stretch, why) = match &found.friction {
        Source::Live => ("live", None, None),
        Source::Separate => ("file", None, None),
        Source::Within(at) => (
            "free-closing",
            Some([second(at.from), second(at.to - 1)]),
            None,
        ),
        Source::None(why) => ("none", None, Some(why.to_string())),
    };
    if options.json {
        println!(
            "{}",
            json!({"type": "friction", "source": source, "stretch_s": stretch, "why": why})
        );
    } else {
        let at = stretch.map_or_else(String::new, |[a, b]| format!(" from_s={a:.3} to_s={b:.3}"));
        println!("friction source={source}{at}");
    }
    for (time_us, fields) in found.lines() {
        let time_s = time_us as f64 * 1e-6;
        if options.json {
            println!("{}", event_json(fields, time_s));
        } else {
            println!("{time_s:10.3} {}", replay::line(&fields));
        }
    }
}

fn event_json((name, mut fields): replay::Fields, time_s: f64) -> Value {
    fields.insert("type".into(), json!("event"));
    fields.insert("name".into(), json!(name));
    fields.insert("t_s".into(), json!(time_s));
    Value::Object(fields)
}

/// What was said live against what was said again, where the recording tells.
fn tell_comparison(compared: &Comparison, options: &Options) {
    let equal = compared.differences.is_empty();
    if options.json {
        println!(
            "{}",
            json!({"type": "live", "events": compared.live, "equal": equal, "differences": compared.differences})
        );
    } else {
        println!("live events={} equal={equal}", compared.live);
    }
    for difference in &compared.differences {
        eprintln!("{difference}");
    }
    if !equal {
        eprintln!(
            "the events differ from the live ones: was this scene's firmware recorded (--scene), by this version, from \
             before its first motion since the last start or `set`?"
        );
    }
}

/// The recording as the firmware streamed it, where it did and nothing else is to be assumed.
fn streamed(options: &Options) -> Result<Option<Vec<Streamed>>, Box<dyn Error>> {
    if options.friction.is_some() || !options.calibrate.is_empty() || options.zero_counts != 0 {
        return Ok(None);
    }
    let file = &options.file;
    let stream = trace::stream(recordings::open(file)?);
    Ok(stream.map_err(|error| format!("{}: {error}", file.display()))?)
}

/// The recording of friction that the user names, up to the end of its last opening: a closing behind it would begin another record, and
/// leave that unfinished.
fn friction(sensing: &Replayer, options: &Options) -> Result<Option<Vec<Sample>>, Box<dyn Error>> {
    let Some(file) = &options.friction else {
        return Ok(None);
    };
    let mut record = samples(file, sensing, options)?;
    let closes = |sample: &Sample| sample.drive == Drive::Closing;
    let last_opening = record
        .iter()
        .rposition(|sample| sample.drive == Drive::Opening);
    let opened = last_opening.filter(|at| record[..*at].iter().any(closes));
    let Some(opened) = opened else {
        return Err(format!(
            "--friction {}: no opening after a closing is in it, and friction is recorded both ways",
            file.display()
        )
        .into());
    };
    if let Some(further) = record[opened..].iter().position(closes) {
        record.truncate(opened + further);
    }
    Ok(Some(record))
}

/// Why nothing could be judged for want of friction.
fn without_friction(found: &replay::Replay, options: &Options) -> Option<String> {
    let Source::None(why) = &found.friction else {
        return None;
    };
    let remedy = match &options.friction {
        Some(file) => format!("--friction {} does not help", file.display()),
        None => "a recording of a free closing and opening can be given with --friction".to_owned(),
    };
    Some(format!(
        "friction was not recorded, so contacts cannot be told from it: {why}; {remedy}"
    ))
}

/// Replays a recording that calibrates: the calibration after it, and why it taught nothing.
fn learn(
    teaching: &Teaching,
    sensing: &Replayer,
    calibration: Calibration,
    record: Option<&[Sample]>,
    options: &Options,
) -> Result<(Calibration, Option<String>), Box<dyn Error>> {
    let recorded = samples(&teaching.file, sensing, options)?;
    let purpose = match teaching.pin_m() {
        Some(k_m) => Directive::Calibrate {
            phalanx: sensing.phalanges,
            k_m,
        },
        None => Directive::CalibrateCable,
    };
    let before = Preparation {
        // A recording that calibrates holds its own free motion, or else that of --friction serves.
        friction: None,
        calibration,
    };
    let mut found = (sensing.replay)(&recorded, &before, purpose);
    if matches!(found.friction, Source::None(_)) && record.is_some() {
        let before = Preparation {
            friction: record,
            calibration,
        };
        found = (sensing.replay)(&recorded, &before, purpose);
    }
    tell(&found, &recorded, options);
    let mut told = found.told.iter();
    let taught = told.any(|told| matches!(told.event, Event::Calibrated { .. }));
    let failed = (!taught).then(|| {
        let why = without_friction(&found, options);
        let why = why.map_or_else(String::new, |why| format!(": {why}"));
        format!("--calibrate {teaching}: nothing was learned from it{why}")
    });
    Ok((found.calibration, failed))
}

/// Replays what calibrates, in its order, then the recording.
fn all(sensing: &Replayer, options: &Options) -> Result<(), Box<dyn Error>> {
    if let Some(stream) = streamed(options)? {
        let recorded: Vec<Sample> = (stream.iter().map(|row| row.sample.with_joint(()))).collect();
        let (found, compared) = (sensing.again)(&stream);
        tell(&found, &recorded, options);
        tell_comparison(&compared, options);
        return page::leave(&found, &recorded, options);
    }
    let record = friction(sensing, options)?;
    let mut calibration = sensing.uncalibrated;
    let mut failed = Vec::new();
    for teaching in &options.calibrate {
        let learned = learn(teaching, sensing, calibration, record.as_deref(), options)?;
        calibration = learned.0;
        failed.extend(learned.1);
    }
    let recorded = samples(&options.file, sensing, options)?;
    let before = Preparation {
        friction: record.as_deref(),
        calibration,
    };
    let found = (sensing.replay)(&recorded, &before, Directive::Watch);
    tell(&found, &recorded, options);
    let mut told = found.told.iter();
    let touched = told.any(|told| matches!(told.event, Event::Touch { .. }));
    if options.calibrate.is_empty() && touched {
        eprintln!(
            "{}: the file does not say which closings calibrate: a press on the closing stop or on a pin is told as a contact like any \
             other; `cargo xtask record` writes recordings that say it, and --calibrate FILE[@MM] takes what calibrates from a file of its \
             own",
            options.file.display()
        );
    }
    page::leave(&found, &recorded, options)?;
    let unjudged = without_friction(&found, options);
    failed.extend(unjudged.map(|why| format!("{}: {why}", options.file.display())));
    if failed.is_empty() {
        return Ok(());
    }
    Err(failed.join("\nerror: ").into())
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read or written, a place that no pin has; a recording that cannot be judged or taught nothing, once all that could
/// be told is told.
pub fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    teaching::check(&options.calibrate, &options.scene)?;
    all(
        &Replayer::of(&options.scene).ok_or("no such scene")?,
        options,
    )
}
