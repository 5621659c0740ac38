//! A closing in contact: what its blocks show, and what a change of slope in it means.

use super::{Followed, Grip};
use crate::finger::{Contact, HoldsTwice, Mechanics, NoSecondContact, SecondMeasured, TwoContacts};
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::Sensor;
use crate::sensing::location::SeriesElement;
use crate::sensing::second::{Later, SecondContact, SlopeChange};

/// A contact is lost when two blocks in a row lie below the largest torque so far by this share of it, and their noise.
const LOST_SHARE: f32 = 0.1;

/// The first contact as the sensor's last word has it.
#[derive(Clone, Copy, Debug)]
pub(super) enum First {
    /// The last word is still to come.
    Awaited,
    /// A contact without a place.
    Unplaced,
    /// Where, and the deviation.
    At(Contact, f32),
}

/// A closing in contact.
#[derive(Clone, Debug)]
pub(super) struct Closing<C> {
    /// Angle of the input link at the onset, radian.
    pub(super) onset_rad: f32,
    /// What the record's level was off by at the onset, newton metre at the input link.
    pub(super) level_nm: f32,
    /// When the last block was, its torque above friction, and with what the springs of the free finger take.
    pub(super) last_us: u64,
    pub(super) excess_nm: f32,
    pub(super) torque_nm: f32,
    /// Encoder position in the middle of it.
    pub(super) counts: i32,
    /// The largest `excess_nm`, and blocks in a row far below it.
    pub(super) top_nm: f32,
    pub(super) fallen: u8,
    pub(super) change: Option<SlopeChange>,
    /// Blocks since it was found, and the slope some blocks after it.
    pub(super) since: u8,
    pub(super) later: Option<Later>,
    /// Nothing more is looked for: the change of slope was found and measured, or the finger stands.
    pub(super) is_over: bool,
    pub(super) first: First,
    pub(super) grip: Grip,
    pub(super) held: Option<TwoContacts<C>>,
}

impl<C: Copy> Closing<C> {
    /// Whether the contact has let go: the finger slid off, or the object gave way.
    pub(super) fn is_lost(&mut self, noise_nm: f32) -> bool {
        self.top_nm = self.top_nm.at_least(self.excess_nm);
        let has_fallen = self.top_nm - self.excess_nm > LOST_SHARE * self.top_nm + noise_nm;
        self.fallen = if has_fallen { self.fallen + 1 } else { 0 };
        self.fallen > 1
    }

    /// No more is to come: what the blocks show counts.
    pub(super) fn end(&mut self, search: &mut SecondContact) {
        self.is_over = true;
        self.change = self.change.or_else(|| search.finish());
    }

    /// Takes what the blocks after a change of slope show, of which there is one more.
    pub(super) fn measure(&mut self, search: &SecondContact, variance_nm2: f32) {
        if let Some(change) = &self.change {
            self.since = self.since.saturating_add(1);
            self.later = search.later(change, variance_nm2).or(self.later);
        }
    }

    /// Whether a change of slope is a second contact, and what is known of it.
    pub(super) fn second_contact<F, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        change: &SlopeChange,
    ) -> Option<Followed>
    where
        F: HoldsTwice + Mechanics<Configuration = C>,
    {
        let calibration = sensor.calibration();
        let (cable, cable_sigma) = if X::FLEXIBLE {
            // Kept for a nominal torque.
            (
                calibration.cable_rad_per_nm / calibration.torque_factor,
                calibration.cable_sigma_rad_per_nm / calibration.torque_factor,
            )
        } else {
            (0.0, 0.0)
        };
        // What is not known of the torque is not known of the slope.
        let factor_share = calibration.torque_factor_sigma / calibration.torque_factor;
        let slope_sigma = factor_share * change.after_nm_per_rad;
        let change = SlopeChange {
            after_sigma_nm_per_rad: sqrt(
                change.after_sigma_nm_per_rad * change.after_sigma_nm_per_rad
                    + slope_sigma * slope_sigma,
            ),
            ..*change
        };
        let (compliance_rad_per_nm, compliance_sigma_rad_per_nm) =
            change.compliance(cable, cable_sigma);
        let is_rigid = change.is_rigid(cable, cable_sigma);
        // With two phalanges both in contact nothing is left to move.
        if !is_rigid && F::PHALANGES == 2 {
            return None;
        }
        let held = match self.first {
            First::At(contact, first_sigma_m) => {
                let free = sensor.free_at(self.onset_rad)?;
                let settings = sensor.settings();
                let measured = SecondMeasured {
                    rise_nm: (change.torque_nm - free.torque_nm).at_least(0.0),
                    compliance_rad_per_nm,
                    compliance_sigma_rad_per_nm,
                    first_sigma_m,
                    friction: settings.contact_friction,
                    half_thickness_m: settings.half_thickness_m,
                    leverage_sigma: settings.leverage_sigma,
                };
                match sensor.finger().second_contact(&free, contact, &measured) {
                    Ok(held) => Some(held),
                    Err(NoSecondContact::AtStop) => return None,
                    Err(NoSecondContact::Unexplained) => None,
                }
            }
            First::Awaited | First::Unplaced => None,
        };
        // With three phalanges a motion is left, unless the stiffness itself says that it is not.
        let is_enveloped = F::PHALANGES == 2 || change.is_rigid(cable, 0.0);
        self.grip = if is_enveloped {
            Grip::Enveloped
        } else {
            Grip::TwoContacts
        };
        self.held = held;
        let (phalanx, k_m, sigma_m) = held.map_or((0, f32::NAN, f32::NAN), |held| {
            (held.phalanx, held.k_m, held.sigma_m)
        });
        let free = sensor.free_at(change.theta_a_rad);
        let free_nm = free.map_or(0.0, |free| free.torque_nm);
        Some(Followed::SecondContact {
            phalanx,
            k_m,
            sigma_m,
            theta_a_rad: change.theta_a_rad,
            torque_nm: (change.torque_nm - free_nm) / calibration.torque_factor,
            stiffness_nm_per_rad: change.after_nm_per_rad,
            stiffness_sigma_nm_per_rad: change.after_sigma_nm_per_rad,
        })
    }
}
