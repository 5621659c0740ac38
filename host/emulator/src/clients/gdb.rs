// SPDX-License-Identifier: GPL-2.0-only
//! GDB server. Connecting halts the core; while it is halted, time stops for chip and world, so that no watchdog resets and the
//! finger does not move.

use std::net::{TcpListener, TcpStream};

use gdbstub::common::Signal;
use gdbstub::conn::ConnectionExt;
use gdbstub::stub::state_machine::GdbStubStateMachine;
use gdbstub::stub::{GdbStub, GdbStubError, SingleThreadStopReason};

use super::{listen, port_of};
use crate::sim::Session;
use crate::{Error, Machine};

type Stub<'f> = GdbStubStateMachine<'static, Machine<'f>, TcpStream>;
type Served<'f> = Result<Stub<'f>, GdbStubError<Error, std::io::Error>>;

/// The server; one debugger at a time.
pub struct GdbServer<'f> {
    listener: TcpListener,
    stub: Option<Stub<'f>>,
}

impl<'f> GdbServer<'f> {
    /// Listens on a port, 0 for any that is free.
    ///
    /// # Errors
    /// The port cannot be opened.
    pub fn listen(port: u16) -> Result<Self, Error> {
        Ok(Self {
            listener: listen(port)?,
            stub: None,
        })
    }

    /// The port it listens on.
    #[must_use]
    pub fn port(&self) -> u16 {
        port_of(&self.listener)
    }

    /// Serves the debugger; true while the core may run. Call it once a millisecond of simulated time, and regularly while the
    /// core is halted.
    ///
    /// # Errors
    /// The instruction engine fails. Errors of the connection only close it, and the core runs on.
    pub fn serve(&mut self, session: &mut Session<'f>) -> Result<bool, Error> {
        let held = session.held.take();
        let machine = &mut session.machine;
        let stub = match self.stub.take() {
            Some(stub) => stub,
            None => match self.listener.accept() {
                Ok((stream, _)) => match GdbStub::new(stream).run_state_machine(machine) {
                    Ok(stub) => stub,
                    Err(_) => return Ok(true),
                },
                Err(_) => return Ok(true),
            },
        };
        match stopped(stub, machine, held).and_then(|stub| exchange(stub, machine)) {
            Ok(None | Some(GdbStubStateMachine::Disconnected(_))) => {}
            Ok(Some(stub)) => {
                let runs = matches!(stub, GdbStubStateMachine::Running(_));
                self.stub = Some(stub);
                return Ok(runs);
            }
            Err(failure) => eprintln!("gdb: {failure}; the connection is closed"),
        }
        machine.engine_mut().clear_breakpoints();
        Ok(true)
    }
}

/// Reports to the debugger that the core is halted.
fn stopped<'f>(stub: Stub<'f>, machine: &mut Machine<'f>, held: Option<bool>) -> Served<'f> {
    match (stub, held) {
        (GdbStubStateMachine::Running(stub), Some(true)) => {
            stub.report_stop(machine, SingleThreadStopReason::DoneStep)
        }
        (GdbStubStateMachine::Running(stub), Some(false)) => {
            stub.report_stop(machine, SingleThreadStopReason::SwBreak(()))
        }
        (stub, _) => Ok(stub),
    }
}

/// Receives bytes; `None` when the connection is closed.
fn exchange<'f>(
    mut stub: Stub<'f>,
    machine: &mut Machine<'f>,
) -> Result<Option<Stub<'f>>, GdbStubError<Error, std::io::Error>> {
    loop {
        stub = match stub {
            GdbStubStateMachine::Idle(mut idle) => match next(idle.borrow_conn()) {
                Ok(Some(byte)) => idle.incoming_data(machine, byte)?,
                Ok(None) => return Ok(Some(idle.into())),
                Err(_) => return Ok(None),
            },
            GdbStubStateMachine::Running(mut running) => match next(running.borrow_conn()) {
                Ok(Some(byte)) => running.incoming_data(machine, byte)?,
                Ok(None) => return Ok(Some(running.into())),
                Err(_) => return Ok(None),
            },
            GdbStubStateMachine::CtrlCInterrupt(interrupt) => {
                let reason = SingleThreadStopReason::Signal(Signal::SIGINT);
                interrupt.interrupt_handled(machine, Some(reason))?
            }
            gone @ GdbStubStateMachine::Disconnected(_) => return Ok(Some(gone)),
        };
    }
}

/// A received byte, if there is one.
fn next(stream: &mut TcpStream) -> std::io::Result<Option<u8>> {
    let waiting = ConnectionExt::peek(stream)?;
    // Later writes must not fail because the connection is busy.
    stream.set_nonblocking(false)?;
    if waiting.is_none() {
        return Ok(None);
    }
    ConnectionExt::read(stream).map(Some)
}
