//! The first contact of a closing, as the sensor's last word has it and as what followed allows.

use super::closing::Closing;
use crate::finger::{Contact, Mechanics, Weighs};
use crate::joint_sensor::JointSensor;
use crate::sensing::Sensor;
use crate::sensing::location::SeriesElement;
use crate::sensing::second::SlopeChange;

/// Within so many deviations a place on phalanx 2 may be its joint.
const AT_JOINT_SIGMAS: f32 = 2.5;
/// A contact that would have let the input link turn this much farther than it has, as a factor, is none on phalanx 1 (chosen): friction
/// takes up to a third of the torque.
const FARTHER: f32 = 1.5;

/// The first contact.
#[derive(Clone, Copy, Debug)]
pub(super) enum First {
    /// The last word is still to come.
    Awaited,
    /// A contact without a place.
    Unplaced,
    /// Where, and the deviation.
    At(Contact, f32),
    /// As well, but near joint 2: to be decided.
    Near(Contact, f32),
}

/// A contact somewhere on phalanx 1: joint 1 stands wherever it is.
pub(super) fn proximal<F: Mechanics, H: JointSensor, X: SeriesElement>(
    sensor: &Sensor<F, H, X>,
) -> Contact {
    let length_m = sensor.finger().phalanx_length_m(1).unwrap_or(f32::NAN);
    Contact {
        phalanx: 1,
        k_m: 0.5 * length_m,
        radius_m: 0.0,
    }
}

impl First {
    /// A place; near joint 2 one that the sensor told may be another.
    pub(super) fn of(contact: Contact, sigma_m: f32, is_told: bool) -> Self {
        if is_told && contact.phalanx == 2 && contact.k_m < AT_JOINT_SIGMAS * sigma_m {
            Self::Near(contact, sigma_m)
        } else {
            Self::At(contact, sigma_m)
        }
    }
}

impl<C: Copy, W: Weighs<C>> Closing<C, W> {
    /// Decides whether a place near joint 2 is one on phalanx 1: that would have let the input link turn farther until the change of slope.
    ///
    /// A place on the very joint is as soft as one anywhere on phalanx 1. Farther out the finger is stiffer the more it closes.
    pub(super) fn decide<F, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        change: &SlopeChange,
        (near, sigma_m): (Contact, f32),
    ) -> First
    where
        F: Mechanics<Configuration = C>,
    {
        let inner = First::At(proximal(sensor), 0.0);
        let rotations = || {
            let (free, _, measured) = self.measured(sensor, change, inner).asked?;
            let (at, torque_nm) = (&free.configuration, free.torque_nm);
            let compliance = sensor.finger().proximal_compliance(at, torque_nm)?;
            Some([compliance * measured.rise_nm, measured.rotation_rad])
        };
        match rotations() {
            Some([expected, turned]) if expected < FARTHER * turned => inner,
            _ => First::At(near, sigma_m),
        }
    }
}
