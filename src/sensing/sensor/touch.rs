//! A contact in hand, and how its curve grows.

use super::search::Past;
use super::{Sensor, UNSURE_BEYOND, Work};
use crate::finger::Mechanics;
use crate::numeric::sqrt;
use crate::sensing::Event;
use crate::sensing::block::Block;
use crate::sensing::curve::{Curve, Point};
use crate::sensing::joint::JointSensor;
use crate::sensing::locator::{Locator, Verdict};

/// A contact in hand.
#[derive(Clone, Debug)]
pub(super) struct Touching<R> {
    pub(super) curve: Curve,
    pub(super) locator: Locator,
    /// What the record's level was off by, and its deviation, newton metre of motor torque.
    pub(super) level_nm: f32,
    pub(super) level_sigma_nm: f32,
    pub(super) noise_nm2_counts: f32,
    /// How uneven the friction is over the travel, newton metre of motor torque.
    pub(super) unevenness_nm: f32,
    pub(super) onset_rad: f32,
    pub(super) reading: R,
    pub(super) torque_nm: f32,
    /// The torque as the cable's creep feels it, and when it was last brought up to date.
    pub(super) late_nm: f32,
    pub(super) late_us: u64,
    /// The last block: it joins the curve when its neighbour has told its acceleration.
    pub(super) waiting: Past<R>,
    /// Torque and deviation when it was last asked whether more torque helps.
    pub(super) asked: (f32, f32),
    pub(super) reported: Reported,
    /// The last verdict from a curve that was explained well, and its misfit.
    pub(super) good: Option<(Verdict, f32)>,
    /// Rounds in a row whose misfit was much worse.
    pub(super) worse: u8,
    /// Steps left after the motion ended; None while it goes on.
    pub(super) last_steps: Option<u8>,
    /// Samples until the next of them.
    pub(super) pause: u8,
    pub(super) settled: bool,
}

/// What was said last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reported {
    Nothing,
    Located { phalanx: u8, k_m: f32, sigma_m: f32 },
    Ambiguous,
}

impl<F: Mechanics, H: JointSensor> Sensor<F, H> {
    /// A contact is decided.
    #[inline(never)]
    pub(super) fn touch(&mut self, block: &Block, since: usize, level: (f32, f32), noise: f32) {
        let first = self.history.len().saturating_sub(since);
        let Some(onset) = self.history.iter().nth(first).copied() else {
            return;
        };
        let mut touching = Touching {
            curve: Curve::new(onset.counts, onset.width_counts),
            locator: Locator::default(),
            level_nm: level.0,
            level_sigma_nm: sqrt(level.1.max(0.0)),
            noise_nm2_counts: noise,
            unevenness_nm: self
                .friction
                .as_ref()
                .and_then(|friction| friction.unevenness_nm(block.drive))
                .unwrap_or(0.0),
            onset_rad: self.drivetrain.closing_rad(onset.counts),
            reading: onset.reading,
            torque_nm: 0.0,
            late_nm: 0.0,
            late_us: onset.time_us,
            waiting: onset,
            asked: (0.0, f32::INFINITY),
            reported: Reported::Nothing,
            good: None,
            worse: 0,
            last_steps: None,
            pause: 0,
            settled: false,
        };
        for past in self.history.iter().skip(first + 1) {
            self.add(&mut touching, past);
        }
        self.history.clear();
        self.detector = None;
        self.tell(Event::Touch {
            time_us: block.time_us,
            theta_a_rad: touching.onset_rad,
            torque_nm: touching.torque_nm,
        });
        self.work = Work::Contact(touching);
    }

    /// Adds a block to the curve: the one before it, that is. A block's own acceleration is half that since the block
    /// before and half that to the one after.
    pub(super) fn add(&self, touching: &mut Touching<H::Reading>, next: &Past<H::Reading>) {
        let mut past = core::mem::replace(&mut touching.waiting, *next);
        past.residual_nm += 0.5 * (past.inertia_nm - next.inertia_nm);
        let drivetrain = &self.drivetrain;
        let efficiency =
            drivetrain.efficiency * (1.0 + drivetrain.efficiency_per_speed * past.overspeed);
        let free_nm = self
            .free(drivetrain.closing_rad(past.counts))
            .map_or(0.0, |free| free.torque_nm);
        let excess_nm = efficiency * (past.residual_nm - touching.level_nm);
        let torque_nm = excess_nm + free_nm / self.calibration.torque_factor;
        let elapsed_s = past.time_us.saturating_sub(touching.late_us) as f32 * 1e-6;
        touching.late_us = past.time_us;
        touching.late_nm +=
            (elapsed_s / drivetrain.creep_s).min(1.0) * (excess_nm - touching.late_nm);
        let mut noise = touching.noise_nm2_counts;
        if past.beyond_counts > 0.0 {
            // Wrong for a good part of a period in the same direction.
            let unevenness_nm = UNSURE_BEYOND * touching.unevenness_nm;
            noise += unevenness_nm * unevenness_nm * 0.25 * drivetrain.counts_per_worm_turn as f32;
        }
        let variance = efficiency * efficiency * noise / past.width_counts.max(1) as f32;
        touching.curve.push(
            past.counts,
            Point {
                torque_nm,
                late_nm: touching.late_nm,
                inertia_nm: 0.5 * efficiency * (past.inertia_nm + next.inertia_nm),
                variance_nm2: variance,
                ..Point::default()
            },
        );
        touching.torque_nm = excess_nm;
    }
}
