//! A finger of two phalanges whose joint 2 is held at its stop while joint 1 closes: the torque at which a contact makes it leave that
//! stop, a measure of the contact's place beside the stiffness (docs/FINGERS.md#break-away).

use super::two_joint::lever;
use super::{BaseJoint, Configuration, Finger, Transmission};
use crate::numeric::bisect;

/// A contact on phalanx 2 while joint 2 stands at its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoppedContact {
    /// l_1 cos theta_2: what joint 1 has more of moment arm than joint 2, metre.
    pub c_m: f32,
    /// Transmission factor x_2.
    pub x2: f32,
    /// Torque that holds joint 2 at its stop without a contact, newton metre.
    pub held_nm: f32,
}

impl StoppedContact {
    fn lever(&self, k_m: f32) -> f32 {
        lever(self.x2, self.c_m, k_m)
    }

    /// Rise of the input torque since contact with which joint 2 leaves its stop, newton metre. Infinite from e_2 on, where no torque
    /// makes it leave.
    pub fn break_away_nm(&self, k_m: f32) -> f32 {
        let lever = self.lever(k_m);
        if lever > 0.0 {
            self.held_nm * ((self.c_m + k_m) / lever)
        } else {
            f32::INFINITY
        }
    }

    /// The place on a phalanx of length `length_m` where joint 2 leaves its stop after a rise of `rise_nm`, by bisection; `None` where
    /// there is none.
    ///
    /// The residual is linear in the place: nothing is divided by the lever, which vanishes at e_2.
    pub fn place_m(&self, rise_nm: f32, length_m: f32) -> Option<f32> {
        let valid = rise_nm > 0.0 && rise_nm < f32::MAX && self.held_nm > 0.0;
        let residual = |k_m| rise_nm * self.lever(k_m) - self.held_nm * (self.c_m + k_m);
        let place_m = bisect(0.0, length_m, residual);
        place_m.filter(|k_m| valid && *k_m > 0.0)
    }
}

impl<T: Transmission<2>, B: BaseJoint> Finger<2, T, B> {
    /// A contact on phalanx 2 in a posture of the free finger, which takes `torque_nm`; `None` where nothing holds joint 2 at its stop
    /// by design.
    ///
    /// ```
    /// use palpate::finger::{Finger, Parameters, ReturnCable};
    ///
    /// let parameters = Parameters {
    ///     lengths_m: [0.090, 0.070],
    ///     stiffness_nm_per_rad: [0.0, 0.0],
    ///     rest_rad: [0.0, 0.0],
    ///     range_rad: [[0.0, 2.5], [0.0, 2.0]],
    /// };
    /// let cable = ReturnCable { ratio: 0.7, torque_nm: 0.06, stiffness_nm_per_rad: 0.03 };
    /// let finger = Finger::returned(parameters, [0.010, 0.005], cable)?;
    /// let at = finger.configuration([0.5, 0.0])?;
    /// let contact = finger.stopped_contact(&at, 0.075).expect("held at its stop");
    /// let rise_nm = contact.break_away_nm(0.030);
    /// let k_m = contact.place_m(rise_nm, 0.070).expect("on the phalanx");
    /// assert!((k_m - 0.030).abs() < 1e-6);
    /// # Ok::<(), palpate::finger::ConfigError>(())
    /// ```
    pub fn stopped_contact(&self, at: &Configuration<2>, torque_nm: f32) -> Option<StoppedContact> {
        let [_, x2] = self.transmission.factors(at)?.x;
        let held_nm = match self.base.return_cable() {
            Some(cable) => (cable.ratio - x2) * torque_nm,
            None => self.base.preload_nm()?,
        };
        let ([l_1, _], [_, theta_2]) = (self.parameters.lengths_m, at.turn());
        let c_m = l_1 * theta_2.cos;
        Some(StoppedContact { c_m, x2, held_nm })
    }
}
