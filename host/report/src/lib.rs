//! Judges the library: reference data, speed against error, size and symbols of an ELF.

pub mod golden;
pub mod report;
pub mod size;
pub mod target;
