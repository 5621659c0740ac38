// SPDX-License-Identifier: GPL-2.0-only
//! `sim`: one run, its log, its summary.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use palpate_emulator::firmware::default_path;
use palpate_emulator::sim::{
    Calibration, Injected, Object, Script, Session, Settings, Step, Summary, Trace,
};
use palpate_emulator::{Error, Firmware, Setup};
use palpate_plant::{Engine, ObjectMount, Parameters, World};

use super::live::{Pace, Typed};
use super::output::{FOR_THE_PAGE, Form, Output};
use super::ports::Ports;

/// Options of `sim`.
#[derive(Args)]
pub struct Options {
    /// Firmware image
    #[arg(long, hide = true, default_value_os_t = default_path())]
    elf: PathBuf,
    /// Finger that the firmware was built for; `cargo xtask` takes the file of one as well
    #[arg(long, value_name = "NAME|FILE", default_value = "p70", value_parser = clap::builder::PossibleValuesParser::new(palpate_plant::scenes()))]
    scene: String,
    /// Place of the contact on its phalanx, from the joint, in millimetre
    #[arg(long, value_name = "MM", default_value_t = 30.0, value_parser = finite, allow_negative_numbers = true)]
    contact_mm: f64,
    /// Diameter of the cylinder in millimetre, up to 1000
    #[arg(long, value_name = "MM", default_value_t = 10.0, value_parser = diameter, allow_negative_numbers = true)]
    object_mm: f64,
    /// Phalanx that meets the object, from 1
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=3))]
    phalanx: u8,
    /// Object at the first phalanx
    #[arg(long, conflicts_with_all = ["free", "phalanx"])]
    proximal: bool,
    /// Close without an object
    #[arg(long, conflicts_with_all = ["contact_mm", "object_mm", "phalanx"])]
    free: bool,
    /// Angle of joint 1 at contact
    #[arg(long, value_name = "DEG", default_value_t = 45.0, value_parser = finite, allow_negative_numbers = true)]
    theta1_deg: f64,
    /// Seed of the simulated noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The simulated world: ideal, bench, workshop, harsh, or a TOML file [default: ideal]
    #[arg(long, value_name = "NAME|FILE", alias = "plant")]
    world: Option<String>,
    /// What computes finger and object: `plant`, or `mujoco` where the program was built with it (`cargo xtask` does)
    #[arg(long, value_name = "ENGINE")]
    engine: Option<Engine>,
    /// How the object is held: `fixed`, `spring` or `free`, the last with the engine mujoco [default: as the world has it]; mass and
    /// springs are the world's
    #[arg(long, value_name = "MOUNT")]
    mount: Option<ObjectMount>,
    /// Stiffness of springs that hold the object (and no pin), newton per millimetre, 0.001 to 10000; implies `--mount spring`
    #[arg(long, value_name = "N/MM", value_parser = stiffness, allow_negative_numbers = true)]
    object_n_per_mm: Option<f64>,
    /// Writes what was measured and what is true, a row a millisecond
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
    /// One JSON object a line: every event, what is true when the contact is judged, then the summary
    #[arg(long)]
    json: bool,
    /// Prints the summary alone
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Writes one page about the grasp, with pictures, that can be sent
    #[arg(long = "html", id = "html", value_name = "FILE.html", value_parser = palpate_cli::by_xtask)]
    _html: Option<PathBuf>,
    /// Writes the events as with --json, with the samples that the firmware then streams and its settings: what --html is made of
    #[arg(long, hide = true, value_name = "FILE")]
    events: Option<PathBuf>,
    /// Typed instead of pressing the button, separated by semicolons, each when the motion before it has ended
    #[arg(long, value_name = "COMMANDS")]
    commands: Option<String>,
    /// Records friction, calibrates on the closing stop and on a pin at each of these places of the last phalanx, 1 mm to its
    /// length, saves, then grasps; without --world, a finger whose hidden values are drawn from their spreads by the seed
    #[arg(long, value_name = "MM,MM", value_delimiter = ',', value_parser = finite, allow_negative_numbers = true, conflicts_with = "commands")]
    calibrate: Vec<f64>,
    /// File that keeps the flash: from one that exists, what the firmware has saved is taken, and the program is that of this run
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// Injects a fault: NAME or NAME@SECONDS. A fault ends the run, unless a `clear` is still among --commands
    #[arg(long, value_name = "NAME[@TIME_S]")]
    fault: Option<Injected>,
    /// Prints executed instructions of every interrupt, and the use of the stacks
    #[arg(long)]
    counts: bool,
    /// Counts the calls of every function with this in its name
    #[arg(long, value_name = "NAME", requires = "counts")]
    watch: Vec<String>,
    /// Counts apart the calls of watched functions in which none with this in its name runs
    #[arg(long, value_name = "NAME", requires = "watch")]
    apart: Vec<String>,
    /// Simulated seconds after which the run is given up
    #[arg(long, value_name = "S", default_value_t = 300.0, value_parser = positive, allow_negative_numbers = true)]
    max_s: f64,
    /// Goes on after the script and after faults, and takes command lines from standard input, until that ends
    #[arg(long)]
    keep_running: bool,
    /// Pace in multiples of real time; as fast as it goes without it
    #[arg(long, value_name = "TIMES", value_parser = positive, allow_negative_numbers = true)]
    speed: Option<f64>,
    /// Passes the log's bytes on over TCP, as a probe's RTT server does; for `defmt-print tcp`
    #[arg(long, value_name = "PORT")]
    rtt_port: Option<u16>,
    /// Lets GDB in: `target remote :PORT`
    #[arg(long, value_name = "PORT")]
    gdb_port: Option<u16>,
    /// Opens a terminal that is the board's serial port, and prints its name; the firmware's log goes there too
    #[arg(long)]
    serial: bool,
}

impl Options {
    fn form(&self) -> Form {
        if self.json {
            Form::Json
        } else if self.quiet {
            Form::Summary
        } else {
            Form::Text
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
        .ok_or_else(|| "a number is expected".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text)
        .ok()
        .filter(|&v| v > 0.0)
        .ok_or_else(|| "a number above zero is expected".to_owned())
}

fn between(text: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    finite(text)
        .ok()
        .filter(|v| (least..=most).contains(v))
        .ok_or_else(|| format!("{least} to {most} {unit} is expected"))
}

fn diameter(text: &str) -> Result<f64, String> {
    between(text, 0.001, 1000.0, "mm")
}

fn stiffness(text: &str) -> Result<f64, String> {
    between(text, 0.001, 10_000.0, "N/mm")
}

/// Reads the plant's parameters, or takes the defaults; for a calibration, values that are not the firmware's.
fn parameters(options: &Options) -> Result<Parameters, Error> {
    let Some(world) = &options.world else {
        let parameters = Parameters::of(&options.scene)?;
        return Ok(if options.calibrate.is_empty() {
            parameters
        } else {
            parameters.randomised(options.seed)
        });
    };
    Ok(World::named(world)
        .map_err(Error::World)?
        .of(&options.scene)?)
}

/// The user's script: what is known of the skin and of how the finger hangs, then the guided calibration, the commands, or the button.
fn script(options: &Options, parameters: &Parameters) -> Script {
    let mut script = match &options.commands {
        _ if !options.calibrate.is_empty() => Script::calibration(&options.calibrate),
        Some(commands) => Script::parse(commands),
        None => Script::button(),
    };
    let typed = |line: &str| Step::Command(line.to_owned());
    if let Some((deg, share)) = parameters.stated_mounting() {
        script
            .0
            .insert(0, typed(&format!("set weight {:.1}", 100.0 * share)));
        script.0.insert(0, typed(&format!("set mounting {deg}")));
    }
    if let Some(stated) = parameters.contact.stated() {
        let set = format!("set contact-friction {}", 100.0 * stated);
        script.0.insert(0, typed(&set));
    }
    if options.events.is_some() {
        script.0.splice(0..0, FOR_THE_PAGE.map(typed));
    }
    script
}

fn settings(options: &Options, firmware: &Firmware) -> Result<Settings, Error> {
    let mut parameters = parameters(options)?;
    if let Some(engine) = options.engine {
        parameters.engine = engine;
    }
    super::object::hold(
        &mut parameters.object,
        options.mount,
        options.object_n_per_mm,
    )?;
    let object = Object {
        phalanx: if options.proximal { 1 } else { options.phalanx },
        contact_mm: options.contact_mm,
        diameter_mm: options.object_mm,
        theta_1_deg: options.theta1_deg,
    };
    if !options.free {
        super::object::check(&object, &parameters)?;
    }
    super::object::check_pins(&options.calibrate, &parameters)?;
    Ok(Settings {
        script: script(options, &parameters),
        parameters,
        object: (!options.free).then_some(object),
        seed: options.seed,
        max_s: options.max_s,
        setup: Setup {
            watch: options.watch.clone(),
            apart: options.apart.clone(),
            flash: super::flash::left(options.flash.as_deref(), firmware)?,
            ..Setup::default()
        },
    })
}

/// Runs it.
pub fn run(options: &Options) -> Result<ExitCode, Error> {
    let firmware = Firmware::load(&options.elf)?;
    let settings = settings(options, &firmware)?;
    if let Some(path) = &options.flash {
        super::can_be_written(path)?;
    }
    let trace = match &options.trace {
        Some(path) => Some(Trace::create(path).map_err(|source| Error::Write {
            path: path.clone(),
            source,
        })?),
        None => None,
    };
    let start = Instant::now();
    let world = settings.parameters.clone();
    let mut output = Output::new(options.form(), options.events.as_deref())?;
    let mut ports = Ports::open(options.rtt_port, options.gdb_port, options.serial)?;
    let mut session = Session::start(&firmware, settings, trace)?;
    let mut pace = options.speed.map(Pace::new);
    let mut result = Ok(());
    let mut fault = options.fault;
    let mut typed = options.keep_running.then(Typed::listen);
    loop {
        // Whoever wants to go on after faults wants the rest of the script as well.
        let goes_on = match &typed {
            Some(typed) => typed.open() || !session.ended(),
            None => !session.over(),
        };
        if result.is_err() || !goes_on {
            break;
        }
        if !ports.serve(&mut session)? {
            // A debugger holds the core.
            std::thread::sleep(Duration::from_millis(1));
            if let Some(pace) = &mut pace {
                pace.restart(session.machine.time_s());
            }
            continue;
        }
        if let Some(typed) = &mut typed {
            typed.pass_on(&mut session);
        }
        if let Some(pace) = &mut pace {
            pace.keep(session.machine.time_s());
        }
        result = session.millisecond();
        if let Some(injected) = due(&mut fault, session.machine.time_s()) {
            result = result.and_then(|()| session.inject(injected.fault));
        }
        output.show(&mut session, start)?;
    }
    result = result.and(session.finish());
    output.show(&mut session, start)?;
    output.end_progress();
    result?;
    if options.counts {
        super::counts::print(&session.machine, options.json);
    }
    if let Some(path) = &options.flash {
        std::fs::write(path, session.machine.flash()).map_err(|source| Error::Write {
            path: path.clone(),
            source,
        })?;
    }
    let summary = Summary::of(&session);
    let calibration = Calibration::of(&session.lines, &world, &session.calibrated_with);
    let wall_s = start.elapsed().as_secs_f64();
    output.conclude(&summary, calibration.as_ref(), &world, wall_s)?;
    super::ending::tell(&session, fault, options.max_s);
    let fine = fault.is_none()
        && session.completed()
        && session.faults.is_empty()
        && session.refused.is_empty()
        && session.resets.is_empty();
    Ok(if fine {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// The fault, once, when it is due.
fn due(fault: &mut Option<Injected>, time_s: f64) -> Option<Injected> {
    fault.take_if(|fault| fault.at_s <= time_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Call {
        #[command(flatten)]
        options: Options,
    }

    /// A refusal would end a run of the user's badly.
    #[test]
    fn what_is_stated_of_a_world_is_in_the_range_of_its_settings() {
        for scene in palpate_plant::scenes() {
            for world in palpate_plant::world_names() {
                let call = Call::try_parse_from(["sim", "--scene", &scene, "--world", world]);
                let options = call.unwrap_or_else(|error| panic!("{error}")).options;
                let script = script(&options, &parameters(&options).expect("a world"));
                let (last, stated) = script.0.split_last().expect("a button");
                assert_eq!(*last, Step::Button);
                for step in stated {
                    assert!(step.sets().is_some(), "{scene} in {world}: {step}");
                }
            }
        }
    }
}
