// SPDX-License-Identifier: GPL-2.0-only
//! The address map: where each modelled peripheral lives and which clock gate it needs.

use super::bank::Register;
use super::rcc::Gate;
use super::{dma, gpio, timer};

/// A modelled peripheral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Device {
    Rcc,
    Pwr,
    Flash,
    Gpio(usize),
    Exti,
    Syscfg,
    Dbgmcu,
    Dma(usize),
    Tim1,
    Timer(usize),
    Adc(usize),
    AdcCommon,
    Uart(usize),
    Iwdg,
    Cordic,
}

impl Device {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Rcc => "RCC",
            Self::Pwr => "PWR",
            Self::Flash => "FLASH",
            Self::Gpio(port) => gpio::NAMES[port],
            Self::Exti => "EXTI",
            Self::Syscfg => "SYSCFG",
            Self::Dbgmcu => "DBGMCU",
            Self::Dma(n) => ["DMA1", "DMA2", "DMAMUX"][n],
            Self::Tim1 => "TIM1",
            Self::Timer(n) => super::GENERAL[n].0,
            Self::Adc(n) => ["ADC1", "ADC2"][n],
            Self::AdcCommon => "ADC12_COMMON",
            Self::Uart(n) => ["LPUART1", "USART2"][n],
            Self::Iwdg => "IWDG",
            Self::Cordic => "CORDIC",
        }
    }
}

pub(super) const ADC_CCR: u32 = 0x08;
pub(super) const ADC_COMMON: &[Register] =
    &[(0x00, "CSR", 0), (ADC_CCR, "CCR", 0), (0x0C, "CDR", 0)];

const AHB1: u32 = 0x48;
const AHB2: u32 = 0x4C;
const APB1_1: u32 = 0x58;
const APB1_2: u32 = 0x5C;
const APB2: u32 = 0x60;

/// Base address, peripheral, clock gate.
pub(super) const DEVICES: &[(u32, Device, Option<Gate>)] = &[
    (0x4000_0000, Device::Timer(0), Some((APB1_1, 0))),
    (0x4000_0400, Device::Timer(1), Some((APB1_1, 1))),
    (0x4000_0800, Device::Timer(2), Some((APB1_1, 2))),
    (0x4000_1000, Device::Timer(3), Some((APB1_1, 4))),
    (0x4000_1400, Device::Timer(4), Some((APB1_1, 5))),
    (0x4000_3000, Device::Iwdg, None),
    (0x4000_4400, Device::Uart(1), Some((APB1_1, 17))),
    (0x4000_7000, Device::Pwr, Some((APB1_1, 28))),
    (0x4000_8000, Device::Uart(0), Some((APB1_2, 0))),
    (0x4001_0000, Device::Syscfg, Some((APB2, 0))),
    (0x4001_0400, Device::Exti, None),
    (0x4001_2C00, Device::Tim1, Some((APB2, 11))),
    (0x4001_4000, Device::Timer(5), Some((APB2, 16))),
    (0x4001_4400, Device::Timer(6), Some((APB2, 17))),
    (0x4001_4800, Device::Timer(7), Some((APB2, 18))),
    (0x4002_0000, Device::Dma(0), Some((AHB1, 0))),
    (0x4002_0400, Device::Dma(1), Some((AHB1, 1))),
    (0x4002_0800, Device::Dma(2), Some((AHB1, 2))),
    (0x4002_0C00, Device::Cordic, Some((AHB1, 3))),
    (0x4002_1000, Device::Rcc, None),
    (0x4002_2000, Device::Flash, Some((AHB1, 8))),
    (0x4800_0000, Device::Gpio(0), Some((AHB2, 0))),
    (0x4800_0400, Device::Gpio(1), Some((AHB2, 1))),
    (0x4800_0800, Device::Gpio(2), Some((AHB2, 2))),
    (0x4800_0C00, Device::Gpio(3), Some((AHB2, 3))),
    (0x4800_1000, Device::Gpio(4), Some((AHB2, 4))),
    (0x4800_1400, Device::Gpio(5), Some((AHB2, 5))),
    (0x4800_1800, Device::Gpio(6), Some((AHB2, 6))),
    (0x5000_0000, Device::Adc(0), Some((AHB2, 13))),
    (0x5000_0100, Device::Adc(1), Some((AHB2, 13))),
    (0x5000_0300, Device::AdcCommon, Some((AHB2, 13))),
    (0xE004_2000, Device::Dbgmcu, None),
];

/// The device at an address, with its base and gate.
pub(super) fn locate(address: u32) -> Option<(u32, Device, Option<Gate>)> {
    let slot = match address {
        0x4000_0000..0x4003_0000 => (address & 0x3_FFFF) >> 10,
        0x4800_0000..0x4800_2000 => PORTS + ((address & 0x1FFF) >> 10),
        0x5000_0000..0x5000_0400 => ADCS + ((address & 0x3FF) >> 8),
        0xE004_2000..0xE004_2400 => return DEVICES.last().copied(),
        _ => return None,
    };
    let index = usize::from(*SLOTS.get(slot as usize)?);
    DEVICES.get(index).copied()
}

/// First slots of the ports' pages and of the converters' quarters of a page; those of the others come before.
const PORTS: u32 = 192;
const ADCS: u32 = PORTS + 8;

/// Index into the devices by slot; beyond them if there is none.
static SLOTS: [u8; ADCS as usize + 4] = {
    let mut slots = [u8::MAX; ADCS as usize + 4];
    let mut slot = 0;
    while slot < slots.len() as u32 {
        let address = if slot < PORTS {
            0x4000_0000 + (slot << 10)
        } else if slot < ADCS {
            0x4800_0000 + ((slot - PORTS) << 10)
        } else {
            0x5000_0000 + ((slot - ADCS) << 8)
        };
        let mut device = 0;
        while device < DEVICES.len() {
            let base = DEVICES[device].0;
            if base <= address && address - base < 0x400 {
                slots[slot as usize] = device as u8;
            }
            device += 1;
        }
        slot += 1;
    }
    slots
};

/// Names of registers that are often accessed without their clock, for messages.
pub(super) fn register_name(device: Device, offset: u32) -> &'static str {
    let registers = match device {
        Device::Timer(_) | Device::Tim1 => timer::REGISTERS,
        Device::AdcCommon => ADC_COMMON,
        Device::Gpio(_) => gpio::PORT,
        Device::Dma(2) => dma::DMAMUX,
        Device::Dma(_) => dma::DMA,
        _ => &[],
    };
    registers
        .iter()
        .find(|r| r.0 == offset)
        .map_or("(register)", |r| r.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_address_belongs_to_one_peripheral_or_none() {
        assert!(DEVICES.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(locate(0x4001_2C34).map(|d| d.1), Some(Device::Tim1));
        assert_eq!(locate(0x5000_0108).map(|d| d.1), Some(Device::Adc(1)));
        assert_eq!(locate(0x5000_0308).map(|d| d.1), Some(Device::AdcCommon));
        assert_eq!(locate(0x4000_5400), None);
        assert_eq!(locate(0x3FFF_FFFF), None);
        assert_eq!(locate(0xE004_2004).map(|d| d.1), Some(Device::Dbgmcu));
        // What a search finds: the last one that begins before the address, 1 KiB long.
        for address in (0x4000_0000..0x4003_0000u32)
            .chain(0x4800_0000..0x4800_2000)
            .chain(0x5000_0000..0x5000_0400)
            .step_by(4)
        {
            let last = DEVICES.iter().rev().find(|device| device.0 <= address);
            let found = last.filter(|device| address - device.0 < 0x400).copied();
            assert_eq!(locate(address), found, "{address:#x}");
        }
    }
}
