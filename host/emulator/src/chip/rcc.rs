// SPDX-License-Identifier: GPL-2.0-only
//! RCC: oscillators, clock tree, clock gates, reset causes.

use super::bank::{Bank, Misuse, Register};
use super::quirks::Quirks;
use crate::time::{self, Ticks};

const CR: u32 = 0x00;
const CFGR: u32 = 0x08;
const PLLCFGR: u32 = 0x0C;
const CSR: u32 = 0x94;
const BDCR: u32 = 0x90;
const CRRCR: u32 = 0x98;
const CCIPR: u32 = 0x88;

const REGISTERS: &[Register] = &[
    (CR, "CR", 0x0000_0500),
    (0x04, "ICSCR", 0x4000_0000),
    (CFGR, "CFGR", 0x0000_0005),
    (PLLCFGR, "PLLCFGR", 0x0000_1000),
    (0x18, "CIER", 0),
    (0x1C, "CIFR", 0),
    (0x20, "CICR", 0),
    (0x28, "AHB1RSTR", 0),
    (0x2C, "AHB2RSTR", 0),
    (0x30, "AHB3RSTR", 0),
    (0x38, "APB1RSTR1", 0),
    (0x3C, "APB1RSTR2", 0),
    (0x40, "APB2RSTR", 0),
    (0x48, "AHB1ENR", 0x0000_0100),
    (0x4C, "AHB2ENR", 0),
    (0x50, "AHB3ENR", 0),
    (0x58, "APB1ENR1", 0x0000_0400),
    (0x5C, "APB1ENR2", 0),
    (0x60, "APB2ENR", 0),
    (0x68, "AHB1SMENR", 0x0000_130F),
    (0x6C, "AHB2SMENR", 0x0505_667F),
    (0x70, "AHB3SMENR", 0),
    (0x78, "APB1SMENR1", 0xD2FE_CD3F),
    (0x7C, "APB1SMENR2", 0x0000_0103),
    (0x80, "APB2SMENR", 0x0037_7801),
    (CCIPR, "CCIPR", 0),
    (BDCR, "BDCR", 0),
    (CSR, "CSR", 0),
    (CRRCR, "CRRCR", 0),
    (0x9C, "CCIPR2", 0),
];

const BDRST: u32 = 1 << 16;
const LSCOEN: u32 = 1 << 24;

const HSI_HZ: u64 = 16_000_000;
/// Crystal of the NUCLEO-G431RB.
const HSE_HZ: u64 = 24_000_000;

/// Why the chip was reset: the flags of RCC.CSR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetCause {
    /// The supply came back: RAM is lost.
    PowerOn,
    /// The supply dipped below the brown-out threshold, but RAM kept its contents.
    BrownOut,
    /// The reset pin.
    Pin,
    /// SYSRESETREQ.
    Software,
    /// The independent watchdog.
    Watchdog,
}

impl ResetCause {
    /// Every internal reset also pulls the reset pin.
    fn flags(self) -> u32 {
        const PIN: u32 = 1 << 26;
        PIN | match self {
            Self::PowerOn | Self::BrownOut => 1 << 27,
            Self::Pin => 0,
            Self::Software => 1 << 28,
            Self::Watchdog => 1 << 29,
        }
    }
}

/// Clock gate of a peripheral: offset of the enable register and its bit.
pub(crate) type Gate = (u32, u32);

#[derive(Debug)]
pub(crate) struct Rcc {
    bank: Bank,
    quirks: Quirks,
    /// Period of the bus clock.
    pub(crate) bus: Ticks,
}

impl Rcc {
    pub(crate) fn new(quirks: Quirks) -> Self {
        let mut bank = Bank::new("RCC", REGISTERS);
        if quirks.stale_backup_domain {
            bank[BDCR] = LSCOEN | 1 << 3;
        }
        Self {
            bank,
            quirks,
            bus: time::TICKS_PER_S / HSI_HZ,
        }
    }

    /// The reset flags stay until the firmware removes them; the backup domain keeps its clock.
    pub(crate) fn reset(&mut self, cause: ResetCause) {
        let flags = if cause == ResetCause::PowerOn {
            0
        } else {
            self.bank[CSR] & 0xFF00_0000
        };
        let backup = self.bank[BDCR];
        *self = Self::new(self.quirks);
        self.bank[CSR] = flags | cause.flags();
        if cause != ResetCause::PowerOn {
            self.bank[BDCR] = backup;
        }
    }

    /// Whether the oscillator of 32 kHz is driven out on PA2, which no peripheral drives then.
    pub(crate) fn drives_low_speed(&self) -> bool {
        self.bank[BDCR] & LSCOEN != 0
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Misuse> {
        self.bank.read(offset)
    }

    /// Returns the reset bits that were set, with the offset of the enable register they belong to.
    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<Option<Gate>, Misuse> {
        self.bank.write(offset, value)?;
        match offset {
            // Oscillators are ready immediately or never: start-up times are not modelled.
            CR => {
                let crystal = u32::from(!self.quirks.crystal_dead) & value >> 16;
                let ready = (value >> 8 & 1) << 10 | crystal << 17 | (value >> 24 & 1) << 25;
                self.bank[CR] = value & !(1 << 10 | 1 << 17 | 1 << 25) | ready;
            }
            // The reset of the domain leaves nothing but itself.
            BDCR if value & BDRST != 0 => self.bank[BDCR] = BDRST,
            BDCR => self.bank[BDCR] = value & !2 | (value & 1) << 1,
            CRRCR => self.bank[CRRCR] = value & !2 | (value & 1) << 1,
            CSR => {
                let old = self.bank[CSR];
                let flags = if value >> 23 & 1 != 0 {
                    0
                } else {
                    old & 0xFF00_0000
                };
                self.bank[CSR] = flags | value & 1 | (value & 1) << 1;
            }
            CFGR => {
                self.bank[CFGR] = value & !0xC | (value & 3) << 2;
                if value & 0x3F00 != 0 {
                    return Err(self.bank.unsupported(
                        CFGR,
                        value,
                        "APB prescalers other than 1 are not modelled",
                    ));
                }
            }
            0x28..=0x40 => return Ok(Some((offset + 0x20, value))),
            _ => {}
        }
        if matches!(offset, CR | CFGR | PLLCFGR) {
            self.retime()?;
        }
        Ok(None)
    }

    pub(crate) fn enabled(&self, (register, bit): Gate) -> bool {
        self.bank[register] >> bit & 1 != 0
    }

    pub(crate) fn name(&self, offset: u32) -> &'static str {
        self.bank.register(offset)
    }

    /// Source of the ADC's own clock is the system clock.
    pub(crate) fn adc_from_system_clock(&self) -> bool {
        self.bank[CCIPR] >> 28 & 3 == 2
    }

    fn retime(&mut self) -> Result<(), Misuse> {
        let cr = self.bank[CR];
        let cfgr = self.bank[CFGR];
        let pll = self.bank[PLLCFGR];
        let source = match cfgr & 3 {
            1 => HSI_HZ,
            2 if cr >> 17 & 1 != 0 => HSE_HZ,
            3 => {
                let input = match pll & 3 {
                    2 => HSI_HZ,
                    3 if cr >> 17 & 1 != 0 => HSE_HZ,
                    _ => 0,
                };
                if input == 0 || cr >> 25 & 1 == 0 || pll >> 24 & 1 == 0 {
                    return Err(self.bank.unsupported(
                        CFGR,
                        cfgr,
                        "the PLL is selected but not running",
                    ));
                }
                let divide = (u64::from(pll >> 4 & 0xF) + 1) * 2 * (u64::from(pll >> 25 & 3) + 1);
                input * u64::from(pll >> 8 & 0x7F) / divide
            }
            _ => return Err(self.bank.unsupported(CFGR, cfgr, "no such clock source")),
        };
        if source > 170_000_000 {
            return Err(self
                .bank
                .unsupported(PLLCFGR, pll, "the chip runs at 170 MHz at most"));
        }
        let divide = match cfgr >> 4 & 0xF {
            code @ 8..=11 => 2 << (code - 8),
            code @ 12..=15 => 64 << (code - 12),
            _ => 1,
        };
        self.bus = time::period(source)
            .map(|ticks| ticks * divide)
            .ok_or_else(|| {
                self.bank
                    .unsupported(PLLCFGR, pll, "this frequency has no whole period in ticks")
            })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_at_170_mhz_from_the_crystal() {
        let mut rcc = Rcc::new(Quirks::default());
        assert_eq!(rcc.bus, 255);
        rcc.write(CR, 1 << 8 | 1 << 16).unwrap();
        rcc.write(PLLCFGR, 3 | 5 << 4 | 85 << 8 | 1 << 24).unwrap();
        rcc.write(CR, 1 << 8 | 1 << 16 | 1 << 24).unwrap();
        assert_eq!(rcc.read(CR).unwrap() >> 25 & 1, 1);
        rcc.write(CFGR, 3).unwrap();
        assert_eq!(rcc.read(CFGR).unwrap() & 0xC, 0xC);
        assert_eq!(rcc.bus, 24);
        rcc.write(CFGR, 3 | 8 << 4).unwrap();
        assert_eq!(rcc.bus, 48);
    }

    #[test]
    fn the_pll_must_run_before_it_is_selected() {
        assert!(Rcc::new(Quirks::default()).write(CFGR, 3).is_err());
    }

    #[test]
    fn a_dead_crystal_is_never_ready_and_drives_nothing() {
        let mut rcc = Rcc::new(Quirks {
            crystal_dead: true,
            ..Quirks::default()
        });
        rcc.write(CR, 1 << 8 | 1 << 16).unwrap();
        assert_eq!(rcc.read(CR).unwrap() >> 17 & 1, 0);
        assert!(rcc.write(CFGR, 2).is_err());
    }

    #[test]
    fn reset_flags_stay_until_removed() {
        let mut rcc = Rcc::new(Quirks::default());
        rcc.reset(ResetCause::Watchdog);
        rcc.reset(ResetCause::Software);
        assert_eq!(rcc.read(CSR).unwrap() >> 24, 0b0011_0100);
        rcc.write(CSR, 1 << 23).unwrap();
        assert_eq!(rcc.read(CSR).unwrap() >> 24, 0);
    }
}
