// SPDX-License-Identifier: GPL-2.0-only
//! Ports for standard tools: the log's bytes over TCP like the RTT server of a debug probe ([`rtt`]), GDB's remote protocol
//! ([`gdb`]), and the serial port as a terminal ([`serial`]). All are open to the local machine only.

mod cortex_m4;
pub mod gdb;
pub mod rtt;
#[cfg(unix)]
pub mod serial;
mod target;

use std::net::{Ipv4Addr, TcpListener};

use crate::Error;

/// Listens without blocking; port 0 selects a free one.
fn listen(port: u16) -> Result<TcpListener, Error> {
    let opened = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).and_then(|listener| {
        listener.set_nonblocking(true)?;
        Ok(listener)
    });
    opened.map_err(|source| Error::Port { port, source })
}

/// The port of a listener.
fn port_of(listener: &TcpListener) -> u16 {
    listener.local_addr().map_or(0, |address| address.port())
}
