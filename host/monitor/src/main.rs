//! `palpate-monitor`: the live view, and recording without it.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Args, Parser};
use palpate_monitor::ending::Ending;
use palpate_monitor::losses::Losses;
use palpate_monitor::page::GraspPage;
use palpate_monitor::recording::Recording;
use palpate_monitor::scenes;
use palpate_monitor::source::{Failure, From, Source};
use palpate_monitor::stream::Message;
use palpate_monitor::watch::Watch;

/// A live view of a finger, and recordings of it
#[derive(Parser)]
#[command(name = "palpate-monitor", bin_name = "cargo xtask", version)]
enum Command {
    /// Show the finger in the terminal
    #[command(
        name = "monitor",
        alias = "watch",
        after_help = "Examples:\n  cargo xtask monitor\n  cargo xtask monitor --from /dev/ttyACM0\n  cargo xtask monitor --from grasp.csv --speed 2"
    )]
    Watch(WatchOptions),
    /// Write samples to a file that `cargo xtask replay` reads
    #[command(
        after_help = "Examples:\n  cargo xtask record grasp.csv\n  cargo xtask record grasp.csv --from /dev/ttyACM0 --seconds 60"
    )]
    Record(RecordOptions),
    /// Write a page about a grasp from the lines that it left
    #[command(
        override_usage = "palpate-monitor page <LINES> --out <FILE.html>",
        after_help = "Examples:\n  cargo xtask sim --html grasp.html\n  palpate-monitor page grasp.jsonl --out grasp.html"
    )]
    Page(PageOptions),
    /// Print the completions of a shell
    #[command(hide = true)]
    Completions {
        /// Shell
        shell: palpate_cli::Shell,
    },
}

#[derive(Args)]
struct SourceOptions {
    /// `sim` or `emulator` (the firmware on the emulated chip), `probe` (a board, by probe-rs as a library), `tcp:HOST:PORT` (a
    /// server of RTT), a serial port, a recording, or a file of log lines
    #[arg(
        long,
        default_value = "sim",
        value_name = "sim|probe|tcp:HOST:PORT|PORT|FILE"
    )]
    from: String,
    /// Finger whose firmware `cargo xtask` builds; it is drawn until the firmware names its own
    #[arg(long, value_name = "NAME|FILE")]
    scene: Option<String>,
    /// Pace of a simulation or a file, in multiples of real time; 0: as fast as possible
    #[arg(long, default_value_t = 1.0, value_name = "TIMES", value_parser = pace)]
    speed: f64,
    /// The emulator's program
    #[arg(long, hide = true, value_name = "PATH")]
    emulator: Option<PathBuf>,
    /// The firmware's image
    #[arg(long, hide = true, value_name = "PATH")]
    elf: Option<PathBuf>,
    /// Simulated world, as `sim` takes it
    #[arg(long, value_name = "NAME|FILE")]
    world: Option<String>,
    /// What computes finger and object of the world, as `sim` takes it
    #[arg(long, value_name = "plant|mujoco")]
    engine: Option<String>,
    /// Further options for the emulator, as `sim` takes them (after `--`)
    #[arg(last = true)]
    options: Vec<String>,
}

#[derive(Args)]
struct WatchOptions {
    #[command(flatten)]
    source: SourceOptions,
    /// Use no colours (also with the variable NO_COLOR)
    #[arg(long)]
    no_colour: bool,
    /// Fails in the middle of a frame, for the test that the terminal comes back
    #[arg(long, hide = true)]
    fail: bool,
}

#[derive(Args)]
struct RecordOptions {
    /// File to write
    file: PathBuf,
    #[command(flatten)]
    source: SourceOptions,
    /// Ends after so many seconds of the recording; without it with the motion, when the firmware refuses to move, or with the source
    #[arg(long, value_name = "S", value_parser = pace)]
    seconds: Option<f64>,
    /// Writes over a recording that is there
    #[arg(long)]
    force: bool,
    /// Command lines to send first, separated by semicolons [default: trace on;run, over a serial port trace on 5;run]
    #[arg(long, value_name = "COMMANDS")]
    commands: Option<String>,
}

#[derive(Args)]
struct PageOptions {
    /// Lines of `sim --json` or of the log
    lines: PathBuf,
    /// Page to write
    #[arg(long, value_name = "FILE.html")]
    out: PathBuf,
    /// Its title
    #[arg(long, default_value = "A grasp")]
    title: String,
}

fn pace(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && *value >= 0.0)
        .ok_or_else(|| "a number from 0 on is expected".to_owned())
}

impl SourceOptions {
    fn from(&self) -> Result<From, String> {
        let image = || {
            let missing = "name the firmware's image with --elf; `cargo xtask monitor` builds it";
            self.elf.clone().ok_or_else(|| missing.to_owned())
        };
        Ok(match self.from.as_str() {
            "sim" | "emulator" => From::Program {
                call: self.emulation(),
                remedy: "`cargo xtask monitor` builds it",
            },
            #[cfg(feature = "probe")]
            "probe" => From::Probe { elf: image()? },
            #[cfg(not(feature = "probe"))]
            "probe" => {
                return Err(
                    "this program was built without its feature `probe`; `cargo xtask monitor --from probe` builds it with"
                        .to_owned(),
                );
            }
            name if is_port(name) => From::Port {
                name: name.to_owned(),
                elf: self.elf.clone(),
            },
            other => match other.strip_prefix("tcp:") {
                Some(address) => From::Tcp {
                    address: address.to_owned(),
                    elf: image()?,
                },
                None => From::File(other.into()),
            },
        })
    }

    fn emulation(&self) -> Vec<String> {
        let program = self
            .emulator
            .as_ref()
            .map_or("palpate-emulator".to_owned(), |path| {
                path.display().to_string()
            });
        let mut call: Vec<String> = [program.as_str(), "sim", "--json", "--keep-running"]
            .map(str::to_owned)
            .to_vec();
        call.extend(["--commands".to_owned(), "status".to_owned()]);
        if self.speed > 0.0 {
            call.push(format!("--speed={}", self.speed));
        }
        if let Some(elf) = &self.elf {
            call.push(format!("--elf={}", elf.display()));
        }
        for (name, value) in [
            ("scene", &self.scene),
            ("world", &self.world),
            ("engine", &self.engine),
        ] {
            if let Some(value) = value {
                call.push(format!("--{name}={value}"));
            }
        }
        call.extend(self.options.iter().cloned());
        call
    }

    fn open(&self) -> Result<Source, String> {
        Source::open(&self.from()?, self.speed).map_err(|error: Failure| error.to_string())
    }

    /// What has samples streamed: over a serial port every fifth, as many as 115200 baud carry.
    fn trace(&self) -> &'static str {
        if is_port(&self.from) {
            "trace on 5"
        } else {
            "trace on"
        }
    }
}

/// Whether a source is a serial port by its name.
fn is_port(name: &str) -> bool {
    name.starts_with("/dev/") || name.starts_with("COM")
}

fn watch(options: &WatchOptions) -> Result<(), String> {
    if !std::io::stdout().is_terminal() {
        return Err("the monitor needs a terminal; `record` works without one".to_owned());
    }
    let source = options.source.open()?;
    let colour = !options.no_colour && std::env::var_os("NO_COLOR").is_none();
    let mut watch = Watch::new(
        source,
        options.source.scene.as_deref(),
        scenes::finger,
        colour,
        options.source.trace(),
    );
    // Restores the terminal on every way out, a panic included.
    let run = |terminal: &mut ratatui::DefaultTerminal| {
        if options.fail {
            terminal.draw(|_| panic!("as asked for"))?;
        }
        watch.run(terminal)
    };
    ratatui::run(run).map_err(|error| error.to_string())
}

fn record(options: &RecordOptions) -> Result<(), String> {
    if options.file.exists() && !options.force {
        let file = options.file.display();
        return Err(format!(
            "{file} is there already: name another file, or write over it with --force"
        ));
    }
    let source = options.source.open()?;
    let cannot = |error: std::io::Error| palpate_cli::cannot_write(&options.file, &error);
    let mut recording = Recording::create(&options.file).map_err(cannot)?;
    let usual = format!("{};run", options.source.trace());
    let commands = options.commands.as_deref().unwrap_or(&usual);
    let mut asked = false;
    for line in commands.split(';').map(str::trim) {
        if !line.is_empty() {
            asked |= source.command(line);
        }
    }
    let mut ending = Ending::new(options.seconds, asked);
    let (mut losses, mut shown) = (Losses::default(), Instant::now());
    let terminal = std::io::stderr().is_terminal();
    let mut is_over = false;
    while let Some(message) = source.next(ending.patience()) {
        recording.take(&message).map_err(cannot)?;
        match message {
            Message::Sample(sample) => {
                losses.sample();
                let since_s = ending.sample(sample.time_s);
                if ending.over(sample.time_s) {
                    is_over = true;
                    break;
                }
                if terminal && shown.elapsed() > Duration::from_millis(200) {
                    eprint!("\r\x1b[K{since_s:.1} s, {} samples", recording.rows());
                    // A terminal that cannot be flushed shows the line a little later.
                    let _ = std::io::stderr().flush();
                    shown = Instant::now();
                }
            }
            Message::Event(event) => {
                losses.event(&event);
                if terminal {
                    eprint!("\r\x1b[K");
                }
                eprintln!("{:10.3} {}", event.time_s.unwrap_or_default(), event.text());
                ending.event(&event);
            }
            Message::Note(text) => eprintln!("{text}"),
            Message::Truth { .. } => {}
        }
    }
    let rows = recording.finish().map_err(cannot)?;
    if rows == 0 {
        // Nothing is left that looks like a recording; one that cannot be removed has its head alone.
        let _ = std::fs::remove_file(&options.file);
        return Err(
            "no sample came, so no file is left: what the source said stands above; the firmware streams samples after `trace on`"
                .to_owned(),
        );
    }
    if let Some(warning) = losses.warning() {
        eprintln!("warning: {warning}");
    }
    println!("{rows} samples in {}", options.file.display());
    match (ending.refused(), ending.fault()) {
        (Some(answer), _) => Err(format!("nothing moved, the firmware answered: {answer}")),
        (None, Some(fault)) => Err(format!("a fault ended the motion: {fault}")),
        // Nothing said that this was all.
        _ if !is_over && ending.patience().is_none() => Err(
            "the source ended before the recording was over: the file has what came before"
                .to_owned(),
        ),
        (None, None) => Ok(()),
    }
}

fn page(options: &PageOptions) -> Result<(), String> {
    let from = From::File(options.lines.clone());
    let source = Source::open(&from, 0.0).map_err(|error| error.to_string())?;
    let mut page = GraspPage::default();
    while let Ok(message) = source.messages.recv() {
        page.take(message);
    }
    let finger = page.scene().and_then(scenes::finger);
    std::fs::write(&options.out, page.html(&options.title, finger))
        .map_err(|error| palpate_cli::cannot_write(&options.out, &error))?;
    println!("{}", options.out.display());
    Ok(())
}

fn main() -> ExitCode {
    let outcome = match Command::parse() {
        Command::Watch(options) => watch(&options),
        Command::Record(options) => record(&options),
        Command::Page(options) => page(&options),
        Command::Completions { shell } => {
            palpate_cli::complete::<Command>(shell);
            Ok(())
        }
    };
    palpate_cli::end(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_is_that_of_xtask() {
        for (command, usage) in [
            ("watch", "Usage: cargo xtask monitor [OPTIONS]"),
            ("record", "Usage: cargo xtask record [OPTIONS] <FILE>"),
        ] {
            let told = Command::try_parse_from(["palpate-monitor", command, "--help"]);
            let told = told.err().map(|help| help.to_string()).unwrap_or_default();
            assert!(told.contains(usage), "{told}");
        }
    }

    #[test]
    fn every_command_has_examples_in_its_help() {
        assert_eq!(palpate_cli::without_example::<Command>(), [""; 0]);
    }
}
