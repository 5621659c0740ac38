// SPDX-License-Identifier: GPL-2.0-only
//! Ports for clients of a run.

use palpate_emulator::Error;
use palpate_emulator::clients::gdb::GdbServer;
use palpate_emulator::clients::rtt::RttServer;
#[cfg(unix)]
use palpate_emulator::clients::serial::Serial;
use palpate_emulator::sim::Session;

/// Open ports.
pub struct Ports<'f> {
    rtt: Option<RttServer>,
    gdb: Option<GdbServer<'f>>,
    #[cfg(unix)]
    serial: Option<Serial>,
}

impl<'f> Ports<'f> {
    /// Opens the requested ports and prints their addresses.
    pub fn open(rtt: Option<u16>, gdb: Option<u16>, serial: bool) -> Result<Self, Error> {
        let ports = Self {
            rtt: rtt.map(RttServer::listen).transpose()?,
            gdb: gdb.map(GdbServer::listen).transpose()?,
            #[cfg(unix)]
            serial: serial.then(Serial::open).transpose()?,
        };
        #[cfg(unix)]
        if let Some(serial) = &ports.serial {
            let name = serial.name();
            eprintln!("serial: {name}; cargo xtask monitor --from {name}");
        }
        #[cfg(not(unix))]
        if serial {
            return Err(Error::Serial(
                "this system has no pairs of terminals".to_owned(),
            ));
        }
        if let Some(rtt) = &ports.rtt {
            let port = rtt.port();
            eprintln!("rtt: port {port}; defmt-print -e ELF tcp --host localhost --port {port}");
        }
        if let Some(gdb) = &ports.gdb {
            let port = gdb.port();
            eprintln!("gdb: port {port}; gdb-multiarch ELF -ex 'target remote :{port}'");
        }
        Ok(ports)
    }

    /// Serves them; false while a debugger holds the core.
    pub fn serve(&mut self, session: &mut Session<'f>) -> Result<bool, Error> {
        if let Some(rtt) = &mut self.rtt {
            rtt.serve(&mut session.machine);
        }
        #[cfg(unix)]
        if let Some(serial) = &mut self.serial {
            serial.serve(&mut session.machine);
        }
        self.gdb.as_mut().map_or(Ok(true), |gdb| gdb.serve(session))
    }
}
