//! The fuzz targets as functions of bytes, and the fingers and numbers that the bytes describe. `tests/all/fuzz_seeds.rs` of the
//! library runs them on the seeds in `seeds/`, without a fuzzer.

mod inverse;
mod step;

use palpate::finger::{Assembly, Finger, Levers, Linkage, Mechanics, Parameters, Tendon};

/// Runs the target of the inverse.
pub fn inverse(bytes: &[u8]) {
    with_finger(bytes, &mut inverse::Inverse);
}

/// Runs the target of the contact path.
pub fn step(bytes: &[u8]) {
    with_finger(bytes, &mut step::FiniteStep);
}

/// Reads numbers from bytes: every other bit pattern or a plain number, as the bytes say; zero when they run out.
pub struct Numbers<'b>(pub &'b [u8]);

impl Numbers<'_> {
    /// One byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    /// Any number at all.
    pub fn any(&mut self) -> f32 {
        match self.byte() & 1 {
            0 => f32::from_bits(u32::from_le_bytes([
                self.byte(),
                self.byte(),
                self.byte(),
                self.byte(),
            ])),
            _ => self.plain() * 4.0 - 2.0,
        }
    }

    /// A number from 0 to 1.
    pub fn plain(&mut self) -> f32 {
        f32::from(u16::from_le_bytes([self.byte(), self.byte()])) / f32::from(u16::MAX)
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.plain()
    }
}

/// What a fuzz target does with a finger.
pub trait Task {
    /// Does it.
    fn on<M: Mechanics>(&mut self, finger: &M, numbers: &mut Numbers<'_>);
}

fn parameters<const N: usize>(numbers: &mut Numbers<'_>) -> Parameters<N> {
    let wild = numbers.byte() & 7 == 0;
    let mut draw = |low: f32, high: f32| {
        if wild {
            numbers.any()
        } else {
            numbers.between(low, high)
        }
    };
    let mut parameters = Parameters {
        lengths_m: [0.0; N],
        stiffness_nm_per_rad: [0.0; N],
        rest_rad: [0.0; N],
        range_rad: [[-2.0, 2.5]; N],
    };
    for i in 0..N {
        parameters.lengths_m[i] = draw(0.02, 2.0);
        let stiffness = draw(-0.2, 3.0);
        parameters.stiffness_nm_per_rad[i] = if i == 0 {
            stiffness.max(0.0)
        } else {
            stiffness
        };
        parameters.rest_rad[i] = draw(-1.0, 2.0);
    }
    parameters
}

fn levers(numbers: &mut Numbers<'_>, ground: f32) -> Levers {
    let assembly = if numbers.byte() & 1 == 0 {
        Assembly::Clockwise
    } else {
        Assembly::Counterclockwise
    };
    Levers {
        driving_m: ground * numbers.between(0.3, 1.2),
        coupler_m: ground * numbers.between(0.6, 1.6),
        driven_m: ground * numbers.between(0.1, 0.8),
        offset_rad: numbers.between(-3.2, 3.2),
        assembly,
    }
}

/// Builds the finger that the bytes describe, if there is one, and hands it to the task.
pub fn with_finger(bytes: &[u8], task: &mut impl Task) {
    let mut numbers = Numbers(bytes);
    match numbers.byte() & 3 {
        0 => {
            let (p, radii) = (
                parameters::<2>(&mut numbers),
                [0.1, 0.1 * numbers.between(0.1, 1.5)],
            );
            if let Ok(finger) = Finger::<2, Tendon<2>>::new(p, radii) {
                task.on(&finger, &mut numbers);
            }
        }
        1 => {
            let p = parameters::<2>(&mut numbers);
            let design = [levers(&mut numbers, p.lengths_m[0])];
            if let Ok(finger) = Finger::<2, Linkage<1>>::new(p, design) {
                task.on(&finger, &mut numbers);
            }
        }
        2 => {
            let p = parameters::<3>(&mut numbers);
            let radii = [
                0.1,
                0.1 * numbers.between(0.1, 1.5),
                0.1,
                0.1 * numbers.between(0.1, 1.5),
            ];
            if let Ok(finger) = Finger::<3, Tendon<3>>::new(p, radii) {
                task.on(&finger, &mut numbers);
            }
        }
        _ => {
            let p = parameters::<3>(&mut numbers);
            let design = [
                levers(&mut numbers, p.lengths_m[0]),
                levers(&mut numbers, p.lengths_m[1]),
            ];
            if let Ok(finger) = Finger::<3, Linkage<2>>::new(p, design) {
                task.on(&finger, &mut numbers);
            }
        }
    }
}

/// A posture of the finger, free at some angle or torque, or at rest; with its torque.
pub fn posture<M: Mechanics>(finger: &M, numbers: &mut Numbers<'_>) -> (M::Configuration, f32) {
    let rest = finger.rest();
    match numbers.byte() & 3 {
        0 => (rest, numbers.any()),
        1 => finger
            .free_at_angle(numbers.any(), &rest)
            .map_or((rest, 0.0), |free| (free.configuration, free.torque_nm)),
        _ => {
            let torque = numbers.any();
            finger
                .free_at_torque(torque, &rest)
                .map_or((rest, 0.0), |at| (at, torque))
        }
    }
}
