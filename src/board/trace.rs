//! Samples as log lines, while a user wants them: what `cargo xtask record` writes to a file and `replay` reads.
//!
//! The sensing task writes them, never the control interrupt. A line that finds the log full is dropped and counted like any
//! other, so that a slow reader costs samples and delays nothing.

use core::sync::atomic::{AtomicU16, Ordering};

use palpate::app::log::Log;
use palpate::sample::{Drive, Sample};

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

/// Takes each sample, with the angle of joint 2 where it is measured, and logs it if its turn has come.
pub fn sample<J>(sample: &Sample<J>, joint_rad: Option<f32>) {
    let every = EVERY.load(Ordering::Relaxed);
    if every == 0 {
        return;
    }
    let left = LEFT.load(Ordering::Relaxed);
    if left > 0 {
        LEFT.store(left - 1, Ordering::Relaxed);
        return;
    }
    LEFT.store(every - 1, Ordering::Relaxed);
    let drive = match sample.drive {
        Drive::Closing => 1,
        Drive::Opening => -1,
        Drive::Idle => 0,
    };
    Telemetry.sample(
        sample.time_us,
        sample.position_counts,
        sample.current_a,
        drive,
        joint_rad.unwrap_or(f32::NAN),
    );
}
