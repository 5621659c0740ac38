// SPDX-License-Identifier: GPL-2.0-only
//! The memories as the core sees them: RAM at its addresses, flash at two, system memory.

use super::Map;
use palpate::app::storage::store::{PAGE, PAGES};

/// RAM and system memory. The flash belongs to its controller.
pub(super) struct Memory {
    ram: Box<[u8; Map::RAM_SIZE as usize]>,
    system: Vec<u8>,
    /// Part of the RAM, as offsets, that code was translated from.
    code: (u32, u32),
    /// That part was written since.
    pub(super) code_changed: bool,
}

impl Memory {
    pub(super) fn new() -> Self {
        let mut system = vec![0; Map::SYSTEM_SIZE as usize];
        // Unique identity and flash size in KiB.
        system[0x7590..0x759C].copy_from_slice(b"EMULATED\0\0\0\0");
        system[0x75E0..0x75E2].copy_from_slice(&128u16.to_le_bytes());
        Self {
            ram: Box::new([0; Map::RAM_SIZE as usize]),
            system,
            code: (0, 0),
            code_changed: false,
        }
    }

    /// Notes that code was translated from this range of the CCM SRAM.
    pub(super) fn holds_code(&mut self, start: u32, end: u32) {
        let (from, to) = (
            Map::CCM_ALIAS + (start - Map::CCM),
            Map::CCM_ALIAS + (end - Map::CCM),
        );
        self.code = match self.code {
            (0, 0) => (from, to),
            (low, high) => (low.min(from), high.max(to)),
        };
    }

    /// Forgets which part holds code.
    pub(super) fn forget_code(&mut self) {
        self.code = (0, 0);
        self.code_changed = false;
    }

    /// Offset in the RAM if `N` bytes at an address lie in it.
    #[inline(always)]
    fn offset<const N: usize>(address: u32) -> Option<usize> {
        let offset = address.wrapping_sub(Map::RAM);
        if offset <= Map::RAM_SIZE - N as u32 {
            return Some(offset as usize);
        }
        let offset = address.wrapping_sub(Map::CCM);
        (offset <= Map::CCM_SIZE - N as u32).then_some((offset + Map::CCM_ALIAS) as usize)
    }

    /// Bytes of the RAM; `None` if they lie elsewhere.
    #[inline(always)]
    pub(super) fn load<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        let offset = Self::offset::<N>(address)?;
        self.ram.get(offset..)?.first_chunk().copied()
    }

    /// Stores into the RAM; `None` if it is elsewhere.
    #[inline(always)]
    pub(super) fn store<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> Option<()> {
        let offset = Self::offset::<N>(address)?;
        *self.ram.get_mut(offset..)?.first_chunk_mut()? = bytes;
        self.note(offset as u32, N as u32);
        Some(())
    }

    /// Words of the RAM; `None` if part of them lies elsewhere.
    #[inline]
    pub(super) fn words(&self, address: u32, count: u32) -> Option<&[[u8; 4]]> {
        let place = Self::place(address, 4 * count as usize)?;
        Some(self.ram.get(place)?.as_chunks().0)
    }

    /// Words of the RAM to be stored; `None` if part of them lies elsewhere.
    #[inline]
    pub(super) fn words_mut(&mut self, address: u32, count: u32) -> Option<&mut [[u8; 4]]> {
        let place = Self::place(address, 4 * count as usize)?;
        self.note(place.start as u32, 4 * count);
        Some(self.ram.get_mut(place)?.as_chunks_mut().0)
    }

    #[inline(always)]
    fn note(&mut self, offset: u32, length: u32) {
        let (low, high) = self.code;
        if offset < high && offset + length > low {
            self.code_changed = true;
        }
    }

    /// Where a range of addresses lies in the RAM; `None` if part of it is not RAM.
    #[inline]
    fn place(address: u32, length: usize) -> Option<std::ops::Range<usize>> {
        let start = Map::ram_offset(address)? as usize;
        let end = if address >= Map::RAM {
            Map::RAM_SIZE
        } else {
            Map::CCM_ALIAS + Map::CCM_SIZE
        } as usize;
        let to = start.checked_add(length)?;
        (to <= end).then_some(start..to)
    }

    /// Copies out of the RAM; `None` if part of the range is not RAM.
    pub(super) fn read(&self, address: u32, into: &mut [u8]) -> Option<()> {
        into.copy_from_slice(self.ram.get(Self::place(address, into.len())?)?);
        Some(())
    }

    /// Copies into the RAM; `None` if part of the range is not RAM.
    pub(super) fn write(&mut self, address: u32, bytes: &[u8]) -> Option<()> {
        let place = Self::place(address, bytes.len())?;
        let start = place.start as u32;
        self.ram.get_mut(place)?.copy_from_slice(bytes);
        self.note(start, bytes.len() as u32);
        Some(())
    }

    /// Bytes of the system memory; `None` if part of the range lies elsewhere.
    pub(super) fn system(&self, address: u32, length: usize) -> Option<&[u8]> {
        let start = address.checked_sub(Map::SYSTEM)? as usize;
        self.system.get(start..start.checked_add(length)?)
    }
}

/// The flash without its last pages, where a firmware keeps records and where damaged double words are looked for.
pub(super) const PROGRAM_SIZE: u32 = Map::FLASH_SIZE - (PAGES * PAGE) as u32;

/// Offset in the flash of an address in either of its two ranges.
#[inline]
pub(super) fn flash_offset(address: u32) -> Option<u32> {
    let offset = address & !Map::FLASH;
    (offset < Map::FLASH_SIZE).then_some(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_memory_at_two_addresses() {
        let mut ram = Memory::new();
        assert_eq!(ram.write(Map::CCM, &[7]), Some(()));
        let mut byte = [0];
        assert_eq!(ram.read(Map::RAM + Map::CCM_ALIAS, &mut byte), Some(()));
        assert_eq!(byte, [7]);
        assert_eq!(ram.write(Map::RAM + Map::RAM_SIZE - 1, &[1, 2]), None);
        assert_eq!(ram.write(Map::CCM + Map::CCM_SIZE, &[1]), None);
        assert_eq!(ram.read(Map::RAM - 1, &mut byte), None);
        assert_eq!(ram.load::<4>(Map::RAM + Map::RAM_SIZE - 3), None);
        assert_eq!(ram.store(Map::CCM + 4, [1, 2]), Some(()));
        assert_eq!(ram.load(Map::RAM + Map::CCM_ALIAS + 4), Some([1, 2]));
    }

    #[test]
    fn a_store_over_code_is_noticed_at_both_addresses() {
        for base in [Map::CCM, Map::RAM + Map::CCM_ALIAS] {
            let mut ram = Memory::new();
            ram.holds_code(Map::CCM + 0x100, Map::CCM + 0x104);
            for (offset, noticed) in [(0xFC, false), (0x104, false), (0xFE, true)] {
                ram.store(base + offset, [0; 4]);
                assert_eq!(ram.code_changed, noticed, "{offset:#x}");
            }
        }
    }

    #[test]
    fn the_flash_is_at_two_addresses() {
        assert_eq!(flash_offset(Map::FLASH + 4), Some(4));
        assert_eq!(flash_offset(4), Some(4));
        assert_eq!(flash_offset(Map::FLASH_SIZE), None);
        assert_eq!(flash_offset(Map::RAM), None);
    }
}
