// SPDX-License-Identifier: GPL-2.0-only
//! RTT over TCP: the log's bytes to every client as the firmware wrote them, and a client's bytes into the down channel.
//!
//! A client that connects late first gets the stored records. A client that does not read is disconnected when too many bytes
//! are pending: the chip never waits.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};

use super::{listen, port_of};
use crate::{Error, Machine};

/// Bytes stored for clients that connect late: some thousand records.
const KEPT: usize = 64 * 1024;
/// Largest number of bytes pending for a client.
const WAITING: usize = 1024 * 1024;

/// The server.
pub struct RttServer {
    listener: TcpListener,
    clients: Vec<Client>,
    /// Pieces of whole records.
    kept: VecDeque<Vec<u8>>,
    kept_bytes: usize,
}

struct Client {
    stream: TcpStream,
    waiting: VecDeque<u8>,
}

impl RttServer {
    /// Listens on a port, 0 for any that is free.
    ///
    /// # Errors
    /// The port cannot be opened.
    pub fn listen(port: u16) -> Result<Self, Error> {
        Ok(Self {
            listener: listen(port)?,
            clients: Vec::new(),
            kept: VecDeque::new(),
            kept_bytes: 0,
        })
    }

    /// The port it listens on.
    #[must_use]
    pub fn port(&self) -> u16 {
        port_of(&self.listener)
    }

    /// Passes bytes on in both directions. Call it once a millisecond of simulated time.
    pub fn serve(&mut self, machine: &mut Machine<'_>) {
        machine.tap_log();
        let bytes = machine.take_log_bytes();
        while let Ok((stream, _)) = self.listener.accept() {
            if stream.set_nonblocking(true).is_ok() {
                let waiting = self.kept.iter().flatten().copied().collect();
                self.clients.push(Client { stream, waiting });
            }
        }
        for client in &mut self.clients {
            client.waiting.extend(&bytes);
        }
        self.keep(bytes);
        self.clients.retain_mut(|client| client.exchange(machine));
    }

    fn keep(&mut self, bytes: Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        self.kept_bytes += bytes.len();
        self.kept.push_back(bytes);
        while self.kept_bytes > KEPT {
            self.kept_bytes -= self
                .kept
                .pop_front()
                .map_or(self.kept_bytes, |old| old.len());
        }
    }
}

impl Client {
    /// False when the connection is closed.
    fn exchange(&mut self, machine: &mut Machine<'_>) -> bool {
        if self.waiting.len() > WAITING {
            return false;
        }
        while !self.waiting.is_empty() {
            match self.stream.write(self.waiting.as_slices().0) {
                Ok(count) => {
                    self.waiting.drain(..count);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return false,
            }
        }
        let mut typed = [0; 256];
        match self.stream.read(&mut typed) {
            Ok(0) => false,
            Ok(count) => {
                machine.command(&String::from_utf8_lossy(&typed[..count]));
                true
            }
            Err(error) => error.kind() == ErrorKind::WouldBlock,
        }
    }
}
