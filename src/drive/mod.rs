//! Motor and drivetrain: codes and units, current loop, motion sequence, protection.

pub mod io;
