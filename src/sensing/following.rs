//! What follows the first contact of a closing: a second one, how the object is held at its end, what becomes of it then.
//!
//! Chosen by type: [`FirstContactOnly`] carries nothing, [`Follow`] listens beside the [`Sensor`], and [`Changes`] wraps either
//! to watch what becomes of a contact. Both cut blocks of their own from the sensor's samples and take its friction record off;
//! [`Follow`] searches them for a change of slope. A second contact is told after the sensor's last word on the first, because
//! its phalanx and the posture follow from that.

mod changes;
mod closing;
mod fade;
mod first;
mod jump;
mod level;
mod rolled;
mod stand;
mod turn;
mod watch;
mod watched;

pub use changes::Changes;
pub use watch::Follow;

use core::fmt::Debug;

use crate::finger::{HeldForces, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::sensing::location::SeriesElement;
use crate::sensing::{Directive, Event, Sample, Sensor};

/// How an object is held at the end of a closing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// A contact was felt and let go again: nothing is held.
    Lost,
    /// One contact was felt.
    Single,
    /// Two, and the finger still gives way between them.
    TwoContacts,
    /// Two, and nothing but the cable gives way: the object is held between the phalanges, or against the palm.
    Enveloped,
}

/// What becomes of a contact that was felt (docs/SECOND_CONTACTS.md#held-contacts).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The object gave way, or the phalanx slid on it: some of the torque is gone, and some is left. The place is not known
    /// any more.
    Slipped,
    /// Nothing presses any more.
    Lost,
    /// The torque rose faster than the cable alone can make it: something pushed the object, or the finger.
    Pushed,
}

/// An event after the first contact. Lengths in metre, torques at the input link in newton metre, NaN where not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Followed {
    /// A second contact.
    SecondContact {
        /// Phalanx of it; 0 where the first contact does not tell.
        phalanx: u8,
        /// Place from the phalanx's joint, on three phalanges.
        k_m: f32,
        /// Standard deviation of `k_m`.
        sigma_m: f32,
        /// Angle of the input link then, radian, the cable's twist included.
        theta_a_rad: f32,
        /// Torque above friction then.
        torque_nm: f32,
        /// Stiffness of finger and cable afterwards, newton metre per radian.
        stiffness_nm_per_rad: f32,
        /// Its standard deviation.
        stiffness_sigma_nm_per_rad: f32,
    },
    /// The closing is over: how the object is held. The last word on a grasp.
    Grasp {
        /// How.
        grip: Grip,
        /// Torque above friction at the end.
        torque_nm: f32,
        /// What statics determines of two contacts at that torque.
        forces: HeldForces,
    },
    /// Where the first contact has come to as the finger closed on: it slides and rolls on an object that stands still.
    Moved {
        /// Phalanx of it.
        phalanx: u8,
        /// Place from the phalanx's joint now.
        k_m: f32,
        /// Standard deviation of `k_m`.
        sigma_m: f32,
        /// Torque above friction now.
        torque_nm: f32,
    },
    /// The contact changed at once.
    Changed {
        /// How.
        change: Change,
        /// Torque above friction before; not known while the finger stands.
        from_nm: f32,
        /// And after.
        to_nm: f32,
    },
}

/// What comes after the first contact: [`FirstContactOnly`], [`Follow`], or [`Changes`] around one of them.
pub trait AfterContact<F: Mechanics>: Clone + Debug + Default {
    /// Whether anything does: the closing then goes on after the first contact is judged.
    const FOLLOWS: bool;

    /// What the samples from now on are good for; call after the sensor's own.
    fn direct(&mut self, directive: Directive);

    /// Takes a sample that the sensor has taken, and what that told; returns at most one event.
    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &mut Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
        told: Option<&Event>,
    ) -> Option<Followed>;
}

/// Nothing: what the sensor says of the first contact is the last word. No size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirstContactOnly;

impl<F: Mechanics> AfterContact<F> for FirstContactOnly {
    const FOLLOWS: bool = false;

    fn direct(&mut self, _: Directive) {}

    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        _: &mut Sensor<F, H, X>,
        _: &Sample<H::Reading>,
        _: Option<&Event>,
    ) -> Option<Followed> {
        None
    }
}
