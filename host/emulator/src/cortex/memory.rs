// SPDX-License-Identifier: GPL-2.0-only
//! The RAM, which the engine sees at two addresses: the only place that needs `unsafe`.

use unicorn_engine::{Prot, Unicorn, uc_error};

use super::Map;

/// Host memory behind the chip's RAM. Must outlive the engine it is mapped into.
#[derive(Debug)]
pub(super) struct Ram {
    bytes: Box<[u64]>,
}

impl Ram {
    pub(super) fn new() -> Self {
        Self {
            bytes: vec![0; Map::RAM_SIZE as usize / 8].into_boxed_slice(),
        }
    }

    /// Maps the RAM at its own address and its last part at that of the CCM SRAM.
    #[allow(unsafe_code)]
    pub(super) fn map<D>(&mut self, engine: &mut Unicorn<'_, D>) -> Result<(), uc_error> {
        let start = self.bytes.as_mut_ptr();
        let alias = self.bytes[Map::CCM_ALIAS as usize / 8..].as_mut_ptr();
        // SAFETY: both ranges lie within `bytes`, whose heap block does not move and lives as long as the engine,
        // because `Engine` owns both and drops the engine first. Nothing else reads or writes the block.
        unsafe {
            engine.mem_map_ptr(
                Map::RAM.into(),
                Map::RAM_SIZE.into(),
                Prot::ALL,
                start.cast(),
            )?;
            engine.mem_map_ptr(
                Map::CCM.into(),
                Map::CCM_SIZE.into(),
                Prot::ALL,
                alias.cast(),
            )
        }
    }
}
