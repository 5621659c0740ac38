// SPDX-License-Identifier: GPL-2.0-only
//! The ST-LINK's serial port as a terminal of this machine: a program opens it as it would open a board's.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

use crate::{Error, Machine};

/// The two ends of a pair of terminals. The programs' end is kept open here too, so that they may come and go.
pub struct Serial {
    chip: TTYPort,
    programs: TTYPort,
}

impl Serial {
    /// Opens a pair.
    ///
    /// # Errors
    /// This machine gives none.
    pub fn open() -> Result<Self, Error> {
        let opened = TTYPort::pair().and_then(|(mut chip, programs)| {
            chip.set_timeout(Duration::ZERO)?;
            Ok(Self { chip, programs })
        });
        opened.map_err(|error| Error::Serial(error.to_string()))
    }

    /// What a program opens.
    #[must_use]
    pub fn name(&self) -> String {
        self.programs.name().unwrap_or_default()
    }

    /// Passes on what there is, in both directions. What finds no reader is lost, as on a line.
    pub fn serve(&mut self, machine: &mut Machine<'_>) {
        let mut sent = machine.serial_output();
        while !sent.is_empty() {
            match self.chip.write(&sent) {
                Ok(count) => drop(sent.drain(..count)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => break,
            }
        }
        let mut typed = [0; 256];
        if let Ok(count) = self.chip.read(&mut typed) {
            machine.serial(&String::from_utf8_lossy(&typed[..count]));
        }
    }
}
