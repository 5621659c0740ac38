//! Where a contact has come to on its phalanx as the finger closed on (docs/MECHANICS.md#held-contacts).
//!
//! On an object that stands still the place follows from how far the input link has turned, whatever the friction in the contact:
//! the phalanx stays on the object. The path after contact is followed to that angle, not to the torque.

use super::Followed;
use crate::finger::{Contact, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::Sensor;
use crate::sensing::location::SeriesElement;

/// Pieces of the torque in which a path is followed, and how many at most: friction in the contact takes a share of the torque, or
/// adds to it.
const PIECES: u8 = 8;
const MOST_PIECES: u8 = 16;

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
    /// The place, how it changes with the rotation, metre per radian, and its deviation by the first place.
    now: Option<(f32, f32)>,
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
        let Some((k_m, by_rotation)) = self.now else {
            self.now = self.turned.place(sensor, contact);
            return if self.now.is_none() { Some(None) } else { None };
        };
        // One deviation beside; where no path leads there, as if nothing rolled.
        let beside = |other: Contact, sigma_m: f32| {
            let there = self.turned.place(sensor, other);
            there.map_or(sigma_m, |(there_m, _)| there_m - k_m)
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
        let by_angle_m = by_rotation * self.turned.sigma_rad;
        let variance =
            by_place_m * by_place_m + by_radius_m * by_radius_m + by_angle_m * by_angle_m;
        Some(Some(Followed::Moved {
            phalanx: contact.phalanx,
            k_m,
            sigma_m: sqrt(variance),
            torque_nm: self.turned.excess_nm,
        }))
    }
}

impl Turned {
    /// The place of a contact now, metre, and how it changes with the rotation, metre per radian.
    fn place<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        contact: Contact,
    ) -> Option<(f32, f32)> {
        let finger = sensor.finger();
        let free = sensor.free_at(self.onset_rad)?;
        let mut path = finger.path(&free.configuration, free.torque_nm, contact)?;
        let (mut rotation_rad, mut k_m) = (0.0, contact.k_m);
        for piece in 1..=MOST_PIECES {
            let rise_nm = self.torque_nm * f32::from(piece) / f32::from(PIECES);
            let point = finger.follow(&mut path, rise_nm)?;
            let by_rotation = (point.k_now_m - k_m) / (point.rotation_rad - rotation_rad);
            if point.rotation_rad >= self.rotation_rad {
                let place_m = k_m + by_rotation * (self.rotation_rad - rotation_rad);
                return place_m.is_finite().then_some((place_m, by_rotation));
            }
            (rotation_rad, k_m) = (point.rotation_rad, point.k_now_m);
        }
        None
    }
}
