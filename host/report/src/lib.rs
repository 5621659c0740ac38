//! Judging the library: reference data, speed against error, what an ELF weighs and carries.

pub mod elf;
pub mod golden;
pub mod report;
pub mod size;
