//! A contact in hand, and how its curve grows.

use super::known::Known;
use super::search::{Begun, Past};
use super::{Sensor, UNSURE_BEYOND, Work};
use crate::finger::Mechanics;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::block::Block;
use crate::sensing::curve::{Curve, Point};
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;
use crate::sensing::locator::{Locator, Verdict};
use crate::sensing::{Event, Friction};

/// What is measured of a contact.
#[derive(Clone, Debug)]
pub(super) struct Touch<R> {
    pub(super) curve: Curve,
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
    late_nm: f32,
    late_us: u64,
    /// The last block: it joins the curve when its neighbour has told its acceleration.
    pub(super) waiting: Past<R>,
}

/// A contact in hand.
#[derive(Clone, Debug)]
pub(super) struct Touching<R> {
    pub(super) touch: Touch<R>,
    pub(super) locator: Locator,
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

impl<F: Mechanics, H: JointSensor, X: Series> Sensor<F, H, X> {
    /// A contact is decided: from here on it is what is in hand.
    // Not inlined: the curve lies on the stack meanwhile, and should not for the other users of the caller's frame.
    #[inline(never)]
    pub(super) fn begin(&mut self, block: &Block, found: &Begun) {
        let Work::Searching(search) = &self.work else {
            return;
        };
        let history = &search.history;
        let since = history.len().saturating_sub(found.onset.since);
        let Some(first) = history.get(since) else {
            return;
        };
        let known = &mut self.known;
        let mut touch = known.touch(found, first);
        for index in since + 1..history.len() {
            if let Some(past) = history.get(index) {
                known.add(&mut touch, past);
            }
        }
        known.tell(Event::Touch {
            time_us: block.time_us,
            theta_a_rad: touch.onset_rad,
            torque_nm: touch.torque_nm,
        });
        touch.take(&mut self.work);
    }
}

impl<R> Touch<R> {
    /// Becomes what is in hand.
    // Not inlined: so the whole is written where it stays, not in a frame first.
    #[inline(never)]
    fn take(self, work: &mut Work<R>) {
        *work = Work::Contact(Touching {
            touch: self,
            locator: Locator::default(),
            asked: (0.0, f32::INFINITY),
            reported: Reported::Nothing,
            good: None,
            worse: 0,
            last_steps: None,
            pause: 0,
            settled: false,
        });
    }
}

/// What was said last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reported {
    Nothing,
    Located { phalanx: u8, k_m: f32, sigma_m: f32 },
    Ambiguous,
}

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    /// A curve from the block on with which a contact began.
    #[inline(never)]
    fn touch(&self, found: &Begun, first: &Past<H::Reading>) -> Touch<H::Reading> {
        Touch {
            curve: Curve::new(first.counts, first.width_counts),
            level_nm: found.onset.level_nm,
            level_sigma_nm: sqrt(found.onset.level_variance_nm2.at_least(0.0)),
            noise_nm2_counts: found.noise_nm2_counts,
            unevenness_nm: self
                .friction
                .as_ref()
                .and_then(Friction::unevenness_nm)
                .unwrap_or(0.0),
            onset_rad: self.drivetrain.closing_rad(first.counts),
            reading: first.reading,
            torque_nm: 0.0,
            late_nm: 0.0,
            late_us: first.time_us,
            waiting: *first,
        }
    }

    /// Adds a block to the curve: the one before it, that is. A block's own acceleration is half that since the block
    /// before and half that to the one after.
    pub(super) fn add(&self, touch: &mut Touch<H::Reading>, next: &Past<H::Reading>) {
        let mut past = core::mem::replace(&mut touch.waiting, *next);
        past.residual_nm += 0.5 * (past.inertia_nm - next.inertia_nm);
        let drivetrain = &self.drivetrain;
        let efficiency =
            drivetrain.efficiency * (1.0 + drivetrain.efficiency_per_speed * past.overspeed);
        let free_nm = self
            .free(drivetrain.closing_rad(past.counts))
            .map_or(0.0, |free| free.torque_nm);
        let excess_nm = efficiency * (past.residual_nm - touch.level_nm);
        let torque_nm = excess_nm + free_nm / self.calibration.torque_factor;
        // A closing does not take an hour.
        let elapsed_s = past.time_us.wrapping_sub(touch.late_us) as u32 as f32 * 1e-6;
        touch.late_us = past.time_us;
        touch.late_nm +=
            (elapsed_s / drivetrain.creep_s).at_most(1.0) * (excess_nm - touch.late_nm);
        let mut noise = touch.noise_nm2_counts;
        if past.beyond_counts > 0.0 {
            // Wrong for a good part of a period in the same direction.
            let unevenness_nm = UNSURE_BEYOND * touch.unevenness_nm;
            noise += unevenness_nm * unevenness_nm * 0.25 * drivetrain.counts_per_worm_turn as f32;
        }
        let variance = efficiency * efficiency * noise / past.width_counts.max(1) as f32;
        touch.curve.push(
            past.counts,
            Point {
                torque_nm,
                late_nm: touch.late_nm,
                inertia_nm: 0.5 * efficiency * (past.inertia_nm + next.inertia_nm),
                variance_nm2: variance,
                ..Point::EMPTY
            },
        );
        touch.torque_nm = excess_nm;
    }
}
