// SPDX-License-Identifier: GPL-2.0-only
//! The commands of the program.

pub mod bench;
pub mod campaign;
mod counts;
pub mod faults;
mod live;
mod output;
mod ports;
pub mod sim;

use std::process::ExitCode;

use palpate_emulator::Error;

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
