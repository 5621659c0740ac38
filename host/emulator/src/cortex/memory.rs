// SPDX-License-Identifier: GPL-2.0-only
//! The RAM, which the engine sees at two addresses: the only place that needs `unsafe`.

use std::cell::UnsafeCell;
use std::rc::Rc;

use unicorn_engine::{Prot, Unicorn, uc_error};

use super::Map;

/// Host memory behind the chip's RAM. One handle to it must outlive the engine it is mapped into.
#[derive(Clone)]
pub(super) struct Ram {
    words: Rc<[UnsafeCell<u64>]>,
}

impl Ram {
    pub(super) fn new() -> Self {
        Self {
            words: (0..Map::RAM_SIZE / 8).map(|_| UnsafeCell::new(0)).collect(),
        }
    }

    /// Maps the RAM at its own address, and its last part again at that of the CCM SRAM. Code may run only there, because stores
    /// to a page with code are slow. The engine detects changed code if it is stored at the address it runs from, not through the
    /// alias.
    #[allow(unsafe_code)]
    pub(super) fn map<D>(&self, engine: &mut Unicorn<'_, D>) -> Result<(), uc_error> {
        let data = Prot::READ | Prot::WRITE;
        let alias = &self.words[Map::CCM_ALIAS as usize / 8..];
        // SAFETY: both ranges lie within `words`, whose heap block does not move and lives as long as the engine,
        // because `Engine` owns both and drops the engine first. The cells allow writes from outside.
        unsafe {
            engine.mem_map_ptr(
                Map::RAM.into(),
                Map::RAM_SIZE.into(),
                data,
                self.words[0].get().cast(),
            )?;
            engine.mem_map_ptr(
                Map::CCM.into(),
                Map::CCM_SIZE.into(),
                Prot::READ | Prot::EXEC,
                alias[0].get().cast(),
            )
        }
    }

    /// Where a range of the chip's addresses lies in the host memory; `None` if part of it is not RAM.
    fn place(&self, address: u32, length: usize) -> Option<*mut u8> {
        let start = Map::ram_offset(address)? as usize;
        let end = if address >= Map::RAM {
            Map::RAM_SIZE
        } else {
            Map::CCM_ALIAS + Map::CCM_SIZE
        } as usize;
        let inside = start.checked_add(length).is_some_and(|to| to <= end);
        inside.then(|| self.words[0].get().cast::<u8>().wrapping_add(start))
    }

    /// Copies out of the RAM; `None` if part of the range is not RAM.
    #[allow(unsafe_code)]
    pub(super) fn read(&self, address: u32, into: &mut [u8]) -> Option<()> {
        let place = self.place(address, into.len())?;
        // SAFETY: `place` has checked that the range lies within the heap block; the engine runs on this thread alone,
        // so nothing writes meanwhile; a slice of the caller cannot overlap it.
        unsafe { std::ptr::copy_nonoverlapping(place, into.as_mut_ptr(), into.len()) };
        Some(())
    }

    /// Copies into the RAM; `None` if part of the range is not RAM.
    #[allow(unsafe_code)]
    pub(super) fn write(&self, address: u32, bytes: &[u8]) -> Option<()> {
        let place = self.place(address, bytes.len())?;
        // SAFETY: as in `read`.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), place, bytes.len()) };
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_memory_at_two_addresses() {
        let ram = Ram::new();
        let mut byte = [0];
        assert_eq!(ram.write(Map::CCM, &[7]), Some(()));
        assert_eq!(ram.read(Map::RAM + Map::CCM_ALIAS, &mut byte), Some(()));
        assert_eq!(byte, [7]);
        assert_eq!(ram.write(Map::RAM + Map::RAM_SIZE - 1, &[1, 2]), None);
        assert_eq!(ram.write(Map::CCM + Map::CCM_SIZE, &[1]), None);
        assert_eq!(ram.read(Map::RAM - 1, &mut byte), None);
    }
}
