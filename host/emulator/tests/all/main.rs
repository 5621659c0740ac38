// SPDX-License-Identifier: GPL-2.0-only
//! Tests on the emulated chip in one program: what is generic is compiled once for all of them.

mod calibration;
mod campaign;
mod clients;
mod clock;
mod command_line;
mod console;
mod engines;
mod faults;
mod firmware;
mod identify;
mod instructions;
mod memory;
mod reference;
mod refused;
mod round_trip;
mod same_events;
mod scenes;
mod second_contacts;
mod selftest;
mod serial;
mod start;
mod storage;
mod support;
mod tracing;
