//! How the last run ended, told in the log, and the fault it amounts to.

use palpate::drive::Fault;

use super::crash::{self, Cause};
use super::reset::{self, Reset};
use super::{bridge, telemetry, watchdog};

/// Reports the reset and what the last run left. The fault, if there is one, keeps the motor off until it is cleared.
pub fn report() -> Option<Fault> {
    let reset = reset::take();
    let missing = watchdog::take_reports();
    let crash = crash::take();
    let was_live = bridge::take_was_live();
    telemetry::reset(reset);
    match (reset, crash) {
        (Reset::Software, Some(crash)) => {
            telemetry::crash(&crash);
            Some(match crash.cause() {
                Cause::Panic => Fault::Panic,
                Cause::StackOverflow => Fault::StackOverflow,
                Cause::HardFault | Cause::NonMaskable | Cause::Unhandled => Fault::HardFault,
            })
        }
        (Reset::Watchdog, _) => {
            if let Some(missing) = missing {
                telemetry::watchdog(missing);
            }
            Some(Fault::Watchdog)
        }
        (Reset::Power, _) if was_live => Some(Fault::BrownOut),
        _ => None,
    }
}
