// SPDX-License-Identifier: GPL-2.0-only
//! Catalogue of the faults that can be injected into a running firmware, with the expected reaction to each.

use palpate_plant::Faults;

use crate::ResetCause;
use crate::rtt::Reader;
use crate::world::WiringFaults;

/// How a fault gets in.
#[derive(Clone, Copy, Debug)]
pub(super) enum Injection {
    /// Something breaks in finger, motor or encoder.
    Plant(fn(&mut Faults)),
    /// Something breaks between plant and chip; given the present current sense voltage.
    Wiring(fn(&mut WiringFaults, f64)),
    /// The firmware is told to fail: needs the feature `fault-injection`.
    Command(&'static str),
    /// The chip is reset.
    Reset(ResetCause),
    /// The log's reader changes, and comes back after this many simulated seconds.
    Reader(Reader, f64),
}

/// A fault that can be injected.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// Name on the command line.
    pub name: &'static str,
    /// What finds it.
    pub detected_by: &'static str,
    /// Names of the faults that the firmware may report for it; none if it has to go on undisturbed.
    pub reported: &'static [&'static str],
    /// The bridge has to be off this long after the injection.
    pub limit_us: f64,
    /// When it is injected, unless told otherwise: in mid-motion, or before the first motion.
    pub at_s: f64,
    pub(super) injection: Injection,
}

/// In the middle of the free closing that records friction.
pub(super) const MOVING_S: f64 = 7.0;
/// From here on the times of docs/MANUAL.md#faults. Two control periods: a reading is judged in the interrupt that
/// follows it.
const NEXT_PERIODS_US: f64 = 100.0;
/// Back-EMF against encoder: 10 ms of contradiction, the observer's 1 ms, and slack for what counts back.
const CONTRADICTION_US: f64 = 30_000.0;
/// A driven motor may show no current for 0.2 s while it slows down; longer is a fault.
const SILENCE_US: f64 = 250_000.0;
/// A reading that repeats itself shows within 2 ms while the motor turns, one of nothing at a current that must flow within 10 ms. It
/// may stick where the motor turns round: then once it turns again, or the voltages contradict each other.
const STUCK_US: f64 = CONTRADICTION_US;
/// The watchdog at its oscillator's slowest, after the last report.
const WATCHDOG_US: f64 = 118_500.0;
/// Kicks in succession that no motor makes.
const NOISE_US: f64 = 2_000.0;
/// The offset is measured at rest: 20 ms to settle, 205 ms of averaging.
const REST_US: f64 = 300_000.0;
/// 150 ms at the current limit without motion.
const STALL_US: f64 = 250_000.0;
/// Not in the manual: how long the finger takes to run past the place of the missing stop and all that could be it.
const WAY_US: f64 = 12_000_000.0;
/// Not in the manual: a command on its way, since the probe polls every millisecond, the console and the executor take their turn.
const COMMAND_US: f64 = 50_000.0;

/// Every fault.
pub const FAULTS: &[Fault] = &[
    Fault {
        name: "over-current",
        detected_by: "control interrupt",
        reported: &["over-current"],
        limit_us: NEXT_PERIODS_US,
        at_s: MOVING_S,
        // 350 mA at 6.8 V/A: above every limit, below full scale.
        injection: Injection::Wiring(|wires, _| wires.current_v = Some(2.38)),
    },
    Fault {
        name: "fault-pin",
        detected_by: "timer break (hardware)",
        reported: &["bridge"],
        limit_us: 1.0,
        at_s: MOVING_S,
        injection: Injection::Wiring(|wires, _| wires.fault_low = true),
    },
    Fault {
        name: "supply-collapse",
        detected_by: "control interrupt",
        reported: &["supply-low", "bridge"],
        limit_us: NEXT_PERIODS_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.supply_v = Some(5.0)),
    },
    Fault {
        name: "supply-surge",
        detected_by: "control interrupt",
        reported: &["supply-high"],
        limit_us: NEXT_PERIODS_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.supply_v = Some(20.0)),
    },
    Fault {
        name: "encoder-a-cut",
        detected_by: "control interrupt",
        reported: &["encoder-stuck", "encoder-jump"],
        limit_us: CONTRADICTION_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.encoder.a_cut = true),
    },
    Fault {
        name: "encoder-b-cut",
        detected_by: "control interrupt",
        reported: &["encoder-stuck", "encoder-jump"],
        limit_us: CONTRADICTION_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.encoder.b_cut = true),
    },
    Fault {
        name: "encoder-cut",
        detected_by: "control interrupt",
        reported: &["encoder-stuck", "encoder-jump"],
        limit_us: CONTRADICTION_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| {
            faults.encoder.a_cut = true;
            faults.encoder.b_cut = true;
        }),
    },
    Fault {
        name: "encoder-swapped",
        detected_by: "control interrupt",
        reported: &["encoder-reversed", "encoder-jump"],
        limit_us: CONTRADICTION_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.encoder.swapped = true),
    },
    Fault {
        name: "encoder-noise",
        detected_by: "control interrupt",
        reported: &["encoder-jump", "encoder-stuck", "encoder-reversed"],
        limit_us: NOISE_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.encoder.storm_edges_per_s = 2e6),
    },
    Fault {
        name: "adc-stuck-zero",
        detected_by: "control interrupt",
        reported: &["sense-stuck"],
        limit_us: SILENCE_US,
        at_s: MOVING_S,
        injection: Injection::Wiring(|wires, _| wires.current_v = Some(0.0)),
    },
    Fault {
        name: "adc-stuck-full",
        detected_by: "control interrupt",
        reported: &["sense-saturated", "over-current"],
        limit_us: NEXT_PERIODS_US,
        at_s: MOVING_S,
        injection: Injection::Wiring(|wires, _| wires.current_v = Some(3.3)),
    },
    Fault {
        name: "adc-stuck-last",
        detected_by: "control interrupt",
        reported: &["sense-stuck"],
        limit_us: STUCK_US,
        at_s: MOVING_S,
        injection: Injection::Wiring(|wires, volts| wires.current_v = Some(volts)),
    },
    Fault {
        name: "sense-offset",
        detected_by: "offset measured at rest",
        reported: &["offset-out-of-range"],
        limit_us: REST_US,
        at_s: 0.05,
        injection: Injection::Plant(|faults| faults.sense_offset_a = 0.020),
    },
    Fault {
        name: "stalled-rotor",
        detected_by: "sequence",
        reported: &["stall"],
        limit_us: STALL_US,
        at_s: MOVING_S,
        injection: Injection::Plant(|faults| faults.rotor_locked = true),
    },
    Fault {
        name: "missing-stop",
        detected_by: "sequence",
        reported: &["state-timeout", "travel-limit"],
        limit_us: WAY_US,
        at_s: 0.05,
        injection: Injection::Plant(|faults| faults.stops_missing = true),
    },
    Fault {
        name: "task-starved",
        detected_by: "independent watchdog, or the samples that pile up",
        reported: &["watchdog", "queue-overflow"],
        limit_us: WATCHDOG_US + COMMAND_US,
        at_s: MOVING_S,
        injection: Injection::Command("inject starve-task"),
    },
    Fault {
        name: "executor-hung",
        detected_by: "independent watchdog",
        reported: &["watchdog"],
        limit_us: WATCHDOG_US + COMMAND_US,
        at_s: MOVING_S,
        injection: Injection::Command("inject hang"),
    },
    Fault {
        name: "panic",
        detected_by: "panic handler",
        reported: &["panic"],
        limit_us: COMMAND_US,
        at_s: MOVING_S,
        injection: Injection::Command("inject panic"),
    },
    Fault {
        name: "bus-fault",
        detected_by: "fault handler",
        reported: &["hard-fault"],
        limit_us: COMMAND_US,
        at_s: MOVING_S,
        injection: Injection::Command("inject hardfault"),
    },
    Fault {
        name: "stack-overflow",
        detected_by: "fault handler",
        reported: &["stack-overflow"],
        limit_us: COMMAND_US,
        at_s: MOVING_S,
        injection: Injection::Command("inject stack-overflow"),
    },
    Fault {
        name: "brown-out",
        detected_by: "reset",
        reported: &["brown-out"],
        limit_us: 1.0,
        at_s: MOVING_S,
        injection: Injection::Reset(ResetCause::BrownOut),
    },
    Fault {
        name: "rtt-absent",
        detected_by: "nothing: the log drops records",
        reported: &[],
        limit_us: 0.0,
        at_s: 0.05,
        injection: Injection::Reader(Reader::Absent, 10.0),
    },
    Fault {
        name: "rtt-slow",
        detected_by: "nothing: the log drops records",
        reported: &[],
        limit_us: 0.0,
        at_s: 0.05,
        injection: Injection::Reader(Reader::Slow(1), f64::INFINITY),
    },
];

/// A fault with the moment of its injection.
#[derive(Clone, Copy, Debug)]
pub struct Injected {
    /// What.
    pub fault: &'static Fault,
    /// When, in simulated seconds.
    pub at_s: f64,
}

impl std::str::FromStr for Injected {
    type Err = String;

    /// `NAME` or `NAME@SECONDS`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, at) = text
            .split_once('@')
            .map_or((text, None), |(name, at)| (name, Some(at)));
        let names = || {
            FAULTS
                .iter()
                .map(|fault| fault.name)
                .collect::<Vec<_>>()
                .join(", ")
        };
        let fault = FAULTS.iter().find(|fault| fault.name == name);
        let fault = fault.ok_or_else(|| format!("no fault '{name}'; there are {}", names()))?;
        let at_s = match at {
            None => fault.at_s,
            Some(at) => match at.parse::<f64>() {
                Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => seconds,
                _ => return Err(format!("'{at}' is no time in seconds")),
            },
        };
        Ok(Self { fault, at_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_times_are_read() {
        let injected: Injected = "fault-pin@2.5".parse().unwrap();
        assert_eq!((injected.fault.name, injected.at_s), ("fault-pin", 2.5));
        assert_eq!("panic".parse::<Injected>().unwrap().at_s, MOVING_S);
        assert!(
            "nonsense"
                .parse::<Injected>()
                .unwrap_err()
                .contains("fault-pin")
        );
        for wrong in ["panic@", "panic@x", "panic@-1", "panic@inf"] {
            assert!(wrong.parse::<Injected>().is_err(), "{wrong}");
        }
    }
}
