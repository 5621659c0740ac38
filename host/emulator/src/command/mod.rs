// SPDX-License-Identifier: GPL-2.0-only
//! The commands of the program.

pub mod bench;
pub mod campaign;
mod counts;
mod ending;
pub mod faults;
mod flash;
mod live;
mod object;
mod output;
mod ports;
pub mod sim;

use std::fs::File;
use std::path::Path;
use std::process::ExitCode;

use palpate_emulator::Error;

/// Finds out before a long run whether a file can be written after it. A file that is there stays, and one that was not is not left
/// behind.
fn can_be_written(path: &Path) -> Result<(), Error> {
    let tried = if path.exists() {
        File::options().append(true).open(path).map(drop)
    } else {
        File::create_new(path).and_then(|_| std::fs::remove_file(path))
    };
    tried.map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })
}

/// Wrong options and files exit with 2, everything else that goes wrong with 1.
pub fn exit_code(error: &Error) -> ExitCode {
    match error {
        Error::Read { .. }
        | Error::Write { .. }
        | Error::Elf { .. }
        | Error::World(_)
        | Error::Call(_)
        | Error::Plant(_)
        | Error::NoFunction(_) => ExitCode::from(2),
        _ => ExitCode::FAILURE,
    }
}
