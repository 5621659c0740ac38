//! What is known before the fit.

use super::unknowns::{FLEXIBLE_UNKNOWNS, RIGID_UNKNOWNS};
use crate::sensing::Calibration;
use crate::sensing::location::{Cable, Series};
use core::marker::PhantomData;

/// Prior of the location.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Anywhere on the phalanx, uniformly.
    Anywhere,
    /// Known, with a standard deviation, metre.
    Known {
        /// Phalanx, from 2.
        phalanx: u8,
        /// Distance from the joint, metre.
        k_m: f32,
        /// Standard deviation, metre.
        sigma_m: f32,
    },
}

/// What is known before the fit, the same for every hypothesis. `X` is what lies in series with the finger: with
/// [`Rigid`](crate::sensing::location::Rigid) there is no cable to fit, and what is said of one here is not looked at.
#[derive(Clone, Copy, Debug)]
pub struct Prior<X: Series = Cable> {
    /// Location.
    pub place: Place,
    /// Effective contact radius: mean and deviation, metre.
    pub radius_m: (f32, f32),
    /// Deviation of the torque's offset, newton metre.
    pub offset_sigma_nm: f32,
    /// Onset angle theta_a: mean and deviation, radian.
    pub onset_rad: (f32, f32),
    /// Torque factor and cable.
    pub calibration: Calibration,
    /// Share of the cable's twist that creeps: mean and deviation.
    pub creep: [f32; 2],
    /// Deviation of the rotor's inertia, as a share of it.
    pub inertia_share: f32,
    /// What lies in series.
    pub series: PhantomData<X>,
}

impl<X: Series> Prior<X> {
    /// Number of unknowns: the cable's two are the last.
    pub const UNKNOWNS: usize = if X::FLEXIBLE {
        FLEXIBLE_UNKNOWNS
    } else {
        RIGID_UNKNOWNS
    };
}
