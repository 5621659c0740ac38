//! Palpate: where an underactuated finger touches an object, from the encoder and the current of its one motor.
//!
//! | room | what it knows | what it never sees |
//! |---|---|---|
//! | [`numeric`] | square root, sine and cosine, bisection, small linear algebra, each with its measured error | fingers |
//! | [`name_list`] | look-up in a list of names kept as one text | what they mean |
//! | [`range`] | which parameter is out of its range | what it is for |
//! | [`joint_sensor`] | the optional angle sensor of joint 2, from code to angle and its deviation | where the contact is |
//! | [`finger`] | phalanges, transmission, statics, stiffness, contact path | motors, time, noise |
//! | [`sensing`] | samples to events: friction, detection, location, force, uncertainty | the chip |
//! | [`drive`] | counts, codes, current and speed loops, motion sequence, faults | where the contact is |
//! | [`app`] | the slow loop: sensing and sequence put together | the chip |
//! | [`scene`] | this finger, this drivetrain, these limits: the file to edit | |
//! | `board` | the chip: pins, interrupts, flash, telemetry (target only) | arithmetic |
#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_code)]

// The scenes that the build script generates for the tests name the library as its users do.
#[cfg(test)]
extern crate self as palpate;

pub mod drive;
pub mod finger;
pub mod joint_sensor;
pub mod name_list;
pub mod numeric;
pub mod range;
pub mod sample;
pub mod scene;
pub mod sensing;

pub mod app;
