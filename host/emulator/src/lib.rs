// SPDX-License-Identifier: GPL-2.0-only
//! An STM32G431RB that runs the unmodified firmware image against a simulated finger.
//!
//! | module | what it does |
//! |---|---|
//! | [`cortex`] | the core: instructions, exceptions, interrupt controller, instruction counts |
//! | [`chip`] | one file per peripheral; an access that is not modelled is an error that names it |
//! | [`world`] | the plant at the pins |
//! | [`firmware`], [`rtt`], [`log`] | the image, the debug probe's ring buffers, decoded log lines |
//! | [`machine`] | all parts together, run in virtual time |
//! | [`sim`] | simulated grasps: object, script, verdict, trace |
//! | [`clients`] | standard tools: RTT over TCP, a port for GDB |
//!
//! Nothing here was checked against silicon. Time has the granularity of a straight run of instructions, and
//! [`time::CYCLES_PER_INSTRUCTION`] is assumed; instruction counts are exact.
#![forbid(unsafe_code)]

pub mod chip;
pub mod clients;
pub mod cortex;
pub mod firmware;
pub mod log;
pub mod machine;
pub mod rtt;
pub mod sim;
pub mod time;
pub mod world;

pub use chip::{Misuse, Quirks, ResetCause};
pub use firmware::Firmware;
pub use machine::{Machine, Pause, Setup};

use std::path::PathBuf;

/// Why an emulation cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be read.
    #[error("cannot read {}: {source}; is the path right?", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{}", palpate_cli::cannot_write(path, source))]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No such simulated world.
    #[error("{0}")]
    World(String),
    /// The call asks for what cannot be.
    #[error("{0}")]
    Call(String),
    /// Not a firmware image for this chip.
    #[error("{}: {why}", path.display())]
    Elf {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// The firmware did something whose result is not modelled.
    #[error("at {time_s:.6} s, {place}: {misuse}")]
    Misuse {
        /// What.
        misuse: Misuse,
        /// Where in the firmware.
        place: String,
        /// When.
        time_s: f64,
    },
    /// No function has this in its name.
    #[error("no function of the firmware has '{0}' in its name; `nm --demangle ELF` lists them")]
    NoFunction(String),
    /// A port for clients cannot be opened.
    #[error("cannot listen on port {port} of this machine: {source}; choose another")]
    Port {
        /// Which.
        port: u16,
        /// Why.
        source: std::io::Error,
    },
    /// A pair of terminals for the serial port cannot be opened.
    #[error("cannot open a terminal for the serial port: {0}; --rtt-port gives the log over TCP")]
    Serial(String),
    /// A trace cannot be written.
    #[error("cannot write the trace: {0}; is there room on the disk?")]
    Trace(std::io::Error),
    /// The simulated world refused its parameters.
    #[error("plant: {0}")]
    Plant(#[from] palpate_plant::Error),
}
