//! The first contact of a closing, as the sensor's last word has it and as what followed allows.

use super::closing::Closing;
use crate::finger::{Contact, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::sensing::Sensor;
use crate::sensing::location::SeriesElement;

/// Within so many deviations a place on phalanx 2 may be its joint.
const AT_JOINT_SIGMAS: f32 = 2.5;
/// A contact that would have let the input link turn by this factor farther than it has is none on phalanx 1 (chosen): what friction takes
/// of the torque makes it half as much.
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

impl<C: Copy> Closing<C> {
    /// Takes the last word on the first contact: its place, if it has one, with the deviation.
    pub(super) fn take_first<F, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        first: Option<(Contact, f32)>,
    ) where
        F: Mechanics<Configuration = C>,
    {
        self.first = match first {
            None => First::Unplaced,
            Some((mut contact, mut sigma_m)) => {
                if !contact.radius_m.is_finite() {
                    contact.radius_m = sensor.settings().pin_contact_radius_m();
                }
                let is_near = contact.phalanx == 2 && contact.k_m < AT_JOINT_SIGMAS * sigma_m;
                let inner = proximal(sensor);
                if is_near && self.may_be_first(sensor, inner) {
                    (contact, sigma_m) = (inner, 0.0);
                }
                First::At(contact, sigma_m)
            }
        };
    }

    /// Whether a first contact on phalanx 1 would have let the input link turn no farther than it has until the change of slope.
    ///
    /// A place on the joint of phalanx 2 is as soft as one anywhere on phalanx 1, and a place near it may be either. Farther out the
    /// finger is stiffer the more it closes.
    fn may_be_first<F, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        proximal: Contact,
    ) -> bool
    where
        F: Mechanics<Configuration = C>,
    {
        let turned = || {
            let (change, finger) = (self.change?, sensor.finger());
            let (free, contact, measured) =
                (self.measured(sensor, &change, First::At(proximal, 0.0))).asked?;
            let mut path = finger.path(&free.configuration, free.torque_nm, contact)?;
            let point = finger.follow(&mut path, measured.rise_nm)?;
            Some(point.rotation_rad < FARTHER * measured.rotation_rad)
        };
        turned() != Some(false)
    }
}
