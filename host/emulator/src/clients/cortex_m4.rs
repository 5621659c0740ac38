// SPDX-License-Identifier: GPL-2.0-only
//! The core in GDB's terms: M profile with both stack pointers and single-precision floating point.

use gdbstub::arch::{Arch, Registers};

use crate::cortex::debug::CoreRegisters;

/// Cortex-M4F.
pub enum CortexM4 {}

impl Arch for CortexM4 {
    type Usize = u32;
    type Registers = CoreRegisters;
    type BreakpointKind = usize;
    type RegId = ();

    fn target_description_xml() -> Option<&'static str> {
        Some(DESCRIPTION)
    }
}

impl Registers for CoreRegisters {
    type ProgramCounter = u32;

    fn pc(&self) -> u32 {
        self.core[15]
    }

    fn gdb_serialize(&self, mut write_byte: impl FnMut(Option<u8>)) {
        let words =
            |words: &[u32]| -> Vec<u8> { words.iter().flat_map(|w| w.to_le_bytes()).collect() };
        let double: Vec<u8> = self.double.iter().flat_map(|d| d.to_le_bytes()).collect();
        let parts = [
            words(&self.core),
            words(&self.stacks),
            double,
            words(&[self.fpscr]),
        ];
        for byte in parts.into_iter().flatten() {
            write_byte(Some(byte));
        }
    }

    fn gdb_deserialize(&mut self, bytes: &[u8]) -> Result<(), ()> {
        let mut rest = bytes;
        for word in self.core.iter_mut().chain(&mut self.stacks) {
            let (first, others) = rest.split_first_chunk().ok_or(())?;
            (*word, rest) = (u32::from_le_bytes(*first), others);
        }
        for double in &mut self.double {
            let (first, others) = rest.split_first_chunk().ok_or(())?;
            (*double, rest) = (u64::from_le_bytes(*first), others);
        }
        let (first, _) = rest.split_first_chunk().ok_or(())?;
        self.fpscr = u32::from_le_bytes(*first);
        Ok(())
    }
}

const DESCRIPTION: &str = r#"<?xml version="1.0"?>
<!DOCTYPE target SYSTEM "gdb-target.dtd">
<target version="1.0">
<architecture>arm</architecture>
<feature name="org.gnu.gdb.arm.m-profile">
<reg name="r0" bitsize="32"/><reg name="r1" bitsize="32"/><reg name="r2" bitsize="32"/><reg name="r3" bitsize="32"/>
<reg name="r4" bitsize="32"/><reg name="r5" bitsize="32"/><reg name="r6" bitsize="32"/><reg name="r7" bitsize="32"/>
<reg name="r8" bitsize="32"/><reg name="r9" bitsize="32"/><reg name="r10" bitsize="32"/><reg name="r11" bitsize="32"/>
<reg name="r12" bitsize="32"/>
<reg name="sp" bitsize="32" type="data_ptr"/>
<reg name="lr" bitsize="32"/>
<reg name="pc" bitsize="32" type="code_ptr"/>
<reg name="xpsr" bitsize="32"/>
</feature>
<feature name="org.gnu.gdb.arm.m-system">
<reg name="msp" bitsize="32" type="data_ptr"/>
<reg name="psp" bitsize="32" type="data_ptr"/>
</feature>
<feature name="org.gnu.gdb.arm.vfp">
<reg name="d0" bitsize="64" type="ieee_double"/><reg name="d1" bitsize="64" type="ieee_double"/>
<reg name="d2" bitsize="64" type="ieee_double"/><reg name="d3" bitsize="64" type="ieee_double"/>
<reg name="d4" bitsize="64" type="ieee_double"/><reg name="d5" bitsize="64" type="ieee_double"/>
<reg name="d6" bitsize="64" type="ieee_double"/><reg name="d7" bitsize="64" type="ieee_double"/>
<reg name="d8" bitsize="64" type="ieee_double"/><reg name="d9" bitsize="64" type="ieee_double"/>
<reg name="d10" bitsize="64" type="ieee_double"/><reg name="d11" bitsize="64" type="ieee_double"/>
<reg name="d12" bitsize="64" type="ieee_double"/><reg name="d13" bitsize="64" type="ieee_double"/>
<reg name="d14" bitsize="64" type="ieee_double"/><reg name="d15" bitsize="64" type="ieee_double"/>
<reg name="fpscr" bitsize="32" type="int" group="float"/>
</feature>
</target>"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_survive_the_wire() {
        let mut registers = CoreRegisters::default();
        registers.core[15] = 0x0800_1234;
        registers.stacks[1] = 0x2000_3000;
        registers.double[15] = 0x0123_4567_89AB_CDEF;
        registers.fpscr = 7;
        let mut wire = Vec::new();
        registers.gdb_serialize(|byte| wire.extend(byte));
        assert_eq!(wire.len(), 17 * 4 + 2 * 4 + 16 * 8 + 4);
        let mut read = CoreRegisters::default();
        assert_eq!(read.gdb_deserialize(&wire), Ok(()));
        assert_eq!(read, registers);
        assert_eq!(read.gdb_deserialize(&wire[1..]), Err(()));
    }
}
