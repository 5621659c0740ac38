//! Fingers for the unit tests of those that are held.

use super::{Drive, Finger, Opened};

/// A drive without a cable that tells the torque.
pub const RIGID: Drive = Drive {
    factor: 1.0,
    cable_rad_per_nm: 0.0,
    stiffening_per_nm: 0.0,
};

/// A finger that stands where its springs rest.
pub fn opened(finger: Finger) -> Opened {
    Opened {
        back: None,
        weight: None,
        stand_rad: finger.rest_rad.clone(),
        stopped: false,
        most_rad: vec![3.0; finger.lengths.len()],
        finger,
    }
}
