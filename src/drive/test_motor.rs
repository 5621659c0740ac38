//! A motor for tests, f64: rotor with friction and back-EMF, a self-locking gear to a link between two elastic stops, an
//! unsigned noisy current sense, an encoder that wraps. Deliberately simple: the real drivetrain is the simulated plant's.

use super::io::{AdcCode, Direction, EncoderCount, Inputs, Outputs};
use core::f64::consts::TAU;

/// Steps of the simulation a control period.
const STEPS: u32 = 3;

/// What is wrong with the bench.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Defect {
    #[default]
    Nothing,
    PhaseCut,
    EncoderDead,
    EncoderReversed,
    EncoderNoise,
    EncoderJump,
    SenseZero,
    SenseFull,
    SenseStuck,
    SenseOffset,
    RotorLocked,
    NoStop,
    SupplyLow,
    SupplyHigh,
    BridgeFault,
    Overrun,
    Short,
}

/// The simulated motor.
pub(crate) struct TestMotor {
    pub resistance_ohm: f64,
    pub torque_constant: f64,
    pub inertia: f64,
    pub friction_nm: f64,
    pub supply_v: f64,
    pub offset_a: f64,
    pub gain: f64,
    pub noise_a: f64,
    /// Link angle where an object begins, radian.
    pub object_rad: f64,
    pub object_nm_per_rad: f64,
    pub wrong: Defect,
    pub speed: f64,
    pub angle: f64,
    pub current_a: f64,
    random: u64,
    period: u64,
    last_code: u16,
    last_count: u16,
}

impl TestMotor {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            // Winding and choke.
            resistance_ohm: 39.0,
            torque_constant: 8.9e-3,
            inertia: 1e-8,
            friction_nm: 0.15e-3,
            supply_v: 12.0,
            offset_a: 3e-3,
            gain: 1.0,
            noise_a: 0.5e-3,
            object_rad: f64::INFINITY,
            object_nm_per_rad: 1.0,
            wrong: Defect::Nothing,
            speed: 0.0,
            angle: 0.05 * 1280.0,
            current_a: 0.0,
            random: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1,
            period: 0,
            last_code: 0,
            last_count: 0,
        }
    }

    pub(crate) fn link_rad(&self) -> f64 {
        self.angle / 1280.0
    }

    /// Uniform, -0.5 to 0.5.
    pub(crate) fn random(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// Torque of the load at the link: cable against a stop, object; positive when it opens.
    fn load_nm(&self) -> f64 {
        let link = self.link_rad();
        let stops = self.wrong != Defect::NoStop;
        let opening = if stops {
            (0.0 - link).max(0.0) * -1.2
        } else {
            0.0
        };
        let closing = if stops {
            (link - 1.6).max(0.0) * 1.2
        } else {
            0.0
        };
        opening + closing + (link - self.object_rad).max(0.0) * self.object_nm_per_rad
    }

    /// One control period with these outputs; what the chip reads at its end.
    pub(crate) fn step(&mut self, outputs: Outputs) -> Inputs {
        self.period += 1;
        let supply_v = match self.wrong {
            Defect::SupplyLow => 5.0,
            Defect::SupplyHigh => 17.5,
            _ => self.supply_v,
        };
        let (voltage, sign, driven) = match outputs {
            Outputs::Off => (0.0, 0.0, false),
            Outputs::Wake | Outputs::Brake => (0.0, 0.0, true),
            Outputs::Drive { direction, duty } => {
                let sign = if direction == Direction::Closing {
                    1.0
                } else {
                    -1.0
                };
                (sign * supply_v * f64::from(duty.0) / 850.0, sign, true)
            }
        };
        let mut sensed_a = 0.0;
        let ripple = 1.0 + 0.025 * (10.0 * self.angle).sin();
        for _ in 0..STEPS {
            let emf_v = self.torque_constant * self.speed * ripple;
            self.current_a = if driven {
                (voltage - emf_v) / self.resistance_ohm
            } else {
                0.0
            };
            if self.wrong == Defect::Short {
                self.current_a = voltage / 20.0;
            }
            let drive_nm = self.torque_constant * self.current_a;
            // The worm: friction grows with the load's magnitude, and no load ever drives the motor.
            let load = self.load_nm() / 1280.0;
            let assisting = load * self.speed < 0.0;
            let resisting_nm = self.friction_nm + load.abs() * if assisting { 0.4 } else { 2.6 };
            let step_s = 50e-6 / f64::from(STEPS);
            let free = self.speed + drive_nm / self.inertia * step_s;
            let brake = resisting_nm / self.inertia * step_s;
            self.speed = if free.abs() <= brake {
                0.0
            } else {
                free - brake * free.signum()
            };
            if self.wrong == Defect::RotorLocked {
                self.speed = 0.0;
            }
            self.angle += self.speed * step_s;
            sensed_a += (self.current_a * sign).max(0.0) / f64::from(STEPS);
        }
        let noise_a = self.noise_a * 12f64.sqrt() * self.random();
        let offset_a = if self.wrong == Defect::SenseOffset {
            20e-3
        } else {
            self.offset_a
        };
        let code = ((sensed_a * self.gain + offset_a + noise_a) * 6.8 / 3.3 * 65_520.0)
            .clamp(0.0, 65_520.0) as u16;
        let code = match self.wrong {
            Defect::SenseZero => 0,
            Defect::SenseFull => 65_520,
            Defect::SenseStuck => self.last_code,
            _ => code,
        };
        self.last_code = code;
        let counts = (self.angle / TAU * 1024.0 + 1.5 * (self.angle).sin()).floor() as i64;
        let count = match self.wrong {
            Defect::PhaseCut => self.last_count ^ (counts as u16 & 1),
            Defect::EncoderDead => self.last_count,
            Defect::EncoderReversed => (counts as u16).wrapping_neg(),
            Defect::EncoderNoise => {
                (counts as u16).wrapping_add_signed((self.random() * 24.0) as i16)
            }
            Defect::EncoderJump => (counts as u16).wrapping_add(1000),
            _ => {
                self.last_count = counts as u16;
                counts as u16
            }
        };
        let supply_noise_v = 0.02 * self.random();
        Inputs {
            current: AdcCode(code),
            late_excess: 0,
            supply: AdcCode(
                ((supply_v + supply_noise_v) * 0.18 / 3.3 * 65_520.0).clamp(0.0, 65_520.0) as u16,
            ),
            encoder: EncoderCount(count),
            bridge_fault: self.wrong == Defect::BridgeFault,
            overrun: self.wrong == Defect::Overrun,
        }
    }
}
