// SPDX-License-Identifier: GPL-2.0-only
//! The file that keeps the flash from one run to the next.

use std::path::Path;

use palpate_emulator::chip::FLASH_SIZE;
use palpate_emulator::{Error, Firmware};

/// The flash as this program is put onto a chip that an earlier run has left; nothing where there is no such file.
pub fn left(path: Option<&Path>, firmware: &Firmware) -> Result<Option<Vec<u8>>, Error> {
    let Some(path) = path.filter(|path| path.exists()) else {
        return Ok(None);
    };
    let image = std::fs::read(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    if image.len() != FLASH_SIZE {
        let why = format!(
            "{} bytes, a flash image has {FLASH_SIZE}; --flash takes a file that an earlier run kept, or one that does not exist yet",
            image.len()
        );
        return Err(Error::Elf {
            path: path.to_owned(),
            why,
        });
    }
    Ok(Some(firmware.flashed_over(&image)))
}
