//! Torque over one turn of the motor in any motion, steady or not.
//!
//! Less exact than a [`Block`] of steady motion, because a change of speed takes torque too and the acceleration comes from two
//! differences of counts: some millinewton metres at the input link. Good enough to see that a load has gone.

use crate::sensing::block::Block;
use crate::sensing::{Drive, Drivetrain, Sample};

/// Samples over which a speed is taken, and the time of one, microseconds.
const TRAIL: usize = 3;
const SAMPLE_US: f32 = 1e3;

/// Time, microseconds, and position, counts.
pub(super) type Place = (u64, i32);

/// Sums of the turn under way.
#[derive(Clone, Debug, Default)]
pub(super) struct TurnMeter {
    trail: [Place; TRAIL],
    /// Samples in it.
    filled: usize,
    began: Option<Place>,
    /// Speed where it began, counts a second.
    speed: f32,
    ampere_us: f32,
}

impl TurnMeter {
    /// The next turn begins here.
    pub(super) fn begin(&mut self, at: Place) {
        self.began = Some(at);
        self.speed = speed(self.trail[0], at);
        self.ampere_us = 0.0;
    }

    /// Takes a sample; the turn when it is complete. `speed_rad_per_s` is the speed that friction was recorded at.
    pub(super) fn push<J>(
        &mut self,
        sample: &Sample<J>,
        drivetrain: &Drivetrain,
        speed_rad_per_s: f32,
    ) -> Option<Block> {
        let now = (sample.time_us, sample.position_counts);
        let speed_now = speed(self.trail[0], now);
        self.trail.rotate_left(1);
        self.trail[TRAIL - 1] = now;
        if self.filled < TRAIL {
            // No speed is known before.
            self.filled += 1;
            return None;
        }
        let Some((began_us, from)) = self.began else {
            self.speed = speed_now;
            self.began = Some(now);
            return None;
        };
        self.ampere_us += sample.current_a * SAMPLE_US;
        let width = now.1.wrapping_sub(from);
        if width < drivetrain.counts_per_turn as i32 {
            return None;
        }
        let duration_s = now.0.saturating_sub(began_us) as f32 * 1e-6;
        let speed_before = core::mem::replace(&mut self.speed, speed_now);
        let ampere_us = core::mem::take(&mut self.ampere_us);
        self.began = Some(now);
        let rad_per_s = |counts: f32| counts * drivetrain.rad_per_count / duration_s;
        let inertia_nm = drivetrain.inertia_kg_m2 * rad_per_s(speed_now - speed_before);
        let deviation = rad_per_s(width as f32) - speed_rad_per_s;
        let viscous_nm = drivetrain.viscous_nm_s_per_rad * deviation;
        let motor_nm = drivetrain.torque_per_ampere_nm * ampere_us * 1e-6 / duration_s;
        Some(Block {
            time_us: now.0,
            drive: Drive::Closing,
            counts: from.wrapping_add(width / 2),
            width_counts: width.unsigned_abs(),
            duration_s,
            drive_torque_nm: motor_nm - inertia_nm - viscous_nm,
            inertia_nm,
            overspeed: deviation / speed_rad_per_s,
        })
    }
}

/// Counts a second from one place to another.
fn speed(from: Place, to: Place) -> f32 {
    let elapsed_s = to.0.saturating_sub(from.0) as f32 * 1e-6;
    if elapsed_s > 0.0 {
        to.1.wrapping_sub(from.1) as f32 / elapsed_s
    } else {
        0.0
    }
}
