//! Where a contact has come to on its phalanx as the finger closed on (docs/SECOND_CONTACTS.md#where-it-has-come-to).
//!
//! On an object that stands still the place follows from how far the input link has turned, whatever the friction in the contact:
//! the phalanx stays on the object. The path after contact is followed to that angle; the torque decides only where the path hardly
//! turns any more.

use super::Followed;
use crate::finger::{Contact, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, exp, ln, sqrt};
use crate::sensing::Sensor;
use crate::sensing::location::SeriesElement;

/// Pieces of the torque in which a path is followed, how many at most, and steps of a piece.
const PIECES: u8 = 8;
const MOST_PIECES: u8 = 16;
const STEPS: u8 = 8;
/// Standard deviation of the logarithm of the share of the torque that acts along the path (chosen): friction in the contact takes
/// some of it, or adds to it.
const TAKEN_SIGMA: f32 = 1.0;
/// With less likelihood than this, summed along the path, metre, the path misses the measurement by some eight deviations.
const NOWHERE_M: f32 = 1e-16;

/// The first contact, where it was felt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) contact: Contact,
    pub(super) sigma_m: f32,
    pub(super) radius_sigma_m: f32,
}

/// What the finger did since the contact began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned {
    /// Angle of the input link at the onset, radian.
    pub(super) onset_rad: f32,
    /// How far the input link has turned, the cable's twist taken off, and the deviation, radian.
    pub(super) rotation_rad: f32,
    pub(super) sigma_rad: f32,
    /// Torque at the input link now, newton metre, and as above friction.
    pub(super) torque_nm: f32,
    pub(super) excess_nm: f32,
}

/// A place being worked out: one path a sample.
#[derive(Clone, Debug)]
pub(super) struct Rolled {
    placed: Placed,
    turned: Turned,
    /// The place and its deviation by rotation and torque, metre.
    now: Option<[f32; 2]>,
    /// By how much the place changes with one deviation of the first place, metre.
    by_place_m: Option<f32>,
}

impl Rolled {
    /// `nominal_m` is the contact radius where none is known.
    pub(super) fn new(mut placed: Placed, nominal_m: f32, turned: Turned) -> Self {
        if !placed.contact.radius_m.is_finite() {
            placed.contact.radius_m = nominal_m;
            placed.radius_sigma_m = nominal_m;
        }
        Self {
            placed,
            turned,
            now: None,
            by_place_m: None,
        }
    }

    /// A piece of the work; what there is to say once it is done, nothing where the path leads off the phalanx.
    pub(super) fn step<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
    ) -> Option<Option<Followed>> {
        let Placed {
            contact,
            sigma_m,
            radius_sigma_m,
        } = self.placed;
        let Some([k_m, along_m]) = self.now else {
            self.now = self.turned.place(sensor, contact);
            return if self.now.is_none() { Some(None) } else { None };
        };
        // One deviation beside; where no path leads there, as if nothing rolled.
        let beside = |other: Contact, sigma_m: f32| {
            let there = self.turned.place(sensor, other);
            there.map_or(sigma_m, |[there_m, _]| there_m - k_m)
        };
        let Some(by_place_m) = self.by_place_m else {
            let nearer = Contact {
                k_m: contact.k_m - sigma_m,
                ..contact
            };
            self.by_place_m = Some(beside(nearer, sigma_m));
            return None;
        };
        let wider = Contact {
            radius_m: contact.radius_m + radius_sigma_m,
            ..contact
        };
        let by_radius_m = beside(wider, radius_sigma_m);
        let variance = by_place_m * by_place_m + by_radius_m * by_radius_m + along_m * along_m;
        Some(Some(Followed::Moved {
            phalanx: contact.phalanx,
            k_m,
            sigma_m: sqrt(variance),
            torque_nm: self.turned.excess_nm,
        }))
    }
}

impl Turned {
    /// The place of a contact now and its deviation, metre: mean and deviation along the path, every place as likely as the angle and
    /// the torque there make it. Nothing where the path leads nowhere near.
    fn place<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        contact: Contact,
    ) -> Option<[f32; 2]> {
        let finger = sensor.finger();
        let free = sensor.free_at(self.onset_rad)?;
        let mut path = finger.path(&free.configuration, free.torque_nm, contact)?;
        // Share of the torque, rotation, and place beyond the first.
        let mut from = [0.0; 3];
        let [mut weight, mut first, mut second] = [0.0; 3];
        for piece in 1..=MOST_PIECES {
            let share = f32::from(piece) / f32::from(PIECES);
            let Some(point) = finger.follow(&mut path, self.torque_nm * share) else {
                break;
            };
            let to = [share, point.rotation_rad, point.k_now_m - contact.k_m];
            for step in 0..STEPS {
                let way = (f32::from(step) + 0.5) / f32::from(STEPS);
                let [share, rotation_rad, rolled_m]: [f32; 3] =
                    core::array::from_fn(|i| from[i] + way * (to[i] - from[i]));
                let turned = (rotation_rad - self.rotation_rad) / self.sigma_rad;
                let taken = ln(share) / TAKEN_SIGMA;
                let likely =
                    exp(-0.5 * (turned * turned + taken * taken)) * (to[2] - from[2]).abs();
                weight += likely;
                first += likely * rolled_m;
                second += likely * rolled_m * rolled_m;
            }
            from = to;
        }
        let (mean_m, square_m2) = (first / weight, second / weight);
        let sigma_m = sqrt((square_m2 - mean_m * mean_m).at_least(0.0));
        (weight > NOWHERE_M).then_some([contact.k_m + mean_m, sigma_m])
    }
}
