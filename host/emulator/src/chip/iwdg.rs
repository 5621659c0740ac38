// SPDX-License-Identifier: GPL-2.0-only
//! IWDG: the independent watchdog, which has its own oscillator.

use super::bank::{Bank, Misuse, Register};
use crate::time::{TICKS_PER_S, Ticks};

const KR: u32 = 0x00;
const PR: u32 = 0x04;
const RLR: u32 = 0x08;
const SR: u32 = 0x0C;
const WINR: u32 = 0x10;

const REGISTERS: &[Register] = &[
    (KR, "KR", 0),
    (PR, "PR", 0),
    (RLR, "RLR", 0xFFF),
    (SR, "SR", 0),
    (WINR, "WINR", 0xFFF),
];

#[derive(Debug)]
pub(crate) struct Iwdg {
    bank: Bank,
    unlocked: bool,
    /// Time of the last reload.
    reloaded: Option<Ticks>,
    /// The oscillator, 32 kHz nominal, 29.5 to 34 kHz over temperature and supply.
    pub(crate) lsi_hz: u64,
    bitten: bool,
    /// Time at which it resets the chip.
    due: Option<Ticks>,
}

impl Iwdg {
    pub(crate) fn new(lsi_hz: u64) -> Self {
        Self {
            bank: Bank::new("IWDG", REGISTERS),
            unlocked: false,
            reloaded: None,
            lsi_hz,
            bitten: false,
            due: None,
        }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        if offset == KR {
            Ok(0)
        } else {
            self.bank.read(offset)
        }
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Misuse> {
        self.store(offset, value, now)?;
        self.due = self.find_due();
        Ok(())
    }

    fn store(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Misuse> {
        match (offset, value) {
            (KR, 0xCCCC) => self.reloaded = Some(now),
            (KR, 0xAAAA) => {
                self.bitten |= self.too_early(now);
                self.unlocked = false;
                self.reloaded = self.reloaded.map(|_| now);
            }
            (KR, 0x5555) => self.unlocked = true,
            (KR, _) => self.unlocked = false,
            (PR | RLR | WINR, _) if !self.unlocked => {
                return Err(self.bank.unsupported(
                    offset,
                    value,
                    "written without the access key 0x5555",
                ));
            }
            (WINR, _) => {
                // Writing the window also reloads the counter.
                self.bank.write(offset, value & 0xFFF)?;
                self.reloaded = self.reloaded.map(|_| now);
            }
            _ => self.bank.write(offset, value & 0xFFF)?,
        }
        Ok(())
    }

    fn step(&self) -> Ticks {
        (4 << self.bank[PR].min(6)) * TICKS_PER_S / self.lsi_hz
    }

    fn too_early(&self, now: Ticks) -> bool {
        let left =
            |since: Ticks| u64::from(self.bank[RLR]).saturating_sub((now - since) / self.step());
        self.reloaded
            .is_some_and(|since| left(since) > u64::from(self.bank[WINR]))
    }

    /// Time at which it resets the chip.
    pub(crate) fn next_event(&self) -> Option<Ticks> {
        self.due
    }

    fn find_due(&self) -> Option<Ticks> {
        let since = self.reloaded?;
        if self.bitten {
            Some(since)
        } else {
            Some(since + (u64::from(self.bank[RLR]) + 1) * self.step())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::TICKS_PER_MS;

    #[test]
    fn bites_when_not_fed_and_when_fed_too_early() {
        let mut dog = Iwdg::new(32_000);
        assert_eq!(dog.next_event(), None);
        assert!(dog.write(PR, 1, 0).is_err());
        dog.write(KR, 0xCCCC, 0).unwrap();
        dog.write(KR, 0x5555, 0).unwrap();
        dog.write(PR, 0, 0).unwrap();
        dog.write(RLR, 79, 0).unwrap();
        assert_eq!(dog.next_event(), Some(10 * TICKS_PER_MS));
        dog.write(KR, 0xAAAA, 4 * TICKS_PER_MS).unwrap();
        assert_eq!(dog.next_event(), Some(14 * TICKS_PER_MS));
        dog.write(KR, 0x5555, 4 * TICKS_PER_MS).unwrap();
        dog.write(WINR, 40, 4 * TICKS_PER_MS).unwrap();
        dog.write(KR, 0xAAAA, 5 * TICKS_PER_MS).unwrap();
        assert_eq!(
            dog.next_event(),
            Some(5 * TICKS_PER_MS),
            "before the window opens"
        );
    }
}
