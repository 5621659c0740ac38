//! What a user types, over RTT or the serial port: one line, one command, one answer.

use core::fmt;

use super::settings::{Range, Setting};
use super::text::{Plain, number, same};
use crate::name_list::nth;

/// Longest line that is understood, bytes, without its end.
pub const LINE_MAX: usize = 64;

/// A command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// List the commands.
    Help,
    /// Report state, position, current, supply, temperature, faults.
    Status,
    /// Check wiring and motor, step by step.
    SelfTest,
    /// Measure the motor.
    Identify,
    /// A whole grasp: what is missing of offset, homing and friction record, then close, probe, hold, open.
    Run,
    /// Open against the stop and make that the zero of the encoder.
    Home,
    /// Record friction on a free closing and opening.
    RecordFriction,
    /// Calibrate at a known contact.
    Calibrate(Calibrate),
    /// Close until contact, probe, hold.
    Close,
    /// Open.
    Open,
    /// Bridge off, now, in any state.
    Stop,
    /// Clear a fault whose cause is gone.
    Clear,
    /// Print all settings.
    Show,
    /// Change a setting, value in SI units, within its range.
    Set(Setting, f32),
    /// Stream every so many samples to the log; 0 for none.
    Trace(u16),
    /// Write settings, friction record and calibration to flash.
    Save,
    /// Forget everything that was saved.
    Factory,
}

/// Where the contact of a calibration is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Calibrate {
    /// A pin at this distance from the joint of the distal phalanx, metre.
    At {
        /// Distance, metre.
        k_m: f32,
    },
    /// The closing stop: the cable's stiffness alone.
    Cable,
    /// Forget the places collected so far and the calibration.
    Forget,
}

/// The nearest place to its joint that a pin may have, millimetre.
pub const NEAREST_PIN_MM: f32 = 1.0;

/// The places a pin may have: on the last phalanx of the finger that this firmware moves; on that of any finger in programs of a PC.
const PLACE: Range = Range {
    unit_si: 1e-3,
    min: NEAREST_PIN_MM,
    max: if let Some(length_mm) = option_env!("PALPATE_LAST_PHALANX_MM") {
        whole(length_mm)
    } else {
        500.0
    },
};

/// The number that these digits are.
const fn whole(digits: &str) -> f32 {
    let mut digits = digits.as_bytes();
    let mut number = 0.0;
    while let Some((digit, rest)) = digits.split_first() {
        number = 10.0 * number + (*digit - b'0') as f32;
        digits = rest;
    }
    number
}

/// Declares the verbs once: the enum and what `help` prints come from the same lines.
macro_rules! verbs {
    ($($verb:ident $name:literal $usage:literal, $summary:literal;)*) => {
        /// What a command begins with.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Verb {
            $(#[doc = $summary] $verb,)*
        }

        impl Verb {
            /// Every verb, in the order of the enum.
            pub const ALL: &[Self] = &[$(Self::$verb,)*];

            /// What a user types.
            pub fn name(self) -> &'static str {
                nth(concat!($($name, "\n",)*), self as u8)
            }

            /// What follows it; empty where nothing does.
            pub fn usage(self) -> &'static str {
                nth(concat!($($usage, "\n",)*), self as u8)
            }

            /// What it does.
            pub fn summary(self) -> &'static str {
                nth(concat!($($summary, "\n",)*), self as u8)
            }
        }
    };
}

verbs! {
    Help "help" "", "list commands";
    Status "status" "", "state, position, current, supply, temperature, fault";
    SelfTest "selftest" "",
        "check wiring, sensors, motor; moves slightly";
    Identify "identify" "",
        "measure motor constants, inertia and friction";
    Run "run" "", "home, close, probe, hold, open";
    Home "home" "", "open to the stop, the zero";
    RecordFriction "record-friction" "",
        "record friction: remove objects first";
    Calibrate "calibrate" "MM | cable | forget",
        "press on a pin or the closing stop";
    Close "close" "", "close until contact, probe, hold";
    Open "open" "", "open to rest";
    Stop "stop" "", "bridge off at once";
    Clear "clear" "", "clear a fault whose cause is gone";
    Show "show" "", "print settings";
    Set "set" "NAME VALUE", "change a setting; `show` lists them";
    Trace "trace" "on [N] | off", "log every sample (1 kHz) or Nth";
    Save "save" "", "keep settings, friction, calibration";
    Factory "factory" "", "forget what was saved";
}

/// What is wrong with a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommandError {
    /// Longer than [`LINE_MAX`], or with a byte that no text has.
    NotALine,
    /// No such command.
    Unknown,
    /// Something follows a command that takes nothing, or too much follows it.
    Unexpected {
        /// Usage of the command.
        usage: &'static str,
    },
    /// Something is missing or is not a number.
    Expected {
        /// What was expected.
        what: &'static str,
    },
    /// No such setting.
    UnknownSetting,
    /// A value outside its range.
    Range {
        /// The setting.
        setting: Setting,
    },
    /// A place outside what a finger has.
    Place,
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotALine => f.write_str("expected a text of at most 64 bytes"),
            Self::Unknown => f.write_str("no such command; try help"),
            Self::Unexpected { usage: "" } => f.write_str("this command takes nothing"),
            Self::Unexpected { usage } => write!(f, "too many words; expected {}", Plain(usage)),
            Self::Expected { what } => write!(f, "expected {}", Plain(what)),
            Self::UnknownSetting => f.write_str("no such setting; try show"),
            Self::Range { setting } => write!(
                f,
                "{} must be {} {}",
                Plain(setting.name()),
                setting.range(),
                Plain(setting.unit())
            ),
            Self::Place => write!(f, "the place must be {PLACE} mm from the joint"),
        }
    }
}

/// The words of a line that are still to be read, and the blanks between them.
struct Words<'l>(&'l [u8]);

impl<'l> Words<'l> {
    fn next(&mut self) -> Option<&'l [u8]> {
        let rest = self.0.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = rest.split_at_checked(end.unwrap_or(rest.len()))?;
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }
}

impl Command {
    /// Reads a line. Words are separated by blanks; case does not matter but for a unit joined to its number; an empty line is no command.
    ///
    /// # Errors
    /// What was expected instead.
    pub fn parse(line: &[u8]) -> Result<Option<Self>, CommandError> {
        // From 0xF8 on, no byte is valid UTF-8: noise, or another speed.
        if line.len() > LINE_MAX || line.iter().any(|byte| *byte >= 0xF8) {
            return Err(CommandError::NotALine);
        }
        let mut words = Words(line);
        let Some(name) = words.next() else {
            return Ok(None);
        };
        let verb = Verb::ALL.iter().find(|verb| same(name, verb.name()));
        let verb = verb.ok_or(CommandError::Unknown)?;
        let command = verb.read(&mut words)?;
        // A stop with words behind it is still a stop.
        if *verb != Verb::Stop && words.next().is_some() {
            let usage = verb.usage();
            return Err(CommandError::Unexpected { usage });
        }
        Ok(Some(command))
    }
}

impl Verb {
    /// The command, with what follows its first word.
    fn read(self, words: &mut Words<'_>) -> Result<Command, CommandError> {
        Ok(match self {
            Self::Help => Command::Help,
            Self::Status => Command::Status,
            Self::SelfTest => Command::SelfTest,
            Self::Identify => Command::Identify,
            Self::Run => Command::Run,
            Self::Home => Command::Home,
            Self::RecordFriction => Command::RecordFriction,
            Self::Calibrate => Command::Calibrate(calibrate(words)?),
            Self::Close => Command::Close,
            Self::Open => Command::Open,
            Self::Stop => Command::Stop,
            Self::Clear => Command::Clear,
            Self::Show => Command::Show,
            Self::Set => set(words)?,
            Self::Trace => trace(words)?,
            Self::Save => Command::Save,
            Self::Factory => Command::Factory,
        })
    }
}

fn calibrate(words: &mut Words<'_>) -> Result<Calibrate, CommandError> {
    const EXPECTED: CommandError = CommandError::Expected {
        what: "a place in mm, cable or forget",
    };
    let word = words.next().ok_or(EXPECTED)?;
    if same(word, "cable") {
        return Ok(Calibrate::Cable);
    }
    if same(word, "forget") {
        return Ok(Calibrate::Forget);
    }
    let k_mm = with_unit(word, "mm", words).ok_or(EXPECTED)?;
    let k_m = PLACE.to_si(k_mm).ok_or(CommandError::Place)?;
    Ok(Calibrate::At { k_m })
}

/// Samples that may lie between two that are streamed: one a second.
const MOST_SAMPLES: f32 = 1000.0;

fn trace(words: &mut Words<'_>) -> Result<Command, CommandError> {
    const EXPECTED: CommandError = CommandError::Expected {
        what: "on, on N with 1 to 1000, or off",
    };
    let word = words.next().ok_or(EXPECTED)?;
    if same(word, "off") {
        return Ok(Command::Trace(0));
    }
    if !same(word, "on") {
        return Err(EXPECTED);
    }
    let every = match words.next() {
        Some(word) => number(word).ok_or(EXPECTED)?,
        None => 1.0,
    };
    let whole = every as u16;
    if (1.0..=MOST_SAMPLES).contains(&every) && f32::from(whole) == every {
        Ok(Command::Trace(whole))
    } else {
        Err(EXPECTED)
    }
}

fn set(words: &mut Words<'_>) -> Result<Command, CommandError> {
    let name = words
        .next()
        .ok_or(CommandError::Expected { what: "NAME VALUE" })?;
    let setting = Setting::by_name(name).ok_or(CommandError::UnknownSetting)?;
    let value = words
        .next()
        .and_then(|word| with_unit(word, setting.unit(), words))
        .ok_or(CommandError::Expected {
            what: "a number after the name",
        })?;
    let value_si = setting.range().to_si(value);
    Ok(Command::Set(
        setting,
        value_si.ok_or(CommandError::Range { setting })?,
    ))
}

/// A number, with its unit joined to it, behind it, or left out.
fn with_unit(word: &[u8], unit: &str, rest: &mut Words<'_>) -> Option<f32> {
    if let Some(bare) = word.strip_suffix(unit.as_bytes()) {
        return number(bare);
    }
    let value = number(word)?;
    rest.next()
        .is_none_or(|behind| same(behind, unit))
        .then_some(value)
}

#[cfg(test)]
mod tests;
