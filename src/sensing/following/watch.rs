//! Looks for what follows the first contact, block by block.

use core::fmt::Debug;

use super::closing::Closing;
use super::first::{First, proximal};
use super::level::{Above, Level};
use super::{AfterContact, Followed, Grip};
use crate::finger::{Contact, HeldForces, HoldsTwice, VAGUE};
use crate::joint_sensor::JointSensor;
use crate::numeric::Bounded;
use crate::sensing::block::{Block, BlockAverager, BlockUpdate};
use crate::sensing::location::SeriesElement;
use crate::sensing::locator::springs;
use crate::sensing::second::{BlockNoise, SecondContact};
use crate::sensing::sensor::LOST_SIGMAS;
use crate::sensing::{Directive, Drive, Event, NotLocated, Sample, Sensor};

/// Share of the torque limit from which on a change of slope is a second contact, and not the onset of the first (chosen): twice as far
/// as friction wanders.
const LEAST_SHARE: f32 = 0.03;
/// Blocks after a second contact over which a finger of more than two phalanges is watched: at first it may stick.
const MEASURED: u8 = 20;
/// A way between two blocks of more than this many of their widths is a break in the motion.
const BREAK: f32 = 1.5;
/// Without a block of steady motion for so long the finger stands, microseconds.
const STANDS_US: u64 = 250_000;

/// Looks for a second contact of a finger that [holds twice](HoldsTwice), and tells how the object is held.
#[derive(Clone, Debug)]
pub struct Follow<F: HoldsTwice> {
    averager: BlockAverager,
    watches: bool,
    level: Level,
    search: SecondContact,
    /// Encoder position in the middle of the last block.
    counts: i32,
    closing: Option<Closing<F::Configuration, F::Weighing>>,
}

impl<F: HoldsTwice> Default for Follow<F> {
    fn default() -> Self {
        Self {
            averager: BlockAverager::default(),
            watches: false,
            level: Level::default(),
            search: SecondContact::default(),
            counts: 0,
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
            self.forget_search();
            self.closing = None;
        } else if let Some(closing) = &mut self.closing {
            // The last word is still to be said, as if it had stood for long; the sensor has ended the first contact's curve already.
            closing.last_us = 0;
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
        {
            if block.drive == Drive::Closing {
                self.on_block(sensor, &block);
            } else if self.closing.is_none() {
                // What was noted before is of a closing that has ended.
                self.forget_search();
            }
        }
        if let Some(event) = told {
            self.on_event(sensor, sample.time_us, event);
        }
        self.judge(sensor, sample.time_us)
    }
}

impl<F: HoldsTwice + Clone + Debug> Follow<F> {
    /// The search of the next closing begins anew.
    // Not inlined: called from two places.
    #[inline(never)]
    fn forget_search(&mut self) {
        self.search = SecondContact::default();
    }

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
        self.counts = block.counts;
        let angle_rad = sensor.drivetrain().closing_rad(block.counts);
        // Keep it where it is negative, because a weight closes the finger, although the motor does not show it then: cut off at zero it
        // puts a corner into the curve, and single contacts are told as two.
        let free_nm = sensor.free_at(angle_rad).map_or(0.0, |free| free.torque_nm);
        let factor = sensor.calibration().torque_factor;
        let Some(closing) = &mut self.closing else {
            self.search
                .note(angle_rad, factor * above.torque_nm + free_nm);
            return;
        };
        let way_counts = block.counts.wrapping_sub(closing.counts).unsigned_abs();
        let breaks = way_counts as f32 > BREAK * block.width_counts as f32;
        closing.last_us = block.time_us;
        let excess_nm = above.torque_nm - closing.level_nm;
        // From the end of the travel on the motor holds, with a current of its own that shows no torque of the finger.
        let way_rad = sensor.drivetrain().rotation_rad(0, block.counts);
        let mut is_at_end = way_rad >= sensor.settings().travel_rad;
        if breaks {
            // The drive has gone over to holding, and its blocks show no torque of the finger from here on. `counts` stays where it was
            // before the break, so that later blocks count as breaks too.
            closing.interrupt();
        } else {
            closing.counts = block.counts;
            if !is_at_end {
                closing.take(excess_nm, free_nm);
            }
        }
        is_at_end |= sensor.is_at_stop(angle_rad, closing.excess_nm);
        let is_lost = !is_at_end && closing.is_lost(excess_nm, LOST_SIGMAS * above.sigma_nm);
        if is_lost
            && excess_nm < LEAST_SHARE * sensor.settings().torque_limit_nm
            && (breaks || closing.is_over || closing.change.is_some())
        {
            // The contact has let go: a motor that turns with nothing to carry is not holding. A second contact found before is still told.
            closing.grip = Grip::Lost;
            closing.excess_nm = excess_nm;
        }
        if closing.is_over {
            return;
        }
        if breaks {
            self.search.interrupt();
            closing.end(&mut self.search);
            conclude(sensor, closing, angle_rad, block.counts);
            return;
        }
        let was_found = closing.change.is_some();
        if !is_at_end {
            let sigma_nm = factor * above.sigma_nm;
            let noise = BlockNoise {
                white_nm2: sigma_nm * sigma_nm,
                walk_nm2: factor * factor * sensor.walk_nm2(block),
                worm_turn_rad: sensor.worm_turn_rad(),
                worm_error_rad: sensor.settings().worm_error_rad,
            };
            let torque_nm = factor * excess_nm + free_nm;
            let found = (self.search).push(angle_rad, torque_nm, &noise, F::MOVES_ON);
            closing.change = closing.change.or(found);
            if F::STRAIGHT {
                self.search.look_straight(&noise);
            }
            if F::MOVES_ON {
                closing.measure::<F>(&self.search, &noise);
            }
        }
        if is_lost && !was_found {
            closing.grip = Grip::Lost;
            closing.is_over = true;
            // Nor is a second contact told that the very block has shown.
            closing.change = None;
            sensor.conclude();
            return;
        }
        let is_measured = closing.change.is_some() && (!F::MOVES_ON || closing.since >= MEASURED);
        let has_enough = closing.excess_nm >= sensor.settings().enough_nm();
        if is_at_end || is_measured || has_enough || is_lost {
            closing.end(&mut self.search);
        }
        if closing.is_over || closing.change.is_some() && !was_found {
            conclude(sensor, closing, angle_rad, block.counts);
        }
    }

    /// What the sensor tells of the first contact.
    fn on_event<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        now_us: u64,
        event: &Event,
    ) {
        let first = match *event {
            Event::Touch {
                theta_a_rad,
                torque_nm,
                ..
            } if self.watches => {
                let mut closing =
                    Closing::new(theta_a_rad, self.level.at_touch(torque_nm), torque_nm);
                closing.last_us = now_us;
                closing.counts = self.counts;
                let onset_nm = (sensor.free_at(theta_a_rad)).map_or(0.0, |free| free.torque_nm);
                // A finger that its weight closes shows no torque until the contact has taken that over, and then as abruptly as at a
                // corner.
                let least_nm = LEAST_SHARE * sensor.settings().torque_limit_nm;
                let level_nm = sensor.calibration().torque_factor * closing.level_nm;
                (self.search).begin(theta_a_rad, level_nm, onset_nm.at_least(0.0) + least_nm);
                self.closing = Some(closing);
                return;
            }
            Event::Located {
                phalanx,
                k_m,
                sigma_m,
                radius_m,
                settled: true,
                ..
            } => {
                if let Some(closing) = &mut self.closing {
                    closing.onset_rad = sensor.onset_rad();
                }
                let contact = Contact {
                    phalanx,
                    k_m,
                    radius_m,
                };
                Some((contact, sigma_m))
            }
            Event::NotLocated {
                why: NotLocated::Proximal,
                ..
            } => Some((proximal(sensor), 0.0)),
            // A phalanx at least.
            Event::NotLocated {
                why: NotLocated::Unobservable,
                ..
            } => sensor.vague_place(),
            Event::Ambiguous { settled: true, .. } | Event::NotLocated { .. } => None,
            _ => return,
        };
        if let Some(closing) = &mut self.closing {
            closing.first = first.map_or(First::Unplaced, |(mut contact, sigma_m)| {
                if !contact.radius_m.is_finite() {
                    contact.radius_m = sensor.settings().pin_contact_radius_m();
                }
                let length_m = sensor.finger().phalanx_length_m(contact.phalanx);
                let is_vague = length_m.is_none_or(|length_m| sigma_m >= VAGUE * length_m);
                First::of(contact, sigma_m, is_vague)
            });
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
                let angle_rad = sensor.drivetrain().closing_rad(closing.counts);
                conclude(sensor, closing, angle_rad, closing.counts);
            }
            return None;
        }
        if matches!(closing.first, First::Awaited) {
            return None;
        }
        if let Some(change) = closing.change
            && let First::Near(contact, sigma_m) = closing.first
        {
            closing.first = closing.decide(sensor, &change, (contact, sigma_m));
            return None;
        }
        // Not of a contact that was lost.
        if F::STRAIGHT
            && closing.change.is_none()
            && closing.grip == Grip::Single
            && let First::At(Contact { phalanx: 1, .. }, _) = closing.first
        {
            closing.change = self.search.take_straight();
        }
        // A step a sample.
        if F::MOVES_ON
            && let Some(change) = closing.change
            && closing.weigh(sensor, &change)
        {
            return None;
        }
        if let Some(change) = closing.change.take()
            && let Some(second) = closing.second_contact(sensor, &change)
        {
            return Some(second);
        }
        let forces = (closing.held.as_ref()).map_or(HeldForces::UNKNOWN, |held| {
            let factor = sensor.calibration().torque_factor;
            let torque_nm = factor * closing.excess_nm + closing.free_nm;
            let [corner_rad, corner_nm, cable_rad_per_nm] = closing.corner;
            let twist_rad = cable_rad_per_nm * (torque_nm - corner_nm);
            let turned_rad = sensor.drivetrain().closing_rad(closing.counts) - corner_rad;
            let way_rad = (turned_rad - twist_rad).at_least(0.0);
            sensor.finger().held_forces(held, torque_nm, way_rad)
        });
        let [springs, _] = springs(sensor.calibration(), sensor.settings().force_scale);
        let over = Followed::Grasp {
            grip: closing.grip,
            torque_nm: closing.excess_nm,
            forces: forces.scaled(springs),
        };
        self.closing = None;
        Some(over)
    }
}

/// No more of the first contact is to be judged, and nothing after a change of slope.
fn conclude<F: HoldsTwice, H: JointSensor, X: SeriesElement>(
    sensor: &mut Sensor<F, H, X>,
    closing: &Closing<F::Configuration, F::Weighing>,
    angle_rad: f32,
    counts: i32,
) {
    match closing.change {
        Some(change) => {
            let back_rad = angle_rad - change.theta_a_rad;
            let back_counts = (back_rad / sensor.drivetrain().rad_per_count) as i32;
            sensor.conclude_before(counts.wrapping_sub(back_counts));
        }
        None => sensor.conclude(),
    }
}
