// SPDX-License-Identifier: GPL-2.0-only
//! RTT as a debug probe does it: ring buffers in the chip's RAM, found by the control block.

use crate::cortex::Engine;

/// How a debug probe reads the log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reader {
    /// Reads everything at every poll; like `probe-rs run` it switches the channel to blocking when it attaches.
    #[default]
    Attached,
    /// Attached, but fetches at most this many bytes at a poll.
    Slow(u32),
    /// No probe: nothing is read, and the channel keeps the mode that the firmware set.
    Absent,
}

/// Mode bits of a channel's flags: wait for room instead of dropping.
const BLOCK_IF_FULL: u32 = 2;

const IDENTITY: &[u8] = b"SEGGER RTT";
const HEADER: u32 = 24;
const CHANNEL: u32 = 24;

/// A ring buffer in the chip's RAM.
#[derive(Clone, Copy, Debug)]
struct Channel {
    descriptor: u32,
    buffer: u32,
    size: u32,
    write: u32,
    read: u32,
}

/// The probe's side of RTT.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rtt {
    /// Address of the control block; `None` if the firmware has none.
    control: Option<u32>,
    pub(crate) reader: Reader,
}

impl Rtt {
    pub(crate) fn new(control: Option<u32>, reader: Reader) -> Self {
        Self { control, reader }
    }

    /// Channel `index` of the up channels, then the down channels; `None` before the firmware has set it up.
    fn channel(&self, engine: &Engine, down: bool) -> Option<Channel> {
        let control = self.control?;
        let identity = engine.read(control, IDENTITY.len())?;
        if identity != IDENTITY {
            return None;
        }
        let ups = engine.word(control + 16)?;
        let downs = engine.word(control + 20)?;
        if (if down { downs } else { ups }) == 0 || ups > 16 {
            return None;
        }
        let descriptor = control + HEADER + if down { ups * CHANNEL } else { 0 };
        let word = |n: u32| engine.word(descriptor + 4 * n);
        let channel = Channel {
            descriptor,
            buffer: word(1)?,
            size: word(2)?,
            write: word(3)?,
            read: word(4)?,
        };
        let valid =
            channel.buffer != 0 && channel.write < channel.size && channel.read < channel.size;
        valid.then_some(channel)
    }

    /// Reads what the firmware has logged since the last poll.
    pub(crate) fn poll(&self, engine: &mut Engine) -> Vec<u8> {
        let most = match self.reader {
            Reader::Attached => u32::MAX,
            Reader::Slow(most) => most,
            Reader::Absent => return Vec::new(),
        };
        let Some(channel) = self.channel(engine, false) else {
            return Vec::new();
        };
        let flags = channel.descriptor + 20;
        if let Some(mode) = engine.word(flags)
            && mode & 3 != BLOCK_IF_FULL
        {
            engine.write(flags, &(mode & !3 | BLOCK_IF_FULL).to_le_bytes());
        }
        self.take(engine, channel, most)
    }

    /// Bytes left in the channel after the run; does not change its mode.
    pub(crate) fn rest(&self, engine: &mut Engine) -> Vec<u8> {
        match self.channel(engine, false) {
            Some(channel) if self.reader != Reader::Absent => self.take(engine, channel, u32::MAX),
            _ => Vec::new(),
        }
    }

    fn take(&self, engine: &mut Engine, channel: Channel, most: u32) -> Vec<u8> {
        let available = (channel.write + channel.size - channel.read) % channel.size;
        let length = available.min(most);
        let first = length.min(channel.size - channel.read);
        let mut bytes = engine
            .read(channel.buffer + channel.read, first as usize)
            .unwrap_or_default();
        bytes.extend(
            engine
                .read(channel.buffer, (length - first) as usize)
                .unwrap_or_default(),
        );
        let read = (channel.read + length) % channel.size;
        engine.write(channel.descriptor + 16, &read.to_le_bytes());
        bytes
    }

    /// Writes bytes into the down channel; returns how many fitted.
    pub(crate) fn send(&self, engine: &mut Engine, bytes: &[u8]) -> usize {
        let Some(channel) = self.channel(engine, true) else {
            return 0;
        };
        let room = (channel.read + channel.size - channel.write - 1) % channel.size;
        let length = bytes.len().min(room as usize);
        let mut write = channel.write;
        for &byte in &bytes[..length] {
            engine.write(channel.buffer + write, &[byte]);
            write = (write + 1) % channel.size;
        }
        engine.write(channel.descriptor + 12, &write.to_le_bytes());
        length
    }
}
