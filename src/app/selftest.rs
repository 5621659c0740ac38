//! The self-test of a board: what each step measures, what it must be, and what to look at where it is not.
//!
//! The steps run in the order of [`SelfTestStep::ALL`]; the first that fails ends the test, so that the motor moves only where
//! everything before is as it should be. The motion itself belongs to the board's task.

mod measurement;

pub use measurement::{Measurement, SETTLE_MS};

use core::fmt;

use super::console::text::{Decimal, Plain};
use crate::drive::Fault;
use crate::name_list::nth;

/// A step of the self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfTestStep {
    /// The supply is within the limits.
    Supply,
    /// The bridge wakes up: nFAULT is high.
    Wake,
    /// nFAULT low cuts the PWM in hardware.
    BreakInput,
    /// The current sense's offset at rest is above zero and small.
    Offset,
    /// The current sense's noise at rest.
    Noise,
    /// The current that is read while a current is driven.
    Current,
    /// The encoder counts up while closing.
    Encoder,
    /// A slow motion of some degrees meets no resistance.
    Travel,
}

impl SelfTestStep {
    /// Every step, in the order in which they run.
    pub const ALL: [Self; 8] = [
        Self::Supply,
        Self::Wake,
        Self::BreakInput,
        Self::Offset,
        Self::Noise,
        Self::Current,
        Self::Encoder,
        Self::Travel,
    ];

    /// The step that a fault speaks about, whichever was under way when it was detected.
    pub fn of_fault(fault: Fault) -> Option<Self> {
        match fault {
            Fault::SupplyLow | Fault::SupplyHigh => Some(Self::Supply),
            Fault::Bridge => Some(Self::Wake),
            Fault::OffsetOutOfRange => Some(Self::Offset),
            Fault::OverCurrent | Fault::SenseStuck | Fault::SenseSaturated => Some(Self::Current),
            Fault::EncoderStuck | Fault::EncoderReversed | Fault::EncoderJump => {
                Some(Self::Encoder)
            }
            _ => None,
        }
    }

    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        const NAMES: &str = "supply\nwake\nbreak-input\noffset\nnoise\ncurrent\nencoder\ntravel\n";
        nth(NAMES, self as u8)
    }

    /// Unit of the value.
    pub fn unit(self) -> &'static str {
        // In the same order; none of a level, and of whether the outputs were cut.
        const UNITS: &str = " V\n\n\n mA\n mA\n mA\n counts\n mrad\n";
        nth(UNITS, self as u8)
    }
}

/// Current that the motion steps drive: twice what free motion takes.
pub const DRIVEN_A: f32 = 0.04;
/// Motion that shows the encoder's direction, counts: a turn of the motor of the default drivetrain.
pub const ENCODER_COUNTS: i32 = 1000;
/// Motion of the last step at the input link, radian: 3 degrees; and its speed.
pub const TRAVEL_RAD: f32 = 0.05;
/// Speed of the last step, radian per second.
pub const TRAVEL_RAD_PER_S: f32 = 0.1;

/// The values that a step may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedRange {
    /// The step.
    pub step: SelfTestStep,
    /// Smallest value, in the step's unit.
    pub min: f32,
    /// Largest value, in the step's unit.
    pub max: f32,
}

impl ExpectedRange {
    /// For a board whose supply must lie within these limits, volt, and whose current sense may be signed.
    pub fn of(step: SelfTestStep, supply_min_v: f32, supply_max_v: f32, signed: bool) -> Self {
        let driven_ma = DRIVEN_A * 1e3;
        let (min, max) = match step {
            SelfTestStep::Wake | SelfTestStep::BreakInput => (1.0, 1.0),
            SelfTestStep::Supply => (supply_min_v, supply_max_v),
            // Zero is no offset but a negative one, which the unsigned converter cannot see.
            SelfTestStep::Offset => (if signed { -15.0 } else { 0.2 }, 15.0),
            // Without any noise nothing is connected. 0.5 mA rms and more in a control period is what the detection
            // threshold is made for; a sample averages twenty.
            SelfTestStep::Noise => (0.001, 1.0),
            SelfTestStep::Current => (0.5 * driven_ma, 1.5 * driven_ma),
            SelfTestStep::Encoder => (0.5 * ENCODER_COUNTS as f32, 10.0 * ENCODER_COUNTS as f32),
            SelfTestStep::Travel => (0.8e3 * TRAVEL_RAD, 1.2e3 * TRAVEL_RAD),
        };
        Self { step, min, max }
    }

    /// Whether a value passes.
    pub fn contains(&self, value: f32) -> bool {
        // A NaN is in no range.
        value >= self.min && value <= self.max
    }

    /// Whether the steps after one that failed with this value are safe and tell something all the same: an offset that reads zero costs
    /// accuracy alone, and many a bridge has one. One that could not be measured says that something is wrong.
    pub fn may_miss(&self, value: f32) -> bool {
        self.step == SelfTestStep::Offset && value < self.min
    }
}

impl fmt::Display for ExpectedRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (min, max) = (Decimal(self.min), Decimal(self.max));
        let unit = Plain(self.step.unit());
        if self.min < self.max {
            write!(f, "{min} to {max}{unit}")
        } else {
            write!(f, "{min}{unit}")
        }
    }
}

/// Remedy for an encoder that stands still or jumps.
const NOT_FOLLOWING: &str = "free the finger; check the encoder's supply, A at D12, B at D11";

/// What to look at where a step failed with this value, and perhaps a fault.
pub fn remedy(
    step: SelfTestStep,
    value: f32,
    wanted: &ExpectedRange,
    fault: Option<Fault>,
) -> &'static str {
    let low = value < wanted.min;
    match (step, fault) {
        (_, Some(Fault::SupplyLow | Fault::SupplyHigh)) | (SelfTestStep::Supply, _) => {
            "check supply and divider at A5; set supply-min, supply-max to it, save, restart"
        }
        (SelfTestStep::Wake, _) => {
            "nFAULT low: check bridge supply, nSLEEP at D4, D6, shorted outputs"
        }
        (SelfTestStep::BreakInput, _) => "nFAULT stays high: remove pull-up or short to 3.3 V",
        (SelfTestStep::Offset, None) if low => {
            "offset zero or negative: check A1; small currents are lost"
        }
        (SelfTestStep::Offset, None) if value.is_nan() => {
            "motor does not rest: hold it, check encoder"
        }
        (SelfTestStep::Offset, _) => "offset too large: check ground and the resistor at A1",
        (SelfTestStep::Noise, _) if low => "no noise at all: check A1, and nSLEEP at D4",
        (SelfTestStep::Noise, _) => "keep the motor's wires away from A1, fit its capacitor",
        (_, Some(Fault::EncoderReversed)) => {
            "swap motor wires if the finger opened, encoder A and B if it closed"
        }
        (_, Some(Fault::EncoderStuck | Fault::EncoderJump)) => NOT_FOLLOWING,
        (_, Some(Fault::SenseStuck)) => {
            "no current: check the sense wire at A1, motor wires, EN at D7"
        }
        (SelfTestStep::Current, _) if low => "too little current: check motor wires and EN at D7",
        (SelfTestStep::Current, _) => "too much current is read: check the sense resistor",
        (SelfTestStep::Encoder, _) if value < -wanted.min => {
            "swap motor wires if the finger opened, encoder A and B if it closed"
        }
        (SelfTestStep::Encoder, _) => NOT_FOLLOWING,
        (SelfTestStep::Travel, _) => "too stiff: free the finger and the drivetrain",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(step: SelfTestStep) -> ExpectedRange {
        ExpectedRange::of(step, 10.0, 14.0, false)
    }

    #[test]
    fn each_step_says_what_it_wants_in_its_unit() {
        let texts = SelfTestStep::ALL.map(|step| wanted(step).to_string());
        assert_eq!(
            texts,
            [
                "10 to 14 V",
                "1",
                "1",
                "0.2 to 15 mA",
                "0.001 to 1 mA",
                "20 to 60 mA",
                "500 to 10000 counts",
                "40 to 60 mrad"
            ]
        );
    }

    #[test]
    fn both_ends_pass_and_what_lies_beyond_or_is_no_number_fails() {
        for step in SelfTestStep::ALL {
            let wanted = wanted(step);
            assert!(wanted.contains(wanted.min) && wanted.contains(wanted.max));
            for value in [wanted.min - 0.1, wanted.max + 0.1, f32::NAN] {
                assert!(!wanted.contains(value), "{step:?} {value}");
                assert!(!remedy(step, value, &wanted, None).contains('='));
            }
        }
    }

    /// An offset below its range costs accuracy; one above it, or none, ends the test, and none is not the resistor's fault.
    #[test]
    fn only_an_offset_that_is_too_low_may_be_missed() {
        let wanted = wanted(SelfTestStep::Offset);
        assert!(wanted.may_miss(0.0) && wanted.may_miss(-1.0));
        assert!(!wanted.may_miss(f32::NAN) && !wanted.may_miss(16.0));
        let of = |value| remedy(SelfTestStep::Offset, value, &wanted, None);
        assert!(of(f32::NAN).contains("encoder") && of(16.0).contains("resistor"));
        for step in SelfTestStep::ALL {
            let others = step == SelfTestStep::Offset || !self::wanted(step).may_miss(-1e9);
            assert!(others, "{step:?}");
        }
    }

    #[test]
    fn a_reversed_encoder_and_a_dead_one_have_different_remedies() {
        let wanted = wanted(SelfTestStep::Encoder);
        let of = |value, fault| remedy(SelfTestStep::Encoder, value, &wanted, fault);
        assert_eq!(of(-1000.0, None), of(0.0, Some(Fault::EncoderReversed)));
        assert_ne!(of(-1000.0, None), of(0.0, None));
        assert_eq!(of(0.0, None), of(0.0, Some(Fault::EncoderStuck)));
    }
}
