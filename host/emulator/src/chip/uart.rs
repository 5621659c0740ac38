// SPDX-License-Identifier: GPL-2.0-only
//! LPUART1 and USART2: bytes in and out at the line's speed, through queues of one byte or, with the FIFO on, eight.

use std::collections::VecDeque;

use super::bank::{Bank, Clocks, Misuse, Register};
use crate::time::Ticks;

const CR1: u32 = 0x00;
const CR3: u32 = 0x08;
const BRR: u32 = 0x0C;
const RQR: u32 = 0x18;
const ISR: u32 = 0x1C;
const ICR: u32 = 0x20;
const RDR: u32 = 0x24;
const TDR: u32 = 0x28;
const PRESC: u32 = 0x2C;

const REGISTERS: &[Register] = &[
    (CR1, "CR1", 0),
    (0x04, "CR2", 0),
    (CR3, "CR3", 0),
    (BRR, "BRR", 0),
    (0x10, "GTPR", 0),
    (0x14, "RTOR", 0),
    (RQR, "RQR", 0),
    (ISR, "ISR", 0x00C0),
    (ICR, "ICR", 0),
    (RDR, "RDR", 0),
    (TDR, "TDR", 0),
    (PRESC, "PRESC", 0),
];

const UE: u32 = 1;
const FIFOEN: u32 = 1 << 29;
const RE: u32 = 1 << 2;
const TE: u32 = 1 << 3;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
const TEACK: u32 = 1 << 21;
const REACK: u32 = 1 << 22;

/// One asynchronous serial port.
#[derive(Debug)]
pub(crate) struct Uart {
    bank: Bank,
    low_power: bool,
    shifting: Option<(u8, Ticks)>,
    waiting: VecDeque<u8>,
    received: VecDeque<u8>,
    /// Bytes sent by the firmware.
    pub(crate) sent: Vec<u8>,
    incoming: VecDeque<u8>,
    next_incoming: Option<Ticks>,
}

impl Uart {
    pub(crate) fn new(name: &'static str, low_power: bool) -> Self {
        Self {
            bank: Bank::new(name, REGISTERS),
            low_power,
            shifting: None,
            waiting: VecDeque::new(),
            received: VecDeque::new(),
            sent: Vec::new(),
            incoming: VecDeque::new(),
            next_incoming: None,
        }
    }

    pub(crate) fn reset(&mut self) {
        self.bank.reset();
        self.shifting = None;
        self.waiting.clear();
        self.received.clear();
        self.next_incoming = None;
    }

    /// Ten bits.
    fn character(&self, clocks: Clocks) -> Ticks {
        const PRESCALER: [u64; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
        let divider = u64::from(self.bank[BRR].max(1));
        let prescaler = PRESCALER[(self.bank[PRESC] as usize & 0xF).min(11)];
        let bit = clocks.bus * prescaler * divider;
        10 * if self.low_power { bit / 256 } else { bit }
    }

    /// Receives bytes from outside, one after the other at the line's speed.
    pub(crate) fn receive(&mut self, bytes: &[u8], clocks: Clocks) {
        self.incoming.extend(bytes);
        self.listen(clocks);
    }

    fn listen(&mut self, clocks: Clocks) {
        let listening = self.bank[CR1] & (UE | RE) == UE | RE;
        if listening && self.next_incoming.is_none() && !self.incoming.is_empty() {
            self.next_incoming = Some(clocks.now + self.character(clocks));
        }
    }

    pub(crate) fn read(&mut self, offset: u32) -> Result<u32, Misuse> {
        if offset == RDR
            && let Some(byte) = self.received.pop_front()
        {
            self.bank[RDR] = byte.into();
            self.update();
        }
        self.bank.read(offset)
    }

    /// Entries of the queue on either side of the shift registers.
    fn depth(&self) -> usize {
        if self.bank[CR1] & FIFOEN != 0 { 8 } else { 1 }
    }

    /// Flags that follow from the queues.
    fn update(&mut self) {
        let room = self.waiting.len() < self.depth();
        let idle = self.waiting.is_empty() && self.shifting.is_none();
        let flag = |condition, flag| if condition { flag } else { 0 };
        let flags = flag(room, TXE)
            | flag(idle, TC & self.bank[ISR])
            | flag(!self.received.is_empty(), RXNE);
        self.bank[ISR] = self.bank[ISR] & !(TXE | TC | RXNE) | flags;
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, clocks: Clocks) -> Result<(), Misuse> {
        match offset {
            ISR => {}
            // In ICR bits 5 and 7 belong to other flags than in ISR.
            ICR => self.bank[ISR] &= !(value & 0x0012_3B5F),
            RQR => {
                if value & 8 != 0 {
                    self.received.clear();
                }
                self.update();
            }
            TDR => {
                if self.waiting.len() < self.depth() {
                    self.waiting.push_back(value as u8);
                }
                self.shift(clocks);
                self.update();
            }
            CR3 if value & 0xC0 != 0 => {
                return Err(self.bank.unsupported(
                    CR3,
                    value,
                    "DMA of the serial port is not modelled",
                ));
            }
            CR1 => {
                self.bank[CR1] = value;
                let acknowledge = |enable, flag| {
                    if value & UE != 0 && value & enable != 0 {
                        flag
                    } else {
                        0
                    }
                };
                let status = self.bank[ISR] & !(TEACK | REACK);
                self.bank[ISR] = status | acknowledge(TE, TEACK) | acknowledge(RE, REACK);
                self.update();
                self.listen(clocks);
            }
            _ => self.bank.write(offset, value)?,
        }
        Ok(())
    }

    fn shift(&mut self, clocks: Clocks) {
        if self.shifting.is_none()
            && self.bank[CR1] & (UE | TE) == UE | TE
            && let Some(byte) = self.waiting.pop_front()
        {
            self.shifting = Some((byte, clocks.now + self.character(clocks)));
        }
    }

    pub(crate) fn next_event(&self) -> Option<Ticks> {
        self.shifting
            .map(|s| s.1)
            .into_iter()
            .chain(self.next_incoming)
            .min()
    }

    pub(crate) fn advance(&mut self, clocks: Clocks) {
        if let Some((byte, done)) = self.shifting
            && done <= clocks.now
        {
            self.sent.push(byte);
            self.shifting = None;
            self.shift(clocks);
            if self.shifting.is_none() {
                self.bank[ISR] |= TC;
            }
            self.update();
        }
        if self.next_incoming.is_some_and(|at| at <= clocks.now) {
            self.next_incoming = None;
            if let Some(byte) = self.incoming.pop_front() {
                if self.received.len() < self.depth() {
                    self.received.push_back(byte);
                    self.update();
                } else {
                    self.bank[ISR] |= ORE;
                }
            }
            if self.incoming.is_empty() {
                self.bank[ISR] |= IDLE;
            }
            self.listen(clocks);
        }
    }

    pub(crate) fn interrupt(&self) -> bool {
        let (status, enable) = (self.bank[ISR], self.bank[CR1]);
        // The enable bits of TXE, TC, RXNE and IDLE have the positions of their flags.
        let direct = status & enable & (TXE | TC | RXNE | IDLE) != 0;
        let overrun = status & ORE != 0 && (enable & RXNE != 0 || self.bank[CR3] & 1 != 0);
        direct || overrun
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(now: Ticks) -> Clocks {
        Clocks { now, bus: 24 }
    }

    fn port() -> Uart {
        let mut port = Uart::new("LPUART1", true);
        // 115200 baud: 256 * 170e6 / 115200
        port.write(BRR, 377_778, at(0)).unwrap();
        port.write(CR1, UE | RE | TE | RXNE, at(0)).unwrap();
        port
    }

    #[test]
    fn sends_at_the_lines_speed() {
        let mut port = port();
        port.write(TDR, 0x41, at(0)).unwrap();
        port.write(TDR, 0x42, at(0)).unwrap();
        let done = port.next_event().unwrap();
        let microseconds = done as f64 / crate::time::TICKS_PER_US as f64;
        assert!((microseconds - 86.8).abs() < 0.1, "{microseconds}");
        port.advance(at(done));
        assert_eq!(port.read(ISR).unwrap() & (TXE | TC), TXE);
        port.advance(at(2 * done));
        assert_eq!(port.sent, b"AB");
        assert_eq!(port.read(ISR).unwrap() & TC, TC);
    }

    #[test]
    fn an_interrupt_driven_sender_gets_every_byte_out() {
        let mut port = port();
        port.write(CR1, UE | RE | TE | FIFOEN, at(0)).unwrap();
        port.write(CR1, UE | RE | TE | FIFOEN | TXE, at(0)).unwrap();
        let mut now = 0;
        let mut left = 100;
        while left > 0 || port.shifting.is_some() {
            while port.interrupt() && left > 0 {
                let status = port.read(ISR).unwrap();
                port.write(ICR, status, at(now)).unwrap();
                port.write(TDR, left, at(now)).unwrap();
                left -= 1;
            }
            now = port.next_event().expect("something is on its way");
            port.advance(at(now));
        }
        assert_eq!(port.sent.len(), 100);
        port.write(CR1, UE | RE | TE | FIFOEN | TC, at(now))
            .unwrap();
        assert!(port.interrupt(), "transmission complete");
    }

    #[test]
    fn clearing_every_flag_leaves_room_to_send() {
        let mut port = port();
        port.write(ICR, 0xFFFF_FFFF, at(0)).unwrap();
        assert_eq!(port.read(ISR).unwrap() & TXE, TXE);
    }

    #[test]
    fn a_byte_not_fetched_in_time_is_an_overrun() {
        let mut port = port();
        port.receive(b"ab", at(0));
        for _ in 0..2 {
            let now = port.next_event().unwrap();
            port.advance(at(now));
        }
        assert!(port.interrupt());
        assert_eq!(port.read(ISR).unwrap() & (RXNE | ORE), RXNE | ORE);
        assert_eq!(port.read(RDR), Ok(u32::from(b'a')));
    }
}
