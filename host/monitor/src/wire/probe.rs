//! A debug probe, by probe-rs as a library: the same RTT channels that `probe-rs run` reads, without a program between.
//!
//! It attaches to the firmware that runs, does not reset it, and goes on after a reset of the chip. To attach, probe-rs halts the core for
//! some milliseconds, in which a motor that turns ends in the fault `encoder-jump`.

use std::fmt::Display;
use std::io::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::Duration;

use palpate_image::Image;
use probe_rs::probe::list::Lister;
use probe_rs::rtt::{
    Error as RttError, Rtt, ScanRegion, find_rtt_control_block_in_raw_file, try_attach_to_rtt,
};
use probe_rs::{MemoryInterface, Permissions, Session};

use super::Wire;

/// The chip as probe-rs knows it.
const CHIP: &str = "STM32G431RBTx";
/// Where a chip of this family tells what it is (DBGMCU_IDCODE), and the number of a G431 or G441 (RM0440, 47.6.1).
const IDENTITY: u64 = 0xE004_2000;
const DEVICE: u32 = 0x468;
/// The number's bits; above them is the revision.
const DEVICE_BITS: u32 = 0xFFF;
/// A firmware that has just started has set up its log by then.
const STARTED: Duration = Duration::from_secs(1);

/// Why a probe gives no log, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Nothing is connected, or nothing that this user may see.
    #[error(
        "no debug probe is connected: connect the board's ST-LINK by USB; where it is, this user may not see it \
         (https://probe.rs/docs/getting-started/probe-setup says how to allow it)"
    )]
    NoProbe,
    /// It is not clear which.
    #[error("more than one debug probe is connected ({0}): disconnect all but the board's")]
    Several(String),
    /// Another program has it, or it is not allowed.
    #[error(
        "the probe cannot be opened: {0}; end other programs that use it (probe-rs, a debugger), and see that this user may use it"
    )]
    Closed(probe_rs::probe::DebugProbeError),
    /// The probe finds no chip.
    #[error(
        "the probe does not reach the chip: {0}; is the board powered, are the jumpers of its ST-LINK in place?"
    )]
    NoChip(Box<probe_rs::Error>),
    /// Another chip.
    #[error(
        "the chip behind the probe is no STM32G431: its device number is {0:#05x}, not {DEVICE:#05x}; is this the NUCLEO-G431RB?"
    )]
    OtherChip(u32),
    /// The image has no log, or cannot be read.
    #[error("{}: {why}; `cargo xtask build` makes an image", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// Another image than that by whose table the log would be read.
    #[error(
        "the chip runs another image than {}, it differs at {address:#010x}: `cargo xtask flash` puts this one on it, `--scene` names another",
        path.display()
    )]
    OtherImage {
        /// The file.
        path: PathBuf,
        /// Where flash differs first.
        address: u32,
    },
    /// No ring buffer where the image has it.
    #[error(
        "the chip runs without this image's log: {0}; `cargo xtask flash` puts the firmware on it"
    )]
    NoLog(RttError),
}

/// The only one of the probes.
fn only<T: Display>(mut probes: Vec<T>) -> std::result::Result<T, Failure> {
    match probes.len() {
        0 => Err(Failure::NoProbe),
        1 => Ok(probes.remove(0)),
        _ => {
            let names: Vec<String> = probes.iter().map(ToString::to_string).collect();
            Err(Failure::Several(names.join(", ")))
        }
    }
}

/// Whether a chip that says so of itself is the one that the firmware is made for.
fn is_the_chip(identity: u32) -> std::result::Result<(), Failure> {
    match identity & DEVICE_BITS {
        DEVICE => Ok(()),
        other => Err(Failure::OtherChip(other)),
    }
}

/// Finds where memory first differs from what an image has there. Every image keeps its log at the same address, and the table of one image
/// makes nonsense of the log of another.
fn first_difference<'a, E>(
    image: impl Iterator<Item = (u32, &'a [u8])>,
    mut read: impl FnMut(u32, &mut [u8]) -> std::result::Result<(), E>,
) -> std::result::Result<Option<u32>, E> {
    for (start, wanted) in image {
        let mut found = vec![0; wanted.len()];
        read(start, &mut found)?;
        if let Some(offset) = (found.iter().zip(wanted)).position(|(found, wanted)| found != wanted)
        {
            return Ok(Some(start + offset as u32));
        }
    }
    Ok(None)
}

/// Whether the firmware has started anew since the log was last read, which sets its buffers up again.
fn has_restarted(error: &RttError) -> bool {
    matches!(
        error,
        RttError::ReadPointerChanged | RttError::ControlBlockCorrupted(_)
    )
}

/// An attached chip.
pub struct Probe {
    session: Session,
    rtt: Rtt,
    /// Address of the log's control block.
    block: u64,
}

impl Probe {
    /// Attaches to the only probe, and to the log of the image `elf`.
    ///
    /// # Errors
    /// [`Failure`]: no probe, another chip behind it, another image in its flash, or no log in its memory.
    pub fn attach(elf: &Path) -> std::result::Result<Self, Failure> {
        let image = |why: String| Failure::Image {
            path: elf.to_owned(),
            why,
        };
        let data = std::fs::read(elf).map_err(|error| image(error.to_string()))?;
        let block = find_rtt_control_block_in_raw_file(&data)
            .map_err(|error| image(error.to_string()))?
            .ok_or_else(|| image("no log in this image".to_owned()))?;
        let contents = Image::parse(&data).map_err(|error| image(format!("{error:#}")))?;
        let probe = only(Lister::new().list_all())?;
        let probe = probe.open().map_err(Failure::Closed)?;
        let chip = |error: probe_rs::Error| Failure::NoChip(Box::new(error));
        let mut session = probe.attach(CHIP, Permissions::default()).map_err(chip)?;
        let rtt = {
            let mut core = session.core(0).map_err(chip)?;
            is_the_chip(core.read_word_32(IDENTITY).map_err(chip)?)?;
            let read = |address: u32, bytes: &mut [u8]| core.read(u64::from(address), bytes);
            if let Some(address) = first_difference(contents.flash(), read).map_err(chip)? {
                let path = elf.to_owned();
                return Err(Failure::OtherImage { path, address });
            }
            try_attach_to_rtt(&mut core, STARTED, &ScanRegion::Exact(block))
                .map_err(Failure::NoLog)?
        };
        Ok(Self {
            session,
            rtt,
            block,
        })
    }
}

impl Wire for Probe {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        let mut core = self.session.core(0).map_err(Error::other)?;
        let channel = self.rtt.up_channel(0);
        let channel = channel.ok_or_else(|| Error::other("the firmware has no log channel"))?;
        match channel.read(&mut core, bytes) {
            Err(error) if has_restarted(&error) => {
                let found = try_attach_to_rtt(&mut core, STARTED, &ScanRegion::Exact(self.block));
                self.rtt = found.map_err(Error::other)?;
                Ok(0)
            }
            read => read.map_err(Error::other),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut core = self.session.core(0).map_err(Error::other)?;
        let channel = self.rtt.down_channel(0);
        let channel = channel.ok_or_else(|| Error::other("the firmware takes no commands"))?;
        let mut left = bytes;
        while !left.is_empty() {
            let count = channel.write(&mut core, left).map_err(Error::other)?;
            left = left.get(count..).unwrap_or_default();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is told ends with what to do.
    fn told<T>(refused: std::result::Result<T, Failure>) -> String {
        refused
            .err()
            .map_or_else(String::new, |failure| failure.to_string())
    }

    #[test]
    fn one_probe_is_taken_and_none_or_two_are_refused() {
        assert_eq!(only(vec!["ST-LINK"]).ok(), Some("ST-LINK"));
        assert!(told(only(Vec::<String>::new())).contains("connect the board's ST-LINK"));
        let two = told(only(vec!["ST-LINK", "J-Link"]));
        assert!(
            two.contains("ST-LINK, J-Link") && two.contains("disconnect"),
            "{two}"
        );
    }

    #[test]
    fn another_chip_is_named() {
        // Revision and device of a G431, then of a G474.
        assert!(is_the_chip(0x2001_6468).is_ok());
        let other = told(is_the_chip(0x2003_6469));
        assert!(
            other.contains("0x469") && other.contains("NUCLEO-G431RB"),
            "{other}"
        );
    }

    #[test]
    fn another_image_is_told_by_the_first_byte_that_differs() {
        const START: u32 = 0x0800_0000;
        let flash = [1, 2, 3, 4, 5, 6, 7, 8];
        let sections: [(u32, &[u8]); 2] = [(START, &[1, 2, 3]), (START + 4, &[5, 6, 7])];
        let of = |flash: [u8; 8]| {
            first_difference(sections.into_iter(), |address, bytes: &mut [u8]| {
                let from = (address - START) as usize;
                let held = flash.get(from..from + bytes.len()).ok_or("beyond")?;
                bytes.copy_from_slice(held);
                Ok::<_, &str>(())
            })
        };
        assert_eq!(of(flash), Ok(None));
        // Between the sections is nobody's.
        assert_eq!(of([1, 2, 3, 0, 5, 6, 7, 0]), Ok(None));
        assert_eq!(of([1, 2, 3, 4, 5, 0, 7, 8]), Ok(Some(START + 5)));
        let path = PathBuf::from("palpate-p70");
        let address = START + 5;
        let told = Failure::OtherImage { path, address }.to_string();
        assert!(
            told.contains("palpate-p70") && told.contains("0x08000005") && told.contains("--scene"),
            "{told}"
        );
    }

    #[test]
    fn a_restart_is_followed_and_a_lost_probe_is_not() {
        assert!(has_restarted(&RttError::ReadPointerChanged));
        assert!(has_restarted(&RttError::ControlBlockCorrupted(
            String::new()
        )));
        assert!(!has_restarted(&RttError::MissingChannel(0)));
    }

    #[test]
    fn a_file_that_is_no_image_is_refused_before_a_probe_is_looked_for() {
        let none = told(Probe::attach(Path::new("no/such/image")));
        assert!(
            none.contains("no/such/image") && none.contains("cargo xtask build"),
            "{none}"
        );
    }
}
