// SPDX-License-Identifier: GPL-2.0-only
//! Ports for tools that know nothing of this emulator: the log's bytes over TCP, as a debug probe's server passes RTT on
//! ([`rtt`]), and GDB's remote protocol ([`gdb`]). Both listen on this machine alone.

mod cortex_m4;
pub mod gdb;
pub mod rtt;
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
