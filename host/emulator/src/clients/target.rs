// SPDX-License-Identifier: GPL-2.0-only
//! GDB's requests to the machine: registers, memory, breakpoints, single steps.

use gdbstub::common::Signal;
use gdbstub::target::ext::base::BaseOps;
use gdbstub::target::ext::base::singlethread::{
    SingleThreadBase, SingleThreadResume, SingleThreadResumeOps, SingleThreadSingleStep,
    SingleThreadSingleStepOps,
};
use gdbstub::target::ext::breakpoints::{
    Breakpoints, BreakpointsOps, HwBreakpoint, HwBreakpointOps, SwBreakpoint, SwBreakpointOps,
};
use gdbstub::target::ext::monitor_cmd::{ConsoleOutput, MonitorCmd, MonitorCmdOps, outputln};
use gdbstub::target::{Target, TargetError, TargetResult};

use super::cortex_m4::CortexM4;
use crate::cortex::debug::CoreRegisters;
use crate::{Error, Machine, ResetCause};

impl Target for Machine<'_> {
    type Arch = CortexM4;
    type Error = Error;

    fn base_ops(&mut self) -> BaseOps<'_, Self::Arch, Self::Error> {
        BaseOps::SingleThread(self)
    }

    fn support_breakpoints(&mut self) -> Option<BreakpointsOps<'_, Self>> {
        Some(self)
    }

    fn support_monitor_cmd(&mut self) -> Option<MonitorCmdOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadBase for Machine<'_> {
    fn read_registers(&mut self, registers: &mut CoreRegisters) -> TargetResult<(), Self> {
        *registers = self.engine_mut().core_registers();
        Ok(())
    }

    fn write_registers(&mut self, registers: &CoreRegisters) -> TargetResult<(), Self> {
        self.engine_mut().set_core_registers(registers);
        Ok(())
    }

    fn read_addrs(&mut self, address: u32, into: &mut [u8]) -> TargetResult<usize, Self> {
        match self.engine_mut().peek(address, into) {
            0 if !into.is_empty() => Err(TargetError::NonFatal),
            read => Ok(read),
        }
    }

    fn write_addrs(&mut self, address: u32, bytes: &[u8]) -> TargetResult<(), Self> {
        if self.engine_mut().write(address, bytes) {
            Ok(())
        } else {
            Err(TargetError::NonFatal)
        }
    }

    fn support_resume(&mut self) -> Option<SingleThreadResumeOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadResume for Machine<'_> {
    fn resume(&mut self, _signal: Option<Signal>) -> Result<(), Error> {
        self.engine_mut().resume(false);
        Ok(())
    }

    fn support_single_step(&mut self) -> Option<SingleThreadSingleStepOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadSingleStep for Machine<'_> {
    fn step(&mut self, _signal: Option<Signal>) -> Result<(), Error> {
        self.engine_mut().resume(true);
        Ok(())
    }
}

impl Breakpoints for Machine<'_> {
    fn support_sw_breakpoint(&mut self) -> Option<SwBreakpointOps<'_, Self>> {
        Some(self)
    }

    fn support_hw_breakpoint(&mut self) -> Option<HwBreakpointOps<'_, Self>> {
        Some(self)
    }
}

// Software and hardware breakpoints are the same here: neither changes memory, and their number is not limited.

impl SwBreakpoint for Machine<'_> {
    fn add_sw_breakpoint(&mut self, address: u32, _size: usize) -> TargetResult<bool, Self> {
        self.engine_mut().set_breakpoint(address);
        Ok(true)
    }

    fn remove_sw_breakpoint(&mut self, address: u32, _size: usize) -> TargetResult<bool, Self> {
        Ok(self.engine_mut().clear_breakpoint(address))
    }
}

impl HwBreakpoint for Machine<'_> {
    fn add_hw_breakpoint(&mut self, address: u32, size: usize) -> TargetResult<bool, Self> {
        self.add_sw_breakpoint(address, size)
    }

    fn remove_hw_breakpoint(&mut self, address: u32, size: usize) -> TargetResult<bool, Self> {
        self.remove_sw_breakpoint(address, size)
    }
}

impl MonitorCmd for Machine<'_> {
    fn handle_monitor_cmd(
        &mut self,
        command: &[u8],
        mut out: ConsoleOutput<'_>,
    ) -> Result<(), Error> {
        match command {
            b"reset" | b"reset halt" => {
                self.reset(ResetCause::Pin)?;
                outputln!(out, "reset; held before the first instruction");
            }
            b"time" => outputln!(out, "{:.6} s since power-on", self.time_s()),
            _ => outputln!(out, "monitor reset | time"),
        }
        Ok(())
    }
}
