//! A debug probe, by probe-rs as a library: the same RTT channels that `probe-rs run` reads, without a program between.
//!
//! It attaches to the firmware that runs, and neither halts nor resets it.

use std::io::{Error, Result};
use std::path::Path;

use probe_rs::rtt::{Rtt, ScanRegion, find_rtt_control_block_in_raw_file};
use probe_rs::{Session, SessionConfig};

use super::Wire;

/// The chip as probe-rs knows it.
const CHIP: &str = "STM32G431RBTx";

/// An attached chip.
pub struct Probe {
    session: Session,
    rtt: Rtt,
}

impl Probe {
    /// Attaches to the first probe found, and to the log of the image `elf`.
    ///
    /// # Errors
    /// No probe, no chip behind it, or no log in its memory.
    pub fn attach(elf: &Path) -> Result<Self> {
        let image = std::fs::read(elf)?;
        let block = find_rtt_control_block_in_raw_file(&image).map_err(Error::other)?;
        let region = block.map_or(ScanRegion::Ram, ScanRegion::Exact);
        let mut session =
            Session::auto_attach(CHIP, SessionConfig::default()).map_err(Error::other)?;
        let rtt = {
            let mut core = session.core(0).map_err(Error::other)?;
            Rtt::attach_region(&mut core, &region).map_err(Error::other)?
        };
        Ok(Self { session, rtt })
    }
}

impl Wire for Probe {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        let mut core = self.session.core(0).map_err(Error::other)?;
        let channel = self.rtt.up_channel(0);
        let channel = channel.ok_or_else(|| Error::other("the firmware has no log channel"))?;
        channel.read(&mut core, bytes).map_err(Error::other)
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
