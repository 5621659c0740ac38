//! The plant as the chip sees it: codes and counters in, timer and pins out.

use palpate::drive::io::{
    AdcCode, CONTROL_HZ, DUTY_FULL, Direction, EncoderCount, Inputs, Outputs,
};
use palpate_plant::{Converter, Pins, Plant};

/// A control period, second.
pub const PERIOD_S: f64 = 1.0 / CONTROL_HZ as f64;

/// Reference of the converter, volt.
const REFERENCE_V: f64 = 3.3;

/// Sampling and distance of conversions, second: 12.5 and 25 cycles of 42.5 MHz (src/board/sampling.rs).
const CONVERSION_S: [f64; 2] = [12.5 / 42.5e6, 25.0 / 42.5e6];
/// Conversions of half a period of the PWM.
const CONVERSIONS: usize = 8;

/// Plant, converters, timer with its break, and the period's delay between measurement and output.
#[derive(Clone, Debug)]
pub struct Board {
    /// The world.
    pub plant: Plant,
    /// In force since the last update of the timer.
    pins: Pins,
    /// The bridge was switched on since it was last switched off.
    armed: bool,
    /// nFAULT stopped the timer's outputs; stays until the bridge was switched off.
    broken: bool,
    converter: Converter,
}

impl Board {
    /// A board just out of reset: bridge asleep.
    #[must_use]
    pub fn new(plant: Plant) -> Self {
        Self {
            plant,
            pins: Pins::default(),
            armed: false,
            broken: false,
            converter: Converter::default(),
        }
    }

    /// What the chip reads at the update that begins a control period.
    #[must_use]
    pub fn inputs(&mut self) -> Inputs {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the counter has 16 bits"
        )]
        let encoder = EncoderCount(self.plant.encoder_count() as u16);
        let supply_v = self.plant.supply_sense_v();
        let (current_source, supply_source) =
            (self.plant.current_source(), self.plant.supply_source());
        let mut probe = self.plant.current_probe(&self.pins);
        let (current, late_excess, supply) = match probe.constant_v() {
            Some(volt) if current_source.hold_f == 0.0 => (constant(volt), 0, constant(supply_v)),
            _ => {
                let mut volts = [0.0; 2 * CONVERSIONS];
                probe.fill(CONVERSION_S, &mut volts);
                let converter = &mut self.converter;
                converter.sample(&current_source, CONVERSION_S, &mut volts);
                let [early, late] = [&volts[..CONVERSIONS], &volts[CONVERSIONS..]].map(sum);
                let some = &mut volts[..CONVERSIONS];
                converter.sample_steady(&supply_source, CONVERSION_S, supply_v, some);
                #[expect(clippy::cast_possible_wrap, reason = "sums of 8 codes have 15 bits")]
                let excess = late as i16 - early as i16;
                (AdcCode(early + late), excess, AdcCode(2 * sum(some)))
            }
        };
        Inputs {
            current,
            late_excess,
            supply,
            encoder,
            bridge_fault: self.plant.fault_pin_low() || self.broken,
            overrun: false,
        }
    }

    /// What the chip reads of joint 2 then, where a sensor is fitted.
    #[must_use]
    pub fn joint_code(&self) -> AdcCode {
        constant(self.plant.hall_v())
    }

    /// One control period passes, then the timer takes over `outputs`: what was computed from the last [`Self::inputs`]
    /// acts one period after they were measured, as the timer's preloaded registers make it.
    pub fn period(&mut self, outputs: Outputs) {
        self.plant.step(&self.pins, PERIOD_S);
        if self.armed && self.plant.fault_pin_low() {
            self.broken = true;
        }
        if outputs == Outputs::Off {
            self.broken = false;
        }
        self.armed = !matches!(outputs, Outputs::Off | Outputs::Wake);
        self.pins = match outputs {
            Outputs::Off => Pins::default(),
            Outputs::Wake => Pins {
                awake: true,
                ..Pins::default()
            },
            Outputs::Brake => Pins {
                awake: true,
                duty: 0.0,
                ..self.pins
            },
            Outputs::Drive { direction, duty } => Pins {
                awake: true,
                duty: f64::from(duty.0.min(DUTY_FULL)) / f64::from(DUTY_FULL),
                closing: direction == Direction::Closing,
                ..self.pins
            },
        };
        self.pins.outputs_enabled = self.armed && !self.broken;
    }

    /// Levels in force.
    #[must_use]
    pub fn pins(&self) -> &Pins {
        &self.pins
    }
}

/// The sum of some conversions.
fn sum(volts: &[f64]) -> u16 {
    volts.iter().map(|volt| conversion(*volt)).sum()
}

/// What a voltage reads as that neither changes nor gives way to the converter.
fn constant(volt: f64) -> AdcCode {
    AdcCode(16 * conversion(volt))
}

/// A conversion of 12 bits.
fn conversion(volt: f64) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rounds towards zero, and ends at zero where a voltage is negative"
    )]
    let code = (volt * (4096.0 / REFERENCE_V)) as u16;
    code.min(4095)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::drive::io::{ADC_FULL, Duty};
    use palpate_plant::{Grasp, Parameters};

    fn board() -> Board {
        Board::new(Plant::new(&Parameters::default(), &Grasp::Free, 1).expect("defaults"))
    }

    const DRIVE: Outputs = Outputs::Drive {
        direction: Direction::Closing,
        duty: Duty(DUTY_FULL / 2),
    };

    #[test]
    fn codes_are_the_converters() {
        let code = |volt| {
            let read = constant(volt);
            assert_eq!(AdcCode(2 * sum(&[volt; CONVERSIONS])), read);
            read
        };
        assert_eq!(code(0.0), AdcCode(0));
        assert_eq!(code(3.3), AdcCode(ADC_FULL));
        assert_eq!(code(-1.0), AdcCode(0));
        assert_eq!(code(100.0), AdcCode(ADC_FULL));
        assert_eq!(code(1.65), AdcCode(2048 * 16));
    }

    #[test]
    fn both_halves_of_a_steady_current_are_alike() {
        let mut parameters = Parameters::default();
        parameters.bridge.edges = 1.0;
        parameters.sense.noise_rms_a = 0.0;
        let mut board = Board::new(Plant::new(&parameters, &Grasp::Free, 1).expect("valid"));
        board.plant.faults.rotor_locked = true;
        for _ in 0..100 {
            board.period(DRIVE);
        }
        let inputs = board.inputs();
        assert!(inputs.current.0 > 10_000, "{inputs:?}");
        // An ideal converter, so nothing but what is left of the ripple.
        assert!(i32::from(inputs.late_excess).abs() < 200, "{inputs:?}");
    }

    #[test]
    fn output_acts_a_period_later() {
        let mut board = board();
        for _ in 0..40 {
            board.period(Outputs::Brake);
        }
        board.period(DRIVE);
        assert_eq!(board.plant.truth().motor_current_a, 0.0);
        board.period(DRIVE);
        assert!(board.plant.truth().motor_current_a > 0.05);
        assert!(board.inputs().current.0 > 1000);
    }

    #[test]
    fn break_latches_until_switched_off() {
        let mut board = board();
        for _ in 0..40 {
            board.period(DRIVE);
        }
        board.plant.faults.rotor_locked = true;
        board.plant.faults.winding_left = 0.05;
        for _ in 0..10 {
            board.period(DRIVE);
        }
        board.plant.faults.winding_left = 1.0;
        board.period(DRIVE);
        board.period(DRIVE);
        assert!(board.inputs().bridge_fault && !board.pins().outputs_enabled);
        board.period(Outputs::Off);
        board.period(DRIVE);
        assert!(!board.inputs().bridge_fault && board.pins().outputs_enabled);
    }

    #[test]
    fn encoder_wraps_at_16_bits() {
        let mut board = board();
        board.plant.faults.stops_missing = true;
        for _ in 0..40_000 {
            board.period(DRIVE);
        }
        let count = board.plant.encoder_count();
        assert!(count > 65_536);
        assert_eq!(i64::from(board.inputs().encoder.0), count % 65_536);
    }
}
