//! The finger closes and nothing is felt yet: the detector on what the friction record leaves of each block.

use super::{Sensor, Work};
use crate::finger::{Free, Mechanics};
use crate::sensing::block::Block;
use crate::sensing::detector::{self, Detector, Finding};
use crate::sensing::fit;
use crate::sensing::joint::JointSensor;
use crate::sensing::{Directive, Event};

/// Blocks kept, so that the curve starts at the onset and not at its detection: a quarter of a second.
pub(super) const HISTORY: usize = 32;

/// A block as it is remembered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Past<R> {
    pub(super) time_us: u64,
    pub(super) counts: i32,
    pub(super) width_counts: u32,
    pub(super) residual_nm: f32,
    /// How far beyond the friction record, counts.
    pub(super) beyond_counts: f32,
    /// As in [`Block`].
    pub(super) inertia_nm: f32,
    pub(super) overspeed: f32,
    pub(super) reading: R,
}

impl<F: Mechanics, H: JointSensor> Sensor<F, H> {
    /// A block with the residual of the record.
    pub(super) fn past(&self, block: &Block) -> Option<Past<H::Reading>> {
        let friction = self.friction.as_ref()?;
        let (torque_nm, beyond_counts) = if self.directive == Directive::CalibrateCable
            || matches!(self.work, Work::Contact(_))
        {
            let period_counts = self.drivetrain.counts_per_worm_turn;
            friction.beyond(block.drive, block.counts, period_counts)?
        } else {
            (friction.at(block.drive, block.counts)?, 0.0)
        };
        Some(Past {
            time_us: block.time_us,
            counts: block.counts,
            width_counts: block.width_counts,
            residual_nm: block.drive_torque_nm - torque_nm,
            beyond_counts,
            inertia_nm: block.inertia_nm,
            overspeed: block.overspeed,
            reading: self.reading,
        })
        .filter(|past| past.residual_nm.is_finite())
    }

    /// Nothing felt yet.
    pub(super) fn search(&mut self, block: &Block, past: Past<H::Reading>) {
        let residual_nm = past.residual_nm;
        let Some(friction) = &self.friction else {
            return;
        };
        let (Some(noise), Some(mean_nm)) = (
            friction.noise_nm2_counts(block.drive),
            friction.closing.mean_nm(),
        ) else {
            return;
        };
        let theta_a_rad = self.drivetrain.closing_rad(block.counts);
        if let Some(free) = self.free(theta_a_rad) {
            self.posture = free.configuration;
        }
        if self.history.is_full() {
            self.history.pop_front();
        }
        let _ = self.history.push_back(past);
        let settings = &self.settings;
        let detector = self.detector.get_or_insert_with(|| {
            let blocks = friction.travel_counts as f32 / block.width_counts.max(1) as f32;
            Detector::new(
                detector::threshold(settings.false_alarms_per_closing, blocks),
                mean_nm,
                noise,
            )
        });
        let finding = detector.push(residual_nm, block.width_counts);
        let level = detector.level();
        match finding {
            Finding::Free => {}
            Finding::Stale { misfit_nm } => {
                if !self.stale_told && self.directive != Directive::CalibrateCable {
                    self.stale_told = true;
                    self.tell(Event::FrictionStale { misfit_nm });
                }
            }
            // Beyond the record, on the way to the stop, friction may well be less.
            Finding::Softer { .. } if self.directive == Directive::CalibrateCable => {
                self.detector = None;
            }
            Finding::Softer { .. } => {
                self.done = true;
                self.tell_unusual(theta_a_rad, residual_nm - level.0);
            }
            Finding::Contact { since } => self.touch(block, since, level, noise),
        }
    }

    fn tell_unusual(&mut self, theta_a_rad: f32, excess_nm: f32) {
        let rest_rad = self.finger.input_angle_rad(&self.finger.rest());
        let expected = self
            .free(theta_a_rad)
            .and_then(|free| self.finger.expected_k_a(&free))
            .unwrap_or(0.0);
        let way_rad = theta_a_rad - rest_rad;
        let excess = self.drivetrain.efficiency * excess_nm / way_rad;
        self.tell(Event::Unusual {
            k_a_nm_per_rad: if excess.is_finite() {
                expected + excess
            } else {
                expected
            },
            k_a_free_nm_per_rad: expected,
        });
    }

    /// Posture and torque of the free finger at a measured angle.
    pub(super) fn free(&self, measured_rad: f32) -> Option<Free<F::Configuration>> {
        let creep = self.drivetrain.creep[0];
        fit::free_behind_cable(
            &self.finger,
            measured_rad,
            &self.calibration,
            creep,
            &self.posture,
        )
    }
}
