//! Faults: numbered and latched, with the bridge off. One table holds number, name, cause, remedy and what detects it;
//! a test compares docs/MANUAL.md#faults with it.
//!
//! Limits, in contrast, are clamped and reported while the motor goes on: see [`LimitsReached`](super::LimitsReached).

use crate::name_list::nth;

/// Declares the faults once: the enum, its table and the look-ups come from the same lines.
macro_rules! faults {
    ($($number:literal $variant:ident $name:literal, $by:literal, $limit_us:literal $why:literal, $cause:literal, $remedy:literal;)*) => {
        /// Why the bridge was switched off. The discriminant is the number that is logged.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Fault {
            $(#[doc = concat!($cause, " Remedy: ", $remedy)] $variant = $number,)*
        }

        impl Fault {
            /// Every fault, in the order of their numbers.
            pub const ALL: &'static [Fault] = &[$(Fault::$variant,)*];

            /// The number that is logged.
            pub const fn number(self) -> u8 {
                self as u8
            }

            /// The fault with this number, `None` if there is none.
            pub const fn from_number(number: u8) -> Option<Self> {
                match number {
                    $($number => Some(Fault::$variant),)*
                    _ => None,
                }
            }

            /// Short name, as logged.
            pub fn name(self) -> &'static str {
                const NAMES: &str = concat!($($name, "\n",)*);
                // The first is number 1.
                nth(NAMES, self.number().wrapping_sub(1))
            }

            /// What detects it.
            pub const fn detected_by(self) -> &'static str {
                match self { $(Fault::$variant => $by,)* }
            }

            /// Longest time, microseconds, from the moment the condition is there until the bridge is off.
            pub const fn limit_us(self) -> u32 {
                match self { $(Fault::$variant => $limit_us,)* }
            }

            /// What this time is made of.
            pub const fn limit_reason(self) -> &'static str {
                match self { $(Fault::$variant => $why,)* }
            }

            /// What may have happened.
            pub const fn cause(self) -> &'static str {
                match self { $(Fault::$variant => $cause,)* }
            }

            /// What to do about it.
            pub const fn remedy(self) -> &'static str {
                match self { $(Fault::$variant => $remedy,)* }
            }
        }
    };
}

faults! {
    1 OverCurrent "over-current", "control interrupt",
        100 "the next period's reading, judged in the same interrupt",
        "The motor current exceeded the trip limit.",
        "Look for a short in the motor cable; check the motor's resistance in the scene.";
    2 WindingHot "winding-hot", "control interrupt",
        1_100 "the model advances once a millisecond",
        "The thermal model puts the winding above its limit.",
        "Let the motor cool for some minutes; hold with less current or for a shorter time.";
    3 SupplyLow "supply-low", "control interrupt",
        100 "as over-current",
        "The supply is below its lower limit.",
        "Check the supply and its current limit.";
    4 SupplyHigh "supply-high", "control interrupt",
        100 "as over-current",
        "The supply is above its upper limit.",
        "Check the supply; a braked load may pump it up: add a clamp or a larger capacitor.";
    5 Bridge "bridge", "timer break (hardware)",
        1 "hardware, no instruction executed",
        "The bridge reported a fault: short circuit, over-temperature or under-voltage.",
        "Check the motor cable, the bridge's temperature and its supply.";
    6 OffsetOutOfRange "offset-out-of-range", "control interrupt",
        300_000 "20 ms to settle at rest and 205 ms of averaging; the motor carries no current meanwhile",
        "The current sense reads more than an offset although no current can flow, or is too noisy to tell.",
        "Check the sense resistor and its ground; check that the motor stands still while the offset is measured.";
    7 SenseSaturated "sense-saturated", "control interrupt",
        100 "as over-current",
        "The current sense is at full scale.",
        "Check the sense wire for a short to the supply, and the motor cable for a short.";
    8 SenseStuck "sense-stuck", "control interrupt",
        250_000 "2 ms for a reading that repeats itself, 10 ms for one of nothing at a current that must flow, 0.2 s where the current might really be that small",
        "The current sense does not move although the motor does, or reads nothing although current must flow.",
        "Check the sense wire and the sense resistor.";
    9 EncoderStuck "encoder-stuck", "control interrupt",
        30_000 "10 ms of contradiction, after the speed observer's lag",
        "The motor's back-EMF shows that it turns, the encoder does not count along.",
        "Check both encoder wires and the encoder's supply.";
    10 EncoderJump "encoder-jump", "control interrupt",
        2_000 "at once for a jump, seven kicks in succession for noise",
        "The encoder moved in a way that no motor can.",
        "Check the encoder cable's shield and its supply; keep it away from the motor cable.";
    11 EncoderReversed "encoder-reversed", "control interrupt",
        30_000 "as encoder-stuck",
        "The encoder counts against the motor's back-EMF.",
        "Swap the motor's two wires if the finger moves the wrong way, else the encoder's two phases.";
    12 Stall "stall", "sequence",
        250_000 "150 ms at the current limit without motion: static friction and backlash take less",
        "The motor stands still where nothing should stop it.",
        "Look for a blocked finger or gear; if friction is the reason, raise `free_current_a` and `homing_current_a` of the scene.";
    13 TravelLimit "travel-limit", "control interrupt, sequence",
        2_000 "the sequence looks once a millisecond; from leaving the travel",
        "The finger left its travel: a stop is missing, or the encoder's zero is wrong.",
        "Check the stops and the cable, then home again.";
    14 StateTimeout "state-timeout", "sequence",
        2_000 "from the deadline, as travel-limit",
        "A state of the sequence lasted longer than it may.",
        "Compare speed and travel in the scene with the finger.";
    15 Overrun "overrun", "control interrupt",
        100 "the next period",
        "The control interrupt was not finished when the next one was due.",
        "Report it: its worst case is measured and must not happen. Check that no higher interrupt was added.";
    16 QueueOverflow "queue-overflow", "sensing task",
        5_000 "from the lost sample to the sequence's next step",
        "Samples were lost because the sensing task was too slow.",
        "Report it; look for a task that blocks.";
    17 BadConfiguration "bad-configuration", "start",
        0 "the bridge has not been on",
        "The scene or a setting is out of its range.",
        "The log names the parameter and its range: correct it, or use the factory command.";
    18 BadRecord "bad-record", "start",
        0 "the bridge has not been on",
        "A stored record failed its check and is ignored; defaults are in force.",
        "Clear, then record friction and calibrate again, and save.";
    19 Watchdog "watchdog", "independent watchdog (hardware)",
        118_500 "10 ms since the last report, 108.5 ms of the watchdog at its oscillator's slowest",
        "A task or the control interrupt did not report in time; the chip was reset.",
        "Report it with the log: it names who was missing.";
    20 Panic "panic", "panic handler",
        20 "the handler's first act",
        "The firmware found an impossible state and reset itself.",
        "Report file and line from the log.";
    21 HardFault "hard-fault", "fault handler",
        20 "the handler's first act",
        "The processor faulted: bus error, bad instruction or the like; the chip was reset.",
        "Report the registers of the log.";
    22 StackOverflow "stack-overflow", "fault handler",
        20 "the handler's first act",
        "The stack ran out of its memory; the chip was reset.",
        "Report it; a deeper call chain than any tested.";
    23 BrownOut "brown-out", "reset flags",
        1 "hardware, no instruction executed",
        "The chip's own supply dipped in a motion or while a fault was latched.",
        "Check the 3.3 V supply and the board's capacitors.";
    24 IllegalTransition "illegal-transition", "sequence",
        2_000 "as travel-limit",
        "The motion sequence was about to take a step that its table does not allow.",
        "Report it with the log.";
}

impl Fault {
    /// Whether counts may have been lost: the encoder's zero is then another one.
    pub fn loses_counts(self) -> bool {
        matches!(
            self,
            Fault::EncoderStuck | Fault::EncoderJump | Fault::EncoderReversed
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_consecutive_and_invert() {
        for (index, fault) in Fault::ALL.iter().enumerate() {
            assert_eq!(usize::from(fault.number()), index + 1);
            assert_eq!(Fault::from_number(fault.number()), Some(*fault));
        }
        assert_eq!(Fault::from_number(0), None);
        assert_eq!(Fault::from_number(Fault::ALL.len() as u8 + 1), None);
    }

    #[test]
    fn names_are_unique_and_fit_a_log_line() {
        for (index, fault) in Fault::ALL.iter().enumerate() {
            assert!(
                fault
                    .name()
                    .bytes()
                    .all(|c| c.is_ascii_lowercase() || c == b'-')
            );
            assert!(
                Fault::ALL[..index]
                    .iter()
                    .all(|other| other.name() != fault.name())
            );
            assert!(fault.cause().ends_with('.') && fault.remedy().ends_with('.'));
        }
    }
}
