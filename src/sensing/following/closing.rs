//! A closing in contact: what its blocks show, and what a change of slope in it means.

use super::first::First;
use super::{Followed, Grip};
use crate::finger::{
    Contact, Free, HoldsTwice, Mechanics, NoSecondContact, SecondMeasured, SecondWeights,
    TwoContacts, Weighs,
};
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, not_negative, sqrt};
use crate::sensing::Sensor;
use crate::sensing::calibration::MIDDLE_NM;
use crate::sensing::location::SeriesElement;
use crate::sensing::second::{BlockNoise, DOUBTFUL, Later, SecondContact, SlopeChange};
use crate::sensing::sensor::FADED_SHARE;

/// Standard deviation of the angle at which the first contact began, radian (chosen): without a place it is that of the detector.
const ONSET_SIGMA_RAD: f32 = 0.03;

/// Deviation of a corner's angle, in turns of the motor at least, and in spacings of the points in which it was found (chosen).
const CORNER_SHARE: f32 = 0.7;
const SPACING_SHARE: f32 = 0.35;

/// A closing in contact.
#[derive(Clone, Debug)]
pub(super) struct Closing<C, W> {
    /// Angle of the input link at the onset, radian.
    pub(super) onset_rad: f32,
    /// What the record's level was off by at the onset, newton metre at the input link.
    pub(super) level_nm: f32,
    /// Time of the last block, its torque above friction, and what the springs of the free finger take there. After a break the first is
    /// that of two blocks before, where the springs took nearly the same.
    pub(super) last_us: u64,
    pub(super) excess_nm: f32,
    pub(super) free_nm: f32,
    /// Torque above friction at the blocks before it, the last first.
    before: [f32; DOUBTFUL],
    /// Encoder position in the middle of it, or of the last one before the motion broke off.
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
    /// Where it began: measured angle, radian, torque, newton metre, and the cable's compliance there, radian per newton metre.
    pub(super) corner: [f32; 3],
    /// Where the second contact may be.
    pub(super) weighing: W,
}

/// What was measured of a second contact.
pub(super) struct Measured<C> {
    change: SlopeChange,
    /// Compliance of the cable at that torque, radian per newton metre, and its deviation.
    cable: [f32; 2],
    /// Torque of the free finger at the corner, newton metre.
    free_nm: f32,
    /// What the finger is asked: whether a joint stands at its stop, and where the first contact is known about the second.
    pub(super) asked: Option<(Free<C>, Contact, SecondMeasured)>,
}

impl<C: Copy, W: Weighs<C>> Closing<C, W> {
    /// A contact that is felt now, with this torque above friction.
    pub(super) fn new(onset_rad: f32, level_nm: f32, excess_nm: f32) -> Self {
        Self {
            onset_rad,
            level_nm,
            last_us: 0,
            excess_nm,
            free_nm: 0.0,
            before: [excess_nm; DOUBTFUL],
            counts: 0,
            top_nm: excess_nm,
            fallen: 0,
            change: None,
            since: 0,
            later: None,
            is_over: false,
            first: First::Awaited,
            grip: Grip::Single,
            held: None,
            corner: [0.0; 3],
            weighing: W::default(),
        }
    }

    /// Takes the torque of a block: above friction, and what the free finger takes there.
    pub(super) fn take(&mut self, excess_nm: f32, free_nm: f32) {
        let [last, _] = self.before;
        self.before = [self.excess_nm, last];
        (self.excess_nm, self.free_nm) = (excess_nm, free_nm);
    }

    /// Restores the torque from before a break in the motion: that of the last blocks may be the drive's.
    pub(super) fn interrupt(&mut self) {
        if self.grip != Grip::Lost {
            [.., self.excess_nm] = self.before;
        }
    }

    /// Whether the contact has let go: the finger slid off, or the object gave way. Takes a block's torque above friction.
    pub(super) fn is_lost(&mut self, excess_nm: f32, noise_nm: f32) -> bool {
        self.top_nm = self.top_nm.at_least(excess_nm);
        let has_fallen = self.top_nm - excess_nm > FADED_SHARE * self.top_nm + noise_nm;
        self.fallen = if has_fallen {
            self.fallen.saturating_add(1)
        } else {
            0
        };
        self.fallen > 1
    }

    /// No more is to come: what the blocks show counts.
    pub(super) fn end(&mut self, search: &mut SecondContact) {
        self.is_over = true;
        if self.change.is_none() {
            self.change = search.finish();
            // What was measured belongs to the corner that waits in a straight line, not to this one.
            self.later = self.later.filter(|_| self.change.is_none());
        }
    }

    /// Takes what the blocks after a change of slope show, of which there is one more.
    pub(super) fn measure<F: HoldsTwice>(&mut self, search: &SecondContact, noise: &BlockNoise) {
        let waiting = search.straight().filter(|_| F::STRAIGHT);
        if let Some(change) = self.change.as_ref().or(waiting) {
            self.since = self.since.saturating_add(u8::from(self.change.is_some()));
            // What was measured of an earlier change does not count.
            let before = (self.later).filter(|later| later.theta_a_rad > change.theta_a_rad);
            self.later = search.later(change, noise).or(before);
        }
    }

    /// What was measured of a second contact at a change of slope: that with what is known of the slope after it, the cable that
    /// is part of it, and the first contact with what the finger is asked.
    pub(super) fn measured<F, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        change: &SlopeChange,
        first: First,
    ) -> Measured<C>
    where
        F: Mechanics<Configuration = C>,
    {
        let calibration = sensor.calibration();
        let factor = calibration.torque_factor;
        let free = sensor.free_at(change.theta_a_rad);
        let free_nm = free.map_or(0.0, |free| free.torque_nm);
        let later = self.later.unwrap_or(Later {
            theta_a_rad: change.theta_a_rad,
            torque_nm: change.torque_nm,
            slope_nm_per_rad: change.after_nm_per_rad,
            sigma_nm_per_rad: change.after_sigma_nm_per_rad,
        });
        let (cable, cable_sigma) = if X::FLEXIBLE {
            // Kept for a nominal torque, and for the middle of a probing.
            let beyond_nm = later.torque_nm / factor - MIDDLE_NM;
            // From the middle of a probing to its end that is much of its twist. A cable stiffens and does not soften: where no mean is
            // stated, and no press has told one, it is that of what cannot be negative.
            let mut told = [
                calibration.stiffening_per_nm,
                calibration.stiffening_sigma_per_nm,
            ];
            if told[0] <= 0.0 {
                told = not_negative(told);
            }
            let [stiffening, unsure] = told;
            let share = 1.0 - stiffening * beyond_nm;
            let cable = calibration.cable_rad_per_nm * share.at_least(0.0) / factor;
            let bend = unsure * beyond_nm * cable;
            let sigma = calibration.cable_sigma_rad_per_nm / factor;
            (cable, sqrt(sigma * sigma + bend * bend))
        } else {
            (0.0, 0.0)
        };
        // What is not known of the torque is not known of the slope.
        let slope_sigma = calibration.torque_factor_sigma * later.slope_nm_per_rad;
        let own_sigma = later.sigma_nm_per_rad;
        let change = SlopeChange {
            after_nm_per_rad: later.slope_nm_per_rad,
            after_sigma_nm_per_rad: sqrt(own_sigma * own_sigma + slope_sigma * slope_sigma),
            ..*change
        };
        let (compliance_rad_per_nm, compliance_sigma_rad_per_nm) =
            change.compliance(cable, cable_sigma);
        let later_nm = later.torque_nm - change.torque_nm;
        let turned_rad = later.theta_a_rad - change.theta_a_rad - cable * later_nm;
        // The corner lies within a block, and the cable's twist is taken off.
        let turn_rad =
            (sensor.drivetrain()).rotation_rad(0, sensor.drivetrain().counts_per_turn as i32);
        let block_rad = (SPACING_SHARE * change.spacing_rad).at_least(CORNER_SHARE * turn_rad);
        let twist_rad = cable_sigma * later_nm;
        let turned_sigma_rad = sqrt(block_rad * block_rad + twist_rad * twist_rad);
        let first = match first {
            First::At(contact, sigma_m) => Some((contact, sigma_m)),
            // The last joint turns by much the same wherever the contact is.
            First::Unplaced if F::MOVES_ON => sensor.finger().phalanx_length_m(2).map(|length_m| {
                let contact = Contact {
                    phalanx: 2,
                    k_m: 0.5 * length_m,
                    radius_m: sensor.settings().pin_contact_radius_m(),
                };
                (contact, 0.0)
            }),
            First::Awaited | First::Near(..) | First::Unplaced => None,
        };
        let asked = first.and_then(|(contact, first_sigma_m)| {
            sensor.free_at(self.onset_rad).map(|free| {
                let settings = sensor.settings();
                let rise_nm = (change.torque_nm - free.torque_nm).at_least(0.0);
                let [twist_rad, twist_sigma_rad] = if X::FLEXIBLE {
                    calibration.twist_rad(rise_nm / factor, change.torque_nm / factor)
                } else {
                    [0.0; 2]
                };
                let rotation_sigma_rad =
                    sqrt(ONSET_SIGMA_RAD * ONSET_SIGMA_RAD + twist_sigma_rad * twist_sigma_rad);
                let measured = SecondMeasured {
                    rise_nm,
                    rotation_rad: change.theta_a_rad - self.onset_rad - twist_rad,
                    rotation_sigma_rad,
                    torque_nm: change.torque_nm,
                    later_nm: later_nm.at_least(0.0),
                    turned_rad: turned_rad.at_least(0.0),
                    turned_sigma_rad,
                    compliance_rad_per_nm,
                    compliance_sigma_rad_per_nm,
                    first_sigma_m,
                    friction: settings.contact_friction,
                    half_thickness_m: settings.half_thickness_m,
                    leverage_sigma: settings.leverage_sigma,
                    joint_friction_nm: not_negative(settings.joint_friction_nm),
                    joint_loss: F::JOINT_LOSS,
                };
                (free, contact, measured)
            })
        });
        Measured {
            change,
            cable: [cable, cable_sigma],
            free_nm,
            asked,
        }
    }

    /// Takes a step of finding the phalanx and the place of a second contact; false where that is done.
    pub(super) fn weigh<F, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        change: &SlopeChange,
    ) -> bool
    where
        F: HoldsTwice + Mechanics<Configuration = C>,
    {
        if !matches!(self.first, First::At(..)) {
            return false;
        }
        let Some(kept) = self.weighing.kept() else {
            return false;
        };
        if let Some((free, first, measured)) = &kept.asked {
            let step = kept.step;
            kept.step += 1;
            return (sensor.finger()).weigh_second(free, *first, measured, step, &mut kept.weights);
        }
        // Once: it takes as long as weighing a few places does.
        let asked = self.measured(sensor, change, self.first).asked;
        let is_asked = asked.is_some();
        if let Some(kept) = self.weighing.kept() {
            kept.asked = asked;
        }
        is_asked
    }

    /// Whether a change of slope is a second contact, and what is known of it.
    // Not inlined: 90 bytes of flash less.
    #[inline(never)]
    pub(super) fn second_contact<F, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        change: &SlopeChange,
    ) -> Option<Followed>
    where
        F: HoldsTwice + Mechanics<Configuration = C>,
    {
        // Leave the torque factor's deviation out: slope and cable are divided by the same factor, so it cancels in their comparison.
        let own_sigma = self.later.map_or(change.after_sigma_nm_per_rad, |later| {
            later.sigma_nm_per_rad
        });
        let Measured {
            change,
            cable: [cable, cable_sigma],
            free_nm,
            asked,
        } = self.measured(sensor, change, self.first);
        let is_rigid = change.is_rigid(cable, cable_sigma);
        // Two phalanges that both touch have nothing left to move.
        if !is_rigid && !F::MOVES_ON {
            return None;
        }
        let nothing = SecondWeights::default();
        let weights = (self.weighing.kept()).map_or(&nothing, |kept| &kept.weights);
        let found = asked.map(|(free, first, measured)| {
            (sensor.finger()).weighed_second(&free, first, &measured, weights)
        });
        let held = match found {
            Some(Err(NoSecondContact::AtStop)) => return None,
            found => found.and_then(Result::ok),
        };
        // Three have a motion left, unless the stiffness itself says that it is not.
        let own = SlopeChange {
            after_sigma_nm_per_rad: own_sigma,
            ..change
        };
        let is_enveloped = !F::MOVES_ON || own.is_rigid(cable, 0.0);
        // What has let go since is held no more.
        if self.grip != Grip::Lost {
            self.grip = if is_enveloped {
                Grip::Enveloped
            } else {
                Grip::TwoContacts
            };
            self.held = held;
            self.corner = [change.theta_a_rad, change.torque_nm, cable];
        }
        let (phalanx, k_m, sigma_m) = held.map_or((0, f32::NAN, f32::NAN), |held| {
            (held.phalanx, held.k_m, held.sigma_m)
        });
        Some(Followed::SecondContact {
            phalanx,
            k_m,
            sigma_m,
            theta_a_rad: change.theta_a_rad,
            torque_nm: (change.torque_nm - free_nm) / sensor.calibration().torque_factor,
            stiffness_nm_per_rad: change.after_nm_per_rad,
            stiffness_sigma_nm_per_rad: change.after_sigma_nm_per_rad,
        })
    }
}

#[cfg(test)]
mod tests;
