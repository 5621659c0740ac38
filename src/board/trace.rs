//! Samples as log lines, while a user wants them: what `cargo xtask record` writes to a file and `replay` reads.
//!
//! The sensing task writes them, never the control interrupt. A line that finds the log full is dropped and counted like any
//! other, so that a slow reader costs samples and delays nothing.

use core::sync::atomic::{AtomicU16, Ordering};

use palpate::app::log::Log;
use palpate::sample::{Drive, Sample};
use palpate::sensing::Suspicion;

use super::telemetry::Telemetry;

/// Every so many samples a line; 0 for none.
static EVERY: AtomicU16 = AtomicU16::new(0);
/// Samples until the next line.
static LEFT: AtomicU16 = AtomicU16::new(0);

/// Streams every so many samples from now on; 0 ends it.
pub fn stream(every: u16) {
    LEFT.store(0, Ordering::Relaxed);
    EVERY.store(every, Ordering::Relaxed);
}

/// The next sample is to be logged. Call once for each.
pub fn due() -> bool {
    let every = EVERY.load(Ordering::Relaxed);
    if every == 0 {
        return false;
    }
    let left = LEFT.load(Ordering::Relaxed);
    LEFT.store(
        if left > 0 { left - 1 } else { every - 1 },
        Ordering::Relaxed,
    );
    left == 0
}

/// Logs a sample, with the angle of joint 2 where it is measured, and what the search for a contact made of it.
pub fn sample<J>(sample: &Sample<J>, joint_rad: Option<f32>, suspicion: Option<Suspicion>) {
    let unknown = Suspicion {
        residual_nm: f32::NAN,
        ln_ratio: f32::NAN,
        threshold: f32::NAN,
    };
    let Suspicion {
        residual_nm,
        ln_ratio,
        threshold,
    } = suspicion.unwrap_or(unknown);
    let drive = match sample.drive {
        Drive::Closing => 1,
        Drive::Opening => -1,
        Drive::Idle => 0,
    };
    Telemetry.sample(
        sample.time_us,
        sample.position_counts,
        sample.current_a,
        sample.emf_v,
        drive,
        joint_rad.unwrap_or(f32::NAN),
        residual_nm * 1e3,
        ln_ratio,
        threshold,
    );
}
