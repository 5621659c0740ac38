//! Faults: numbered, latched, bridge off. One table holds number, name, cause, remedy and what detects it; the README's
//! table is this one.
//!
//! Limits, in contrast, are clamped and reported while the motor goes on: see [`Limited`](super::Limited).

/// Declares the faults once: the enum, its table and the look-ups come from the same lines.
macro_rules! faults {
    ($($number:literal $variant:ident $name:literal, $by:literal, $cause:literal, $remedy:literal;)*) => {
        /// Why the bridge was switched off. The discriminant is the number that is logged.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(target_os = "none", derive(defmt::Format))]
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
            pub const fn name(self) -> &'static str {
                match self { $(Fault::$variant => $name,)* }
            }

            /// What detects it.
            pub const fn detected_by(self) -> &'static str {
                match self { $(Fault::$variant => $by,)* }
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
        "The motor current exceeded the trip limit.",
        "Look for a short in the motor cable; check the motor's resistance in the scene.";
    2 WindingHot "winding-hot", "control interrupt",
        "The thermal model puts the winding above its limit.",
        "Let the motor cool for some minutes; hold with less current or for a shorter time.";
    3 SupplyLow "supply-low", "control interrupt",
        "The supply is below its lower limit.",
        "Check the supply and its current limit.";
    4 SupplyHigh "supply-high", "control interrupt",
        "The supply is above its upper limit.",
        "Check the supply; a braked load may pump it up: add a clamp or a larger capacitor.";
    5 Bridge "bridge", "timer break (hardware)",
        "The bridge reported a fault: short circuit, over-temperature or under-voltage.",
        "Check the motor cable, the bridge's temperature and its supply.";
    6 OffsetOutOfRange "offset-out-of-range", "control interrupt",
        "The current sense reads more than an offset although no current can flow, or is too noisy to tell.",
        "Check the sense resistor and its ground; check that the motor stands still while the offset is measured.";
    7 SenseSaturated "sense-saturated", "control interrupt",
        "The current sense is at full scale.",
        "Check the sense wire for a short to the supply, and the motor cable for a short.";
    8 SenseStuck "sense-stuck", "control interrupt",
        "The current sense does not move although the motor does, or reads nothing although current must flow.",
        "Check the sense wire and the sense resistor.";
    9 EncoderStuck "encoder-stuck", "control interrupt",
        "The motor's back-EMF shows that it turns, the encoder does not count along.",
        "Check both encoder wires and the encoder's supply.";
    10 EncoderJump "encoder-jump", "control interrupt",
        "The encoder moved in a way that no motor can.",
        "Check the encoder cable's shield and its supply; keep it away from the motor cable.";
    11 EncoderReversed "encoder-reversed", "control interrupt",
        "The encoder counts against the motor's back-EMF.",
        "Swap the encoder's two phases, or the motor's two wires.";
    12 Stall "stall", "sequence",
        "The motor stands still where nothing should stop it.",
        "Look for a blocked finger or gear; raise the current limit if friction is the reason.";
    13 TravelLimit "travel-limit", "control interrupt, sequence",
        "The finger left its travel: a stop is missing, or the encoder's zero is wrong.",
        "Check the stops and the cable, then home again.";
    14 StateTimeout "state-timeout", "sequence",
        "A state of the sequence lasted longer than it may.",
        "Compare speed and travel in the scene with the finger.";
    15 Overrun "overrun", "control interrupt",
        "The control interrupt was not finished when the next one was due.",
        "Report it: its worst case is measured and must not happen. Check that no higher interrupt was added.";
    16 QueueOverflow "queue-overflow", "sensing task",
        "Samples were lost because the sensing task was too slow.",
        "Report it; look for a task that blocks.";
    17 BadConfiguration "bad-configuration", "start, set command",
        "The scene or a setting is out of its range.",
        "The log names the parameter and its range: correct it, or use the factory command.";
    18 BadRecord "bad-record", "start",
        "A stored record failed its check and is ignored; defaults are in force.",
        "Clear, then record friction and calibrate again, and save.";
    19 Watchdog "watchdog", "independent watchdog (hardware)",
        "A task or the control interrupt did not report in time; the chip was reset.",
        "Report it with the log: it names who was missing.";
    20 Panic "panic", "panic handler",
        "The firmware found an impossible state and reset itself.",
        "Report the message of the log.";
    21 HardFault "hard-fault", "fault handler",
        "The processor faulted: bus error, bad instruction or the like; the chip was reset.",
        "Report the registers of the log.";
    22 StackOverflow "stack-overflow", "fault handler",
        "The stack ran out of its memory; the chip was reset.",
        "Report it; a deeper call chain than any tested.";
    23 BrownOut "brown-out", "reset flags",
        "The chip's own supply dipped while the motor was in motion.",
        "Check the 3.3 V supply and the board's capacitors.";
    24 IllegalTransition "illegal-transition", "sequence",
        "The motion sequence was about to take a step that its table does not allow.",
        "Report it with the log.";
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
