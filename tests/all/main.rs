//! Tests of the library, its firmware parts and the documents in one program: what is generic is compiled once for all of them.

mod architecture;
mod bad_input;
mod constant_fingers;
mod direct;
mod finger_properties;
mod finger_support;
mod flash;
mod fuzz_seeds;
mod golden;
mod golden_files;
mod hard_cases;
mod hidden;
mod long_fingers;
mod manual;
mod numeric;
mod references;
mod return_cable;
mod store;
mod two_contacts;
mod weight;
