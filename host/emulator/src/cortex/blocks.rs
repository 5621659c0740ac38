// SPDX-License-Identifier: GPL-2.0-only
//! Cache of decoded blocks; consistent with the code that the firmware copies into CCM SRAM.

use super::Map;
use super::decode::{Block, Memory};

/// Decoded blocks by start address.
#[derive(Debug)]
pub struct Blocks {
    flash: Vec<Block>,
    ccm: Vec<Block>,
    /// Whether the CCM SRAM was written after its blocks were decoded.
    ccm_changed: bool,
}

impl Blocks {
    pub(crate) fn new() -> Self {
        Self {
            flash: vec![Block::default(); (Map::FLASH_SIZE / 2) as usize],
            ccm: vec![Block::default(); (Map::CCM_SIZE / 2) as usize],
            ccm_changed: false,
        }
    }

    /// Index of a start address; `None` outside code memory.
    pub(crate) fn slot(&mut self, address: u32) -> Option<&mut Block> {
        let (blocks, start) = match Memory::at(address) {
            Memory::Flash => (&mut self.flash, Map::FLASH),
            Memory::Ccm => (&mut self.ccm, Map::CCM),
        };
        blocks.get_mut((address.wrapping_sub(start) / 2) as usize)
    }

    /// Marks the CCM SRAM as changed.
    pub(crate) fn change_ccm(&mut self) {
        self.ccm_changed = true;
    }

    /// Whether the cached block at this address may be outdated.
    pub(crate) fn is_stale(&self, address: u32) -> bool {
        self.ccm_changed && Memory::at(address) == Memory::Ccm
    }

    /// Drops blocks in CCM SRAM if it has changed, and returns whether it has; watched functions stay watched.
    pub(crate) fn forget_stale(&mut self) -> bool {
        if !std::mem::take(&mut self.ccm_changed) {
            return false;
        }
        for block in &mut self.ccm {
            *block = Block {
                watch: block.watch,
                ..Block::default()
            };
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_exists_where_code_runs() {
        let mut blocks = Blocks::new();
        assert!(blocks.slot(Map::CCM).is_some() && blocks.slot(Map::FLASH).is_some());
        assert!(blocks.slot(Map::CCM + Map::CCM_SIZE).is_none());
    }
}
