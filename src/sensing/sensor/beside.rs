//! What a program beside the sensor asks it: the record's share of a block, the free finger, an early end of a contact.

use super::{Sensor, Stage};
use crate::finger::{Contact, Free, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::sensing::Drivetrain;
use crate::sensing::block::Block;
use crate::sensing::detector::Residual;
use crate::sensing::location::SeriesElement;

impl<F: Mechanics, H: JointSensor, X: SeriesElement> Sensor<F, H, X> {
    /// The drivetrain.
    pub fn drivetrain(&self) -> &Drivetrain {
        &self.state.drivetrain
    }

    /// What the friction record leaves of a block's torque; `None` without a record, or too far beyond it.
    pub fn residual(&self, block: &Block) -> Option<Residual> {
        let corrected = self.state.corrected(block)?;
        Some(self.state.residual(block, &corrected))
    }

    /// By how much the variance of wandering friction grows from one block to the next like this, at the input link, newton metre
    /// squared; 0 without a record.
    pub fn walk_nm2(&self, block: &Block) -> f32 {
        let state = &self.state;
        let speed = state.settings.speed_rad_per_s;
        state.friction.as_ref().map_or(0.0, |friction| {
            let wander = friction.wander(speed);
            let rms_nm = state.drivetrain.efficiency * wander.rms_nm;
            2.0 * rms_nm * rms_nm * block.duration_s / wander.time_s
        })
    }

    /// Angle of the input link over a turn of the worm, radian.
    pub fn worm_turn_rad(&self) -> f32 {
        let drivetrain = &self.state.drivetrain;
        drivetrain.counts_per_worm_turn as f32 * drivetrain.rad_per_count
    }

    /// Posture and torque of the free finger at a measured angle, the cable's twist included.
    pub fn free_at(&self, measured_rad: f32) -> Option<Free<F::Configuration>> {
        self.state.free(measured_rad)
    }

    /// Measured angle of the input link at which the contact that was located last began, as its curve has it, radian.
    pub fn onset_rad(&self) -> f32 {
        self.state.onset_rad
    }

    /// Where the contact just judged as unobservable may be, with the deviation, metre: a quarter of the phalanx at least, or near joint 2
    /// and perhaps on phalanx 1. `None` where the phalanx is not known either, and with two phalanges. The radius is NaN.
    pub fn vague_place(&self) -> Option<(Contact, f32)> {
        match self.stage {
            Stage::Vague(spot) => {
                let contact = Contact {
                    phalanx: spot.phalanx,
                    k_m: spot.k_m,
                    // Known even less.
                    radius_m: f32::NAN,
                };
                Some((contact, spot.sigma_m))
            }
            _ => None,
        }
    }

    /// Whether the input link, behind the cable, is at the closing stop: there the cable alone gives way. `excess_nm` is the
    /// torque above friction.
    pub fn is_at_stop(&self, measured_rad: f32, excess_nm: f32) -> bool {
        self.state.is_at_stop(measured_rad, excess_nm)
    }

    /// As [`Self::conclude`], on the curve up to a position alone: from there on another contact makes the finger stiffer, which the
    /// fit of a single one would take for a place farther out.
    pub fn conclude_before(&mut self, counts: i32) {
        if let Stage::Contact(contact) = &mut self.stage {
            contact.cut(counts);
        }
    }

    /// No more of this contact is to be judged: the last word on it follows.
    pub fn conclude(&mut self) {
        if let Stage::Contact(contact) = &mut self.stage {
            contact.end();
        }
    }
}
