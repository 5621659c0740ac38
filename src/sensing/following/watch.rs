//! Looks for what follows the first contact, block by block.

use core::fmt::Debug;

use super::level::{Above, Level};
use super::{AfterContact, Followed, Grip};
use crate::finger::{
    Contact, HeldForces, HoldsTwice, Mechanics, NoSecondContact, SecondMeasured, TwoContacts,
};
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::block::{Block, BlockAverager, BlockUpdate};
use crate::sensing::location::SeriesElement;
use crate::sensing::second::{SecondContact, SlopeChange};
use crate::sensing::{Directive, Drive, Event, NotLocated, Sample, Sensor};

/// Share of the torque limit from which on a change of slope is a second contact, and not the onset of the first (chosen): twice as far
/// as friction wanders.
const LEAST_SHARE: f32 = 0.03;
/// A contact is lost when two blocks in a row lie below the largest torque so far by this share of it and so many deviations of a
/// block.
const LOST_SHARE: f32 = 0.1;
const LOST_SIGMAS: f32 = 8.0;
/// Within so many deviations a place on phalanx 2 may be its joint.
const AT_JOINT_SIGMAS: f32 = 2.5;
/// Without a block of steady motion for so long the finger stands, microseconds.
const STANDS_US: u64 = 250_000;

/// The first contact as the sensor's last word has it.
#[derive(Clone, Copy, Debug)]
enum First {
    /// The last word is still to come.
    Awaited,
    /// A contact without a place.
    Unplaced,
    /// Where, and the deviation.
    At(Contact, f32),
}

/// A closing in contact.
#[derive(Clone, Debug)]
struct Closing<C> {
    /// Angle of the input link at the onset, radian.
    onset_rad: f32,
    /// What the record's level was off by at the onset, newton metre at the input link.
    level_nm: f32,
    /// When the last block was, its torque above friction, and with what the springs of the free finger take.
    last_us: u64,
    excess_nm: f32,
    torque_nm: f32,
    /// The largest `excess_nm`, and blocks in a row far below it.
    top_nm: f32,
    fallen: u8,
    change: Option<SlopeChange>,
    /// Nothing more is looked for: the change of slope was found, or the finger stands.
    is_over: bool,
    first: First,
    grip: Grip,
    held: Option<TwoContacts<C>>,
}

/// Looks for a second contact of a finger that [holds twice](HoldsTwice), and tells how the object is held.
#[derive(Clone, Debug)]
pub struct Follow<F: Mechanics> {
    averager: BlockAverager,
    watches: bool,
    level: Level,
    search: SecondContact,
    closing: Option<Closing<F::Configuration>>,
}

impl<F: Mechanics> Default for Follow<F> {
    fn default() -> Self {
        Self {
            averager: BlockAverager::default(),
            watches: false,
            level: Level::default(),
            search: SecondContact::default(),
            closing: None,
        }
    }
}

impl<F: HoldsTwice + Clone + Debug> AfterContact<F> for Follow<F> {
    const FOLLOWS: bool = true;

    fn direct(&mut self, directive: Directive) {
        self.watches = matches!(directive, Directive::Watch);
        if self.watches {
            self.level = Level::default();
            self.search = SecondContact::default();
            self.closing = None;
        } else if let Some(closing) = &mut self.closing {
            // The last word is still to be said.
            closing.end(&mut self.search);
        }
    }

    #[inline(never)]
    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &mut Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
        told: Option<&Event>,
    ) -> Option<Followed> {
        let step = (self.averager).push(sample, sensor.drivetrain(), sensor.settings());
        if let BlockUpdate::Block(block) = step
            && self.watches
            && block.drive == Drive::Closing
        {
            self.on_block(sensor, &block);
        }
        if let Some(event) = told {
            self.on_event(sensor, sample.time_us, event);
        }
        self.judge(sensor, sample.time_us)
    }
}

impl<F: HoldsTwice + Clone + Debug> Follow<F> {
    /// A block of a closing.
    fn on_block<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &mut Sensor<F, H, X>,
        block: &Block,
    ) {
        let Some(above) = Above::of(sensor, block) else {
            return;
        };
        self.level.push(above.torque_nm);
        let angle_rad = sensor.drivetrain().closing_rad(block.counts);
        let free_nm = sensor.free_at(angle_rad).map_or(0.0, |free| free.torque_nm);
        let factor = sensor.calibration().torque_factor;
        let Some(closing) = &mut self.closing else {
            self.search
                .note(angle_rad, factor * above.torque_nm + free_nm);
            return;
        };
        closing.last_us = block.time_us;
        closing.excess_nm = above.torque_nm - closing.level_nm;
        closing.torque_nm = factor * closing.excess_nm + free_nm;
        if closing.is_over {
            return;
        }
        let settings = sensor.settings();
        let (limit_nm, enough_nm) = (settings.torque_limit_nm, settings.enough_nm());
        let onset_nm = sensor
            .free_at(closing.onset_rad)
            .map_or(0.0, |free| free.torque_nm);
        let least_nm = onset_nm + LEAST_SHARE * limit_nm;
        (self.search).begin(closing.onset_rad, factor * closing.level_nm, least_nm);
        // From the end of the travel on the motor holds, with a current of its own that shows no torque of the finger.
        let way_rad = sensor.drivetrain().rotation_rad(0, block.counts);
        let is_at_end = way_rad >= sensor.settings().travel_rad
            || sensor.is_at_stop(angle_rad, closing.excess_nm);
        if !is_at_end {
            let sigma_nm = factor * above.sigma_nm;
            closing.change = (self.search).push(angle_rad, closing.torque_nm, sigma_nm * sigma_nm);
        }
        let noise_nm = LOST_SIGMAS * above.sigma_nm;
        if !is_at_end && closing.is_lost(noise_nm) {
            closing.grip = Grip::Lost;
            closing.is_over = true;
            sensor.conclude();
            return;
        }
        if is_at_end || closing.change.is_some() || closing.excess_nm >= enough_nm {
            closing.end(&mut self.search);
            match closing.change {
                Some(change) => {
                    let back_rad = angle_rad - change.theta_a_rad;
                    let back_counts = (back_rad / sensor.drivetrain().rad_per_count) as i32;
                    sensor.conclude_before(block.counts.wrapping_sub(back_counts));
                }
                None => sensor.conclude(),
            }
        }
    }

    /// What the sensor tells of the first contact.
    fn on_event<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        now_us: u64,
        event: &Event,
    ) {
        let settings = sensor.settings();
        let first = match *event {
            Event::Touch {
                theta_a_rad,
                torque_nm,
                ..
            } if self.watches => {
                self.closing = Some(Closing {
                    onset_rad: theta_a_rad,
                    level_nm: self.level.at_touch(torque_nm),
                    last_us: now_us,
                    excess_nm: torque_nm,
                    torque_nm,
                    top_nm: torque_nm,
                    fallen: 0,
                    change: None,
                    is_over: false,
                    first: First::Awaited,
                    grip: Grip::Single,
                    held: None,
                });
                return;
            }
            // A place on the very joint is as soft as one anywhere on the phalanx before it.
            Event::Located {
                phalanx: 2,
                k_m,
                sigma_m,
                settled: true,
                ..
            } if k_m < AT_JOINT_SIGMAS * sigma_m => proximal(sensor),
            Event::Located {
                phalanx,
                k_m,
                sigma_m,
                radius_m,
                settled: true,
                ..
            } => {
                let nominal_m = settings.half_thickness_m + settings.pin_radius_m;
                let contact = Contact {
                    phalanx,
                    k_m,
                    radius_m: if radius_m.is_finite() {
                        radius_m
                    } else {
                        nominal_m
                    },
                };
                First::At(contact, sigma_m)
            }
            Event::NotLocated {
                why: NotLocated::Proximal,
                ..
            } => proximal(sensor),
            Event::Ambiguous { settled: true, .. } | Event::NotLocated { .. } => First::Unplaced,
            _ => return,
        };
        if let Some(closing) = &mut self.closing {
            closing.first = first;
        }
    }

    /// Says what is due.
    fn judge<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &mut Sensor<F, H, X>,
        now_us: u64,
    ) -> Option<Followed> {
        let closing = self.closing.as_mut()?;
        if !closing.is_over {
            if now_us.saturating_sub(closing.last_us) > STANDS_US {
                closing.end(&mut self.search);
                sensor.conclude();
            }
            return None;
        }
        if matches!(closing.first, First::Awaited) {
            return None;
        }
        if let Some(change) = closing.change.take()
            && let Some(second) = closing.second_contact(sensor, &change)
        {
            return Some(second);
        }
        let forces = (closing.held.as_ref()).map_or(HeldForces::UNKNOWN, |held| {
            sensor.finger().held_forces(held, closing.torque_nm)
        });
        let over = Followed::Grasp {
            grip: closing.grip,
            torque_nm: closing.excess_nm,
            forces,
        };
        self.closing = None;
        Some(over)
    }
}

/// A contact somewhere on phalanx 1: joint 1 stands wherever it is.
fn proximal<F: Mechanics, H: JointSensor, X: SeriesElement>(sensor: &Sensor<F, H, X>) -> First {
    let length_m = sensor.finger().phalanx_length_m(1).unwrap_or(f32::NAN);
    let contact = Contact {
        phalanx: 1,
        k_m: 0.5 * length_m,
        radius_m: 0.0,
    };
    First::At(contact, 0.0)
}

impl<C: Copy> Closing<C> {
    /// Whether the contact has let go: the finger slid off, or the object gave way.
    fn is_lost(&mut self, noise_nm: f32) -> bool {
        self.top_nm = self.top_nm.at_least(self.excess_nm);
        let has_fallen = self.top_nm - self.excess_nm > LOST_SHARE * self.top_nm + noise_nm;
        self.fallen = if has_fallen { self.fallen + 1 } else { 0 };
        self.fallen > 1
    }

    /// No more is to come: what the blocks show counts.
    fn end(&mut self, search: &mut SecondContact) {
        self.is_over = true;
        self.change = self.change.or_else(|| search.finish());
    }

    /// Whether a change of slope is a second contact, and what is known of it.
    fn second_contact<F, H: JointSensor, X: SeriesElement>(
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
