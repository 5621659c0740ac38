//! The firmware on the target; on a PC a launcher, so that `cargo run --release` flashes a connected board.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod board;

/// The scene that this firmware is built for, generated from its file.
#[cfg(target_os = "none")]
mod scene {
    include!(concat!(env!("OUT_DIR"), "/active.rs"));
}

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    // A PC cannot run the firmware: hand over to the command that builds it for the chip and flashes it.
    let status = std::process::Command::new(env!("CARGO"))
        .args(["xtask", "flash"])
        .args(std::env::args_os().skip(1))
        .status();
    match status {
        Ok(status) if status.success() => std::process::ExitCode::SUCCESS,
        Ok(_) => std::process::ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cannot start cargo: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
