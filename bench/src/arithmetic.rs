//! Checksums of what the library computes over the same pseudo-random inputs on chip and PC: they must have the same bits.

use core::f32::consts::TAU;

use palpate::drive::config::{
    AnalogInputs, CheckedConfig, Config, Gearing, Limits, Motor, OutOfRange, Thermal,
};
use palpate::drive::convert;
use palpate::drive::io::{AdcCode, EncoderCount, Inputs};
use palpate::drive::{Controller, Demand, Setpoint};
use palpate::numeric::{LeastSquares, Rotation, atan2, bisect, exp, ln, sin_cos, solve, sqrt};

use crate::task::Bits;

/// Inputs of each function.
const INPUTS: usize = 500;
/// Control periods that the controller runs.
pub const PERIODS: usize = 4000;

/// A stream of inputs, the same everywhere.
struct Inputs32(u32);

impl Inputs32 {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// From `low` to `high`, in steps that f32 has exactly.
    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 8) as f32 / (1 << 24) as f32)
    }
}

fn checksum(mut result: impl FnMut(&mut Inputs32) -> f32) -> u32 {
    let mut inputs = Inputs32(0x9E37_79B9);
    (0..INPUTS).fold(0, |sum, _| result(&mut inputs).mix(sum))
}

/// Names and checksums, one after the other.
pub fn visit(mut tell: impl FnMut(&'static str, u32)) {
    tell("sqrt", checksum(|x| sqrt(x.between(0.0, 1e3))));
    tell(
        "sin-cos",
        checksum(|x| {
            let (sin, cos) = sin_cos(x.between(-10.0, 10.0));
            sin + 3.0 * cos
        }),
    );
    tell(
        "atan2",
        checksum(|x| atan2(x.between(-1.0, 1.0), x.between(-1.0, 1.0))),
    );
    tell("ln", checksum(|x| ln(x.between(1e-6, 1e6))));
    tell("exp", checksum(|x| exp(x.between(-20.0, 20.0))));
    let mut turned = Rotation::by(0.1);
    tell(
        "rotation",
        checksum(|x| {
            turned = turned.then(Rotation::by(x.between(-3.0, 3.0)));
            turned.rad()
        }),
    );
    tell(
        "solve",
        checksum(|x| {
            let mut number = || x.between(-1.0, 1.0);
            let a = core::array::from_fn(|_| core::array::from_fn(|_| number()));
            let b = [core::array::from_fn(|_| number())];
            solve::<3, 1>(a, b).map_or(f32::NAN, |[[p, q, r]]| p + 3.0 * q + 7.0 * r)
        }),
    );
    tell(
        "bisect",
        checksum(|x| {
            let root = x.between(0.1, 0.9);
            bisect(0.0, 1.0, |at| at * at * at - root).unwrap_or(f32::NAN)
        }),
    );
    let mut squares = LeastSquares::<3>::new();
    tell(
        "least-squares",
        checksum(|x| {
            let a = [x.between(0.2, 0.7), x.between(0.0, 1.0), 1.0];
            squares.add(&a, 0.7 * a[0] - a[1] + x.between(-0.1, 0.1));
            let [p, q, r] = *squares.solution();
            p + 3.0 * q + 7.0 * r
        }),
    );
    tell("controller", controller(|_| ()).unwrap_or(0));
}

/// The control interrupt's work on readings of a motor that does what it likes; a function is called round every step.
///
/// # Errors
/// Never: the configuration is valid.
pub fn controller(mut stepped: impl FnMut(bool)) -> Result<u32, OutOfRange> {
    let mut controller = Controller::new(&CheckedConfig::new(CONFIG)?);
    let mut inputs = Inputs32(7);
    let (mut sum, mut counts) = (0, 0u16);
    for period in 0..PERIODS {
        let setpoint = match period / 400 % 4 {
            0 => Setpoint::Brake,
            1 => Setpoint::Current { a: 0.05 },
            2 => Setpoint::Speed {
                counts_per_s: 60_000.0,
                current_limit_a: 0.06,
            },
            _ => Setpoint::Off,
        };
        counts = counts.wrapping_add((inputs.next() % 4) as u16);
        let input = Inputs {
            current: AdcCode((3000 + inputs.next() % 500) as u16),
            // Up to twice what tells an opposing current.
            late_excess: (inputs.next() % 400) as i16 - 200,
            supply: AdcCode((42_800 + inputs.next() % 100) as u16),
            encoder: EncoderCount(counts),
            bridge_fault: false,
            overrun: false,
        };
        // A fault is as good as none, and is cleared again.
        let demand = Demand {
            setpoint,
            clear: (period / 100) as u8,
            ..Demand::REST
        };
        stepped(true);
        let outputs = controller.step(&input, &demand);
        stepped(false);
        sum = convert::applied(outputs).mix(sum);
        if let Some(sample) = controller.sample() {
            sum = sample.current_a.mix(sum);
            sum = controller.status().winding_c.mix(sum);
        }
    }
    Ok(sum)
}

/// Any drive will do: that of the default scene.
const CONFIG: Config = Config {
    motor: Motor {
        torque_constant_nm_per_a: 8.9e-3,
        resistance_ohm: 35.0,
        choke_ohm: 4.0,
        rotor_inertia_kg_m2: 1e-8,
        thermal: Thermal {
            limit_c: 85.0,
            ambient_c: 25.0,
            winding_k_per_w: 12.0,
            housing_k_per_w: 30.0,
            winding_s: 4.0,
            housing_s: 150.0,
        },
    },
    drivetrain: Gearing {
        counts_per_motor_rev: 1024.0,
        reduction: 1280.0,
    },
    sense: AnalogInputs {
        reference_v: 3.3,
        volt_per_a: 6.8,
        zero_v: 0.0,
        signed: false,
        supply_divider: 100.0 / 18.0,
    },
    limits: Limits {
        current_a: 0.12,
        current_trip_a: 0.25,
        duty: 0.95,
        speed_rad_per_s: 0.8,
        acceleration_rad_per_s2: 10.0,
        position_min_rad: -0.4,
        position_max_rad: TAU,
        overtravel_rad: 0.1,
        supply_min_v: 9.0,
        supply_max_v: 15.0,
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_checksum_is_that_of_nothing_and_the_controller_steps() {
        let mut seen = 0;
        visit(|name, sum| {
            seen += 1;
            // What NaN alone would give.
            let nothing = checksum(|_| f32::NAN);
            assert!(sum != 0 && sum != nothing, "{name}");
        });
        assert_eq!(seen, 10);
        let mut steps = 0;
        controller(|before| steps += usize::from(before)).expect("valid");
        assert_eq!(steps, PERIODS);
    }
}
