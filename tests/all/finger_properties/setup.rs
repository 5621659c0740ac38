//! What the properties start from.

use palpate::finger::{
    Configuration, Contact, Finger, Mechanics, Parameters, PathPoint, Transmission,
};
use proptest::prelude::*;

/// A finger of `N` phalanges, whatever its transmission.
pub trait AnyFinger<const N: usize>: Mechanics<Configuration = Configuration<N>> {
    fn parameters(&self) -> &Parameters<N>;
}

impl<const N: usize, T: Transmission<N>> AnyFinger<N> for Finger<N, T>
where
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    fn parameters(&self) -> &Parameters<N> {
        Finger::parameters(self)
    }
}

/// A contact posture: torque as a share of the softest spring; rejects where there is none, as without a spring at joint 1.
pub fn preshaped<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
) -> Result<(Configuration<N>, f32), TestCaseError> {
    let springs = finger.parameters().stiffness_nm_per_rad;
    let torque = share * springs.into_iter().fold(f32::INFINITY, f32::min);
    match finger.free_at_torque(torque, &finger.rest()) {
        Some(posture) => Ok((posture, torque)),
        None => Err(TestCaseError::reject("no posture")),
    }
}

/// A contact in a posture, with the path that it takes as the torque rises.
pub struct Pressed<const N: usize, P> {
    pub posture: Configuration<N>,
    pub torque_nm: f32,
    /// Length of the phalanx that is touched.
    pub length_m: f32,
    pub contact: Contact,
    pub path: P,
}

/// A contact whose place and radius are given as shares of the phalanx; rejects one that does not press.
pub fn pressed<const N: usize, F: AnyFinger<N>>(
    finger: &F,
    share: f32,
    contact: Contact,
) -> Result<Pressed<N, F::Path>, TestCaseError> {
    let (posture, torque_nm) = preshaped(finger, share)?;
    let length_m = finger
        .phalanx_length_m(contact.phalanx)
        .expect("it has that phalanx");
    let contact = Contact {
        k_m: contact.k_m * length_m,
        radius_m: contact.radius_m * length_m,
        ..contact
    };
    match finger.path(&posture, torque_nm, contact) {
        Some(path) => Ok(Pressed {
            posture,
            torque_nm,
            length_m,
            contact,
            path,
        }),
        None => Err(TestCaseError::reject("does not press there")),
    }
}

/// The same after a rise of the torque, a share of the last spring; rejects a contact that slides off. Returns the rise, newton
/// metre, and the point of the path.
pub fn risen<const N: usize, F: AnyFinger<N>>(
    finger: &F,
    share: f32,
    contact: Contact,
    rise_share: f32,
) -> Result<(Pressed<N, F::Path>, f32, PathPoint), TestCaseError> {
    let mut start = pressed(finger, share, contact)?;
    let rise_nm = rise_share * finger.parameters().stiffness_nm_per_rad[N - 1];
    match finger.follow(&mut start.path, rise_nm) {
        Some(point) => Ok((start, rise_nm, point)),
        None => Err(TestCaseError::reject("slides off")),
    }
}

/// Whether a contact at this place, with a point, presses.
pub fn presses<const N: usize>(
    finger: &impl AnyFinger<N>,
    posture: &Configuration<N>,
    torque_nm: f32,
    phalanx: u8,
    k_m: f32,
) -> bool {
    let contact = Contact {
        phalanx,
        k_m,
        radius_m: 0.0,
    };
    finger.path(posture, torque_nm, contact).is_some()
}
