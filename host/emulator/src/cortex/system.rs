// SPDX-License-Identifier: GPL-2.0-only
//! The private peripheral bus: interrupt controller, system control block, SysTick, cycle counter.

use super::nvic::{Bank as Irq, INTERRUPTS, exception};
use crate::chip::{Chip, Misuse, Register, ResetCause};

const CPACR: u32 = 0xD88;
pub(super) const CFSR: u32 = 0xD28;
pub(super) const HFSR: u32 = 0xD2C;
pub(super) const BFAR: u32 = 0xD38;
const AIRCR: u32 = 0xD0C;
const SHCSR: u32 = 0xD24;
pub(super) const VTOR: u32 = 0xD08;
pub(super) const FPDSCR: u32 = 0xF3C;
const DFSR: u32 = 0xD30;
const MPU_CTRL: u32 = 0xD94;

/// System control space from 0xE000_E000, without NVIC and SysTick.
pub(super) const SCS: &[Register] = &[
    (0x004, "ICTR", 3),
    (0x008, "ACTLR", 0),
    (0xD00, "CPUID", 0x410F_C241),
    (0xD04, "ICSR", 0),
    (VTOR, "VTOR", 0),
    (AIRCR, "AIRCR", 0xFA05_0000),
    (0xD10, "SCR", 0),
    (0xD14, "CCR", 0x200),
    (0xD18, "SHPR1", 0),
    (0xD1C, "SHPR2", 0),
    (0xD20, "SHPR3", 0),
    (SHCSR, "SHCSR", 0),
    (CFSR, "CFSR", 0),
    (HFSR, "HFSR", 0),
    (DFSR, "DFSR", 0),
    (0xD34, "MMFAR", 0),
    (BFAR, "BFAR", 0),
    (0xD3C, "AFSR", 0),
    (CPACR, "CPACR", 0),
    (0xD90, "MPU_TYPE", 0x800),
    (MPU_CTRL, "MPU_CTRL", 0),
    (0xD98, "MPU_RNR", 0),
    (0xD9C, "MPU_RBAR", 0),
    (0xDA0, "MPU_RASR", 0),
    (0xDF0, "DHCSR", 0),
    (0xDF8, "DCRDR", 0),
    (0xDFC, "DEMCR", 0),
    (0xF34, "FPCCR", 0xC000_0000),
    (0xF38, "FPCAR", 0),
    (FPDSCR, "FPDSCR", 0),
];

/// DWT from 0xE000_1000.
pub(super) const DWT: &[Register] = &[(0x0, "CTRL", 0x4000_0000), (0x4, "CYCCNT", 0)];

impl Chip {
    /// A load from the private peripheral bus; `address` is word-aligned.
    pub(super) fn read_system(&mut self, address: u32) -> Result<u32, Misuse> {
        let clocks = self.clocks();
        let nvic = &self.core.nvic;
        match address {
            0xE000_1000..=0xE000_1FFF => self.read_dwt(address & 0xFFF),
            0xE000_E010..=0xE000_E01F => Ok(self.core.systick.read(address & 0xF, clocks)),
            0xE000_E100..=0xE000_E19F => Ok(nvic.bank(Irq::Enabled, address >> 2 & 7)),
            0xE000_E200..=0xE000_E29F => Ok(nvic.bank(Irq::Pending, address >> 2 & 7)),
            0xE000_E300..=0xE000_E31F => Ok(nvic.bank(Irq::Active, address >> 2 & 7)),
            0xE000_E400..=0xE000_E4EF => {
                let first = exception::EXTERNAL + (address & 0xFF) as u16;
                Ok(u32::from_le_bytes(std::array::from_fn(|n| {
                    nvic.priority(first + n as u16)
                })))
            }
            0xE000_ED04 => Ok(u32::from(nvic.candidate().map_or(0, |c| c.0)) << 12
                | u32::from(nvic.is_pending(exception::SYS_TICK)) << 26
                | u32::from(nvic.is_pending(exception::PEND_SV)) << 28),
            0xE000_ED0C => Ok(0xFA05_0000 | u32::from(nvic.group()) << 8),
            0xE000_ED18..=0xE000_ED23 => {
                let first = (address - 0xE000_ED14) as u16;
                Ok(u32::from_le_bytes(std::array::from_fn(|n| {
                    nvic.priority(first + n as u16)
                })))
            }
            0xE000_E000..=0xE000_EFFF => self.core.scs.read(address & 0xFFF),
            0xE004_2000..=0xE004_23FF => self.read(address, 4),
            _ => Err(Misuse::NoPeripheral { address }),
        }
    }

    fn read_dwt(&self, offset: u32) -> Result<u32, Misuse> {
        let counting = self.core.dwt[0x0] & 1 != 0;
        if offset != 4 || !counting {
            return self.core.dwt.read(offset);
        }
        Ok((self.cycle_counter() as u32).wrapping_sub(self.core.dwt[0x4]))
    }

    /// Value of CYCCNT: core cycles, or executed instructions in a benchmark.
    fn cycle_counter(&self) -> u64 {
        if self.core.count_instructions {
            self.core.exact_instructions()
        } else {
            self.now / self.clocks().bus
        }
    }

    /// A store to the private peripheral bus.
    pub(super) fn write_system(
        &mut self,
        address: u32,
        size: usize,
        value: u32,
    ) -> Result<(), Misuse> {
        let clocks = self.clocks();
        let byte_wise = matches!(address, 0xE000_E400..=0xE000_E4EF | 0xE000_ED18..=0xE000_ED23);
        if size != 4 && !byte_wise {
            return Err(Misuse::Width {
                peripheral: "SCS",
                offset: address & 0xFFF,
                size,
            });
        }
        let interrupts = |address: u32| {
            let first = 32 * (address >> 2 & 7) as u16;
            (0..32)
                .filter(move |n| value >> n & 1 != 0)
                .map(move |n| first + n)
                .filter(|&i| i < INTERRUPTS)
        };
        let external = |interrupt: u16| exception::EXTERNAL + interrupt;
        match address {
            0xE000_1000..=0xE000_1FFF => match address & 0xFFF {
                4 => self.core.dwt[4] = (self.cycle_counter() as u32).wrapping_sub(value),
                offset => self.core.dwt.write(offset, value | 0x4000_0000)?,
            },
            0xE000_E010..=0xE000_E01F => self.core.systick.write(address & 0xF, value, clocks),
            0xE000_E100..=0xE000_E11F => {
                interrupts(address).for_each(|i| self.core.nvic.set_enabled(external(i), true))
            }
            0xE000_E180..=0xE000_E19F => {
                interrupts(address).for_each(|i| self.core.nvic.set_enabled(external(i), false))
            }
            0xE000_E200..=0xE000_E21F => {
                interrupts(address).for_each(|i| self.core.nvic.set_pending(external(i), true))
            }
            0xE000_E280..=0xE000_E29F => {
                interrupts(address).for_each(|i| self.core.nvic.set_pending(external(i), false))
            }
            0xE000_EF00 if value < u32::from(INTERRUPTS) => {
                self.core.nvic.set_pending(external(value as u16), true)
            }
            0xE000_E400..=0xE000_E4EF => {
                for n in 0..size as u32 {
                    self.core.nvic.set_priority(
                        external((address + n - 0xE000_E400) as u16),
                        (value >> (8 * n)) as u8,
                    );
                }
            }
            0xE000_ED18..=0xE000_ED23 => {
                for n in 0..size as u32 {
                    self.core
                        .nvic
                        .set_priority((address + n - 0xE000_ED14) as u16, (value >> (8 * n)) as u8);
                }
            }
            0xE000_ED04 => {
                for (bit, exception, pending) in [
                    (28, exception::PEND_SV, true),
                    (27, exception::PEND_SV, false),
                    (26, exception::SYS_TICK, true),
                    (25, exception::SYS_TICK, false),
                    (31, exception::NMI, true),
                ] {
                    if value >> bit & 1 != 0 {
                        self.core.nvic.set_pending(exception, pending);
                    }
                }
            }
            0xE000_ED0C if value >> 16 == 0x05FA => {
                self.core.nvic.set_group((value >> 8) as u8);
                if value & 4 != 0 {
                    self.reset_request = Some(ResetCause::Software);
                }
            }
            0xE000_ED0C => {}
            0xE000_E000..=0xE000_EFFF => self.write_scs(address & 0xFFF, value)?,
            0xE004_2000..=0xE004_23FF => self.write(address, size, value)?,
            _ => return Err(Misuse::NoPeripheral { address }),
        }
        self.reschedule();
        Ok(())
    }

    fn write_scs(&mut self, offset: u32, value: u32) -> Result<(), Misuse> {
        match offset {
            CFSR | HFSR | DFSR => self.core.scs[offset] &= !value,
            MPU_CTRL if value & 1 != 0 => {
                return Err(self.core.scs.unsupported(
                    offset,
                    value,
                    "memory protection is not modelled",
                ));
            }
            SHCSR => {
                self.core.scs[SHCSR] = value & 0x7_0000;
                for (bit, fault) in [
                    (16, exception::MEM_MANAGE),
                    (17, exception::BUS_FAULT),
                    (18, exception::USAGE_FAULT),
                ] {
                    self.core.nvic.set_enabled(fault, value >> bit & 1 != 0);
                }
            }
            _ => self.core.scs.write(offset, value)?,
        }
        Ok(())
    }

    /// The firmware has switched the floating-point unit on; its instructions run regardless.
    #[must_use]
    pub fn fpu_enabled(&self) -> bool {
        self.core.scs[CPACR] >> 20 & 0xF == 0xF
    }
}
