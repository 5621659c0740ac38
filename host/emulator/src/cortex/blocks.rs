// SPDX-License-Identifier: GPL-2.0-only
//! Cache of translated blocks.

use std::collections::{BTreeMap, HashMap};

use super::Map;
use super::memory::PROGRAM_SIZE;
use super::translate::{Code, PAGE};

type Slot = Option<Box<Code>>;

/// Translated blocks by start address.
pub(super) struct Blocks {
    flash: Vec<Slot>,
    /// The flash at its second address, from zero.
    alias: Vec<Slot>,
    ccm: Vec<Slot>,
    /// Those that start within an IT block: by address and state.
    in_it: HashMap<(u32, u8), Box<Code>>,
    /// Numbers of watched functions by address.
    watched: BTreeMap<u32, u16>,
}

fn empty(bytes: u32) -> Vec<Slot> {
    std::iter::repeat_with(|| None)
        .take((bytes / 2) as usize)
        .collect()
}

impl Blocks {
    pub(super) fn new() -> Self {
        Self {
            flash: empty(Map::FLASH_SIZE),
            alias: empty(Map::FLASH_SIZE),
            ccm: empty(Map::CCM_SIZE),
            in_it: HashMap::new(),
            watched: BTreeMap::new(),
        }
    }

    /// The block that starts at an address in an IT state, if it was translated.
    #[inline(always)]
    pub(super) fn find(&self, address: u32, it: u8) -> Option<&Code> {
        if it != 0 {
            return self.in_it.get(&(address, it)).map(|code| &**code);
        }
        let offset = address.wrapping_sub(Map::FLASH);
        if offset < Map::FLASH_SIZE {
            return self.flash.get((offset / 2) as usize)?.as_deref();
        }
        let offset = address.wrapping_sub(Map::CCM);
        let slots = if offset < Map::CCM_SIZE {
            &self.ccm
        } else {
            &self.alias
        };
        let offset = if offset < Map::CCM_SIZE {
            offset
        } else {
            address
        };
        slots.get((offset / 2) as usize)?.as_deref()
    }

    fn slot(&mut self, address: u32) -> Option<&mut Slot> {
        let (slots, start) = if address.wrapping_sub(Map::FLASH) < Map::FLASH_SIZE {
            (&mut self.flash, Map::FLASH)
        } else if address.wrapping_sub(Map::CCM) < Map::CCM_SIZE {
            (&mut self.ccm, Map::CCM)
        } else {
            (&mut self.alias, 0)
        };
        slots.get_mut(((address - start) / 2) as usize)
    }

    /// Keeps a block that starts in this IT state.
    pub(super) fn keep(&mut self, mut code: Code, it: u8) {
        let start = code.start;
        code.cost.watch = self.watched.get(&start).copied().unwrap_or(0);
        if it != 0 {
            self.in_it.insert((start, it), Box::new(code));
        } else if let Some(slot) = self.slot(start) {
            *slot = Some(Box::new(code));
        }
    }

    /// Whether functions are watched.
    pub(super) fn watches(&self) -> bool {
        !self.watched.is_empty()
    }

    /// Marks a watched function from now on: blocks do not know it.
    pub(super) fn watch(&mut self, address: u32, number: u16) {
        self.watched.insert(address, number);
        self.forget_flash(0, 0);
    }

    /// Drops the blocks in CCM SRAM.
    pub(super) fn forget_ccm(&mut self) {
        self.ccm.fill_with(|| None);
        self.in_it.clear();
    }

    /// Drops blocks that may reach into a range of the flash, or all if some may hold literals from there.
    pub(super) fn forget_flash(&mut self, start: usize, length: usize) {
        if start < PROGRAM_SIZE as usize {
            self.flash.fill_with(|| None);
            self.alias.fill_with(|| None);
            self.forget_ccm();
            return;
        }
        let first = start.saturating_sub(PAGE as usize + 2) / 2;
        let end = (start + length).div_ceil(2);
        for slots in [&mut self.flash, &mut self.alias] {
            let end = end.min(slots.len());
            if let Some(changed) = slots.get_mut(first..end) {
                changed.fill_with(|| None);
            }
        }
        self.in_it.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::translate::{How, translate};
    use super::*;

    fn at(start: u32) -> Code {
        // bx lr
        translate(start, 0, How::Joined, &|_| Some(0x4770)).expect("code")
    }

    #[test]
    fn blocks_are_kept_where_code_runs() {
        let mut blocks = Blocks::new();
        for start in [
            0x100,
            Map::CCM,
            Map::FLASH,
            Map::FLASH + Map::FLASH_SIZE - 2,
        ] {
            assert!(blocks.find(start, 0).is_none());
            blocks.keep(at(start), 0);
            assert_eq!(blocks.find(start, 0).map(|code| code.start), Some(start));
        }
        blocks.keep(at(Map::CCM + Map::CCM_SIZE), 0);
        assert!(blocks.find(Map::CCM + Map::CCM_SIZE, 0).is_none());
    }

    #[test]
    fn changed_code_is_dropped_and_watched_functions_stay_watched() {
        let mut blocks = Blocks::new();
        blocks.watch(Map::CCM, 3);
        let program = Map::FLASH + 0x1000;
        let records = Map::FLASH + PROGRAM_SIZE;
        let (before, after) = (records + 0x800, records + 0x1000);
        let all = [Map::CCM, program, before, after];
        for start in all {
            blocks.keep(at(start), 0);
        }
        blocks.forget_flash(PROGRAM_SIZE as usize + 0x900, 8);
        let kept = all.map(|start| blocks.find(start, 0).is_some());
        assert_eq!(kept, [true, true, false, true]);
        blocks.forget_ccm();
        assert!(blocks.find(Map::CCM, 0).is_none());
        blocks.keep(at(Map::CCM), 0);
        // Literals of the program may be anywhere.
        blocks.forget_flash(0x8000, 8);
        assert!(all.iter().all(|&start| blocks.find(start, 0).is_none()));
        blocks.keep(at(Map::CCM), 0);
        assert_eq!(
            blocks.find(Map::CCM, 0).map(|code| code.cost.watch),
            Some(3)
        );
    }
}
