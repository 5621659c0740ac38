//! The curve of a contact: which blocks belong to it, and as what points.

use super::search::{CorrectedBlock, Detection};
use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::Directive;
use crate::sensing::curve::{Curve, Point};
use crate::sensing::location::SeriesElement;
use crate::sensing::locator::Noise;
use crate::sensing::settings::ONSET_SIGMA_RAD;
use crate::sensing::torque_constant::ConstantShift;

/// A contact is lost when the torque falls by this share of itself plus this many deviations of a block.
const LOST_SHARE: f32 = 0.03;
pub(in crate::sensing) const LOST_SIGMAS: f32 = 8.0;
/// The same for a slow decrease: the contact slides over the tip, or its object gives way.
pub(in crate::sensing) const FADED_SHARE: f32 = 0.1;
/// Distance from the closing stop at which a contact's curve ends, radian: beyond, only the cable gives way.
const STOP_MARGIN_RAD: f32 = 0.01;
/// Error of friction extrapolated beyond the record, as a share of its unevenness (R, chosen).
const UNSURE_BEYOND: f32 = 0.15;

/// Collects the curve of a contact, with the values at the onset that its points need.
#[derive(Clone, Debug)]
pub(super) struct CurveCollector<H: JointSensor> {
    pub(super) curve: Curve,
    pub(super) phase: CurvePhase,
    /// Error of the record's level at the onset, newton metre of motor torque.
    pub(super) level_nm: f32,
    pub(super) noise: Noise,
    /// Unevenness of friction over the travel, newton metre of motor torque.
    unevenness_nm: f32,
    pub(super) onset_rad: [f32; 2],
    /// What the closing has told of the torque constant when the round of the fit began.
    pub(super) constant: ConstantShift,
    /// Torque factor as free closings have told it, and its standard deviation as a share of it.
    #[cfg(not(weightless))]
    pub(super) closing_factor: Option<[f32; 2]>,
    onset_us: u32,
    /// Reading of joint 2 at the curve's origin.
    pub(super) reading: H::Reading,
    /// What it has told since, up to the last block of the curve, and up to the one before the round of the fit began.
    pub(super) joint: H::Told,
    pub(super) joint_of_round: H::Told,
    /// Torque of the finger's weight at the input link, at the curve's origin and by its angle, newton metre and per radian.
    pub(super) weight: [f32; 2],
    /// Torque that holds joint 2 at its stop, negative where the weight lifts it off, newton metre.
    pub(super) stop_nm: f32,
    /// Torque above friction at the last block.
    pub(super) torque_nm: f32,
    /// The largest of it so far.
    top_nm: f32,
    /// Blocks in a row whose torque had fallen.
    pub(super) fallen: u8,
    /// The torque delayed by the cable's creep, and time of its last update.
    late_nm: f32,
    late_us: u32,
    /// The last block: it is added to the curve when the next one has determined its acceleration.
    pub(super) waiting: CorrectedBlock<H::Reading>,
}

impl<H: JointSensor> CurveCollector<H> {
    /// The contact is lost: no path says what force acts since. One block may be that in which the motor is stopped.
    pub(super) fn is_lost(&self) -> bool {
        self.fallen >= 2
    }
}

/// Phase of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CurvePhase {
    /// The curve grows.
    Growing,
    /// The finger stands at its stop: the curve does not grow any more.
    AtStop,
    /// The curve is complete; the final verdict is due.
    Ending,
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// The curve of a contact that begins about a block.
    #[inline(never)]
    pub(super) fn collector(
        &self,
        detection: &Detection,
        first: &CorrectedBlock<H::Reading>,
    ) -> CurveCollector<H> {
        let efficiency = self.drivetrain.efficiency;
        let wander = &detection.wander;
        let onset = &detection.onset;
        let sigma_rad = onset.sigma_counts * self.drivetrain.rad_per_count;
        let ([weight_nm, weight_nm_per_rad], stop_nm) = self.weight(first.counts);
        CurveCollector {
            curve: Curve::new(first.counts),
            phase: CurvePhase::Growing,
            level_nm: onset.level_nm,
            noise: Noise {
                wander_nm: efficiency * wander.rms_nm,
                wander_s: wander.time_s,
                level_nm: efficiency * wander.level_sigma_nm,
                trend_nm_per_s: efficiency * wander.trend_sigma_nm_per_s,
                speed_rad_per_s: self.settings.speed_rad_per_s,
                worm_error_rad: self.settings.worm_error_rad,
            },
            unevenness_nm: (self.friction.as_ref())
                .and_then(|friction| friction.unevenness_nm())
                .unwrap_or(0.0),
            onset_rad: [
                self.drivetrain.closing_rad(onset.counts as i32),
                sigma_rad.at_least(ONSET_SIGMA_RAD),
            ],
            constant: ConstantShift::default(),
            #[cfg(not(weightless))]
            closing_factor: self.closing_factor(),
            onset_us: first.time_us,
            reading: first.reading,
            joint: H::Told::default(),
            joint_of_round: H::Told::default(),
            weight: [weight_nm, weight_nm_per_rad],
            stop_nm,
            torque_nm: 0.0,
            top_nm: 0.0,
            fallen: 0,
            late_nm: 0.0,
            late_us: first.time_us,
            waiting: *first,
        }
    }

    /// Whether the torque has fallen: the finger slid off, or the object gave way. What comes after is another contact.
    pub(super) fn has_fallen(
        &self,
        collector: &CurveCollector<H>,
        corrected: &CorrectedBlock<H::Reading>,
    ) -> bool {
        let efficiency = self.drivetrain.efficiency;
        let torque_nm = efficiency * (corrected.residual_nm - collector.level_nm);
        let block_nm = efficiency * sqrt(corrected.variance_nm2);
        let fallen_nm = collector.torque_nm - torque_nm;
        let faded_nm = collector.top_nm - torque_nm;
        let noise_nm = LOST_SIGMAS * block_nm;
        fallen_nm > LOST_SHARE * collector.torque_nm + noise_nm
            || faded_nm > FADED_SHARE * collector.top_nm + noise_nm
    }

    /// Adds the previous block to the curve. The acceleration of a block is the mean of the changes from the block before and to
    /// the block after, so that it is complete only now.
    pub(super) fn collect(
        &self,
        collector: &mut CurveCollector<H>,
        next: &CorrectedBlock<H::Reading>,
    ) {
        let corrected = core::mem::replace(&mut collector.waiting, *next);
        let mut point = self.point(collector, &corrected, next.inertia_nm);
        // Wraps after an hour, and a closing takes seconds.
        let elapsed_s = corrected.time_us.wrapping_sub(collector.late_us) as f32 * 1e-6;
        collector.late_us = corrected.time_us;
        collector.late_nm += (elapsed_s / self.drivetrain.creep_s).at_most(1.0)
            * (point.excess_nm - collector.late_nm);
        point.late_nm = collector.late_nm;
        collector.torque_nm = point.excess_nm;
        collector.top_nm = collector.top_nm.at_least(point.excess_nm);
        let measured_rad = self.drivetrain.closing_rad(corrected.counts);
        if !matches!(self.directive, Directive::CalibrateCable)
            && self.is_at_stop(measured_rad, point.excess_nm)
        {
            collector.phase = CurvePhase::AtStop;
        }
        if collector.phase == CurvePhase::Growing {
            let change = H::change(collector.reading, corrected.reading);
            collector.joint = H::told(change, point.excess_nm, point.free_nm);
            collector.curve.push(corrected.counts, point);
        }
    }

    /// Whether the input link, behind the cable, is at the closing stop.
    pub(super) fn is_at_stop(&self, measured_rad: f32, excess_nm: f32) -> bool {
        let mut link_rad = measured_rad;
        if X::FLEXIBLE {
            let calibration = &self.calibration;
            let twist = calibration.cable_rad_per_nm - calibration.cable_sigma_rad_per_nm;
            link_rad -= twist.at_least(0.0) * excess_nm.at_least(0.0);
        }
        let stop_rad = self.drivetrain.opening_stop_rad + self.settings.closing_stop_rad;
        link_rad > stop_rad - STOP_MARGIN_RAD
    }

    /// A block as a point of the curve; `next_nm` is the inertia's torque in the block after it.
    pub(super) fn point(
        &self,
        collector: &CurveCollector<H>,
        corrected: &CorrectedBlock<H::Reading>,
        next_nm: f32,
    ) -> Point {
        let drivetrain = &self.drivetrain;
        let efficiency =
            drivetrain.efficiency * (1.0 + drivetrain.efficiency_per_speed * corrected.overspeed);
        let residual_nm = corrected.residual_nm + 0.5 * (corrected.inertia_nm - next_nm);
        let inertia_nm = drivetrain.inertia_sigma * 0.5 * (corrected.inertia_nm + next_nm);
        let mut variance = corrected.variance_nm2 + inertia_nm * inertia_nm;
        if corrected.beyond_counts > 0.0 {
            // The error has the same sign for a good part of a period.
            let unevenness_nm = UNSURE_BEYOND * collector.unevenness_nm;
            let periods =
                drivetrain.counts_per_worm_turn as f32 / corrected.width_counts.max(1) as f32;
            variance += unevenness_nm * unevenness_nm * 0.25 * periods;
        }
        let [weight_nm, per_rad] = collector.weight;
        let turned_rad = drivetrain.rotation_rad(collector.curve.origin_counts(), corrected.counts);
        let weight_nm = weight_nm + per_rad * turned_rad;
        Point {
            // A curve is shorter than half an hour.
            time_s: corrected.time_us.wrapping_sub(collector.onset_us) as i32 as f32 * 1e-6,
            excess_nm: efficiency * (residual_nm - collector.level_nm),
            // Nothing below zero shows: there the weight closes the finger, and a worm passes it no more than what rubs.
            free_nm: (corrected.free_nm + weight_nm).at_least(0.0),
            variance_nm2: efficiency * efficiency * variance,
            width_counts: corrected.width_counts as f32,
            ..Point::EMPTY
        }
    }
}
