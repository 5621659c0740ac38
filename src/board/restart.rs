//! How the last run ended: logged at start, and the fault that follows from it.

use palpate::app::log::Log;
use palpate::drive::Fault;

use super::crash::{self, Cause};
use super::reset::{self, Reset};
use super::telemetry::Telemetry;
use super::{bridge, watchdog};

/// Reports the reset and what the last run left. The fault, if there is one, keeps the motor off until it is cleared.
pub fn report() -> (Reset, Option<Fault>) {
    let reset = reset::take();
    let missing = watchdog::take_reports();
    let crash = crash::take();
    let was_live = bridge::was_live();
    Telemetry.reset(reset.name());
    let fault = match (reset, crash) {
        (Reset::Software, Some(crash)) => {
            Telemetry.crash(
                crash.cause().name(),
                crash.pc,
                crash.lr,
                crash.status,
                crash.address,
                crash.line,
                crash.file(),
            );
            Some(match crash.cause() {
                Cause::Panic => Fault::Panic,
                Cause::StackOverflow => Fault::StackOverflow,
                Cause::HardFault | Cause::NonMaskable | Cause::Unhandled => Fault::HardFault,
            })
        }
        (Reset::Watchdog, _) => {
            if let Some(missing) = missing {
                Telemetry.watchdog(missing.control, missing.sensing, missing.sequence);
            }
            Some(Fault::Watchdog)
        }
        (Reset::Power, _) if was_live => Some(Fault::BrownOut),
        _ => None,
    };
    (reset, fault)
}
