// SPDX-License-Identifier: GPL-2.0-only
//! Ports for tools that know nothing of this emulator: the log's bytes over TCP, as a debug probe's server passes RTT on
//! ([`rtt`]), GDB's remote protocol ([`gdb`]), and the serial port as a terminal ([`serial`]). All are open to this machine alone.

mod cortex_m4;
pub mod gdb;
pub mod rtt;
#[cfg(unix)]
pub mod serial;
mod target;

use std::net::{Ipv4Addr, TcpListener};

use crate::Error;

/// Listens without waiting; port 0 for any that is free.
fn listen(port: u16) -> Result<TcpListener, Error> {
    let opened = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).and_then(|listener| {
        listener.set_nonblocking(true)?;
        Ok(listener)
    });
    opened.map_err(|source| Error::Port { port, source })
}

/// The port that a listener got.
fn port_of(listener: &TcpListener) -> u16 {
    listener.local_addr().map_or(0, |address| address.port())
}
