//! Tests of the sensing by synthetic signals; against the simulated world it is tested in the host crates.

#[cfg(feature = "firmware")]
mod again;
mod alignment;
mod block;
mod calibration;
mod curve;
mod detector;
#[cfg(feature = "firmware")]
mod following;
mod free;
mod friction;
// With the fingers of the scenes.
#[cfg(feature = "firmware")]
mod joint;
#[cfg(feature = "firmware")]
pub(super) mod locator;
mod operating_curve;
#[cfg(feature = "firmware")]
mod pins;
mod recording;
mod second;
#[cfg(feature = "firmware")]
mod sensor;
mod softer;
#[cfg(feature = "firmware")]
mod sprung;
#[cfg(feature = "firmware")]
mod stopped;
mod torque_constant;
mod wander;

use crate::sensing::{Drivetrain, Settings};

/// Round numbers: 1000 counts a turn of the motor, 1e-5 rad a count.
pub(in crate::sensing) fn drivetrain() -> Drivetrain {
    Drivetrain {
        torque_constant_sigma: 0.058,
        resistance_ohm: 39.0,
        rad_per_count: 1e-5,
        counts_per_turn: 1000,
        counts_per_worm_turn: 32_000,
        creep: 0.05,
        creep_s: 5.0,
        opening_stop_rad: 0.0,
        torque_per_ampere_nm: 10.0,
        efficiency: 0.3,
        inertia_kg_m2: 0.01,
        inertia_sigma: 0.1,
        viscous_nm_s_per_rad: 0.0,
        efficiency_per_speed: 0.0,
        weight_share: 0.4,
        backlash_rad: 0.01,
    }
}

/// 0.3 rad/s: 30 counts a millisecond.
fn settings() -> Settings {
    Settings {
        travel_rad: 1.0,
        ..Settings::default()
    }
}

/// Normal noise that is the same in every run.
#[derive(Clone)]
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Standard normal: twelve uniform values.
    fn normal(&mut self) -> f32 {
        ((0..12).map(|_| self.uniform()).sum::<f64>() - 6.0) as f32
    }
}
