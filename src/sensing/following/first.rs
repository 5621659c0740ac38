//! The first contact of a closing, as the sensor's last word has it and as what followed allows.

use super::closing::Closing;
use crate::finger::{Contact, Mechanics, Weighs};
use crate::joint_sensor::JointSensor;
use crate::sensing::Sensor;
use crate::sensing::location::SeriesElement;
use crate::sensing::second::SlopeChange;
use crate::sensing::sensor::NEAR_SIGMAS;

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
    /// A place. One near joint 2 is to be decided, whether it was told or not, unless it is so vague that the joint is always within its
    /// deviation.
    pub(super) fn of(contact: Contact, sigma_m: f32, is_vague: bool) -> Self {
        if !is_vague && contact.phalanx == 2 && contact.k_m < NEAR_SIGMAS * sigma_m {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_joint_2_a_place_is_to_be_decided_whether_it_was_told_or_not() {
        let place = |phalanx, k_m| Contact {
            phalanx,
            k_m,
            radius_m: 0.01,
        };
        let of = |contact, is_vague| First::of(contact, 2e-3, is_vague);
        assert!(matches!(of(place(2, 3.9e-3), false), First::Near(..)));
        assert!(matches!(of(place(2, 4.1e-3), false), First::At(..)));
        assert!(matches!(of(place(3, 4e-3), false), First::At(..)));
        // So wide that the joint is within it wherever it is.
        assert!(matches!(of(place(2, 4e-3), true), First::At(..)));
    }
}
