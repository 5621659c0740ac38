//! What contacts at known places and the closing stop teach: the torque factor and the cable.
//!
//! A motor torque tells the load at the input link only up to the gears' efficiency eta, and the finger's compliance
//! is in proportion to 1/K_2: only the ratio eta/K_2 matters for a location (MATH 11). It is kept as a factor f on the
//! nominal ratio. The cable in series adds a twist in proportion to the torque; it is kept per newton metre *as computed
//! with the nominal efficiency*, so that pressing against the closing stop measures it whatever the efficiency is.

/// Torque factor and cable, with what is not known of them. Plain data: it is stored as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Calibration {
    /// f: eta/K_2 divided by its nominal value, > 0.
    pub torque_factor: f32,
    /// Standard deviation of ln f.
    pub torque_factor_sigma: f32,
    /// Twist of the cable per nominal torque, radian per newton metre, >= 0; 0 for a rigid one.
    pub cable_rad_per_nm: f32,
    /// Its standard deviation, radian per newton metre.
    pub cable_sigma_rad_per_nm: f32,
    /// Correlation of ln f and the cable's twist, -1 to 1.
    pub correlation: f32,
    /// Contacts at known places used.
    pub contacts: u8,
    /// Presses against the closing stop used.
    pub presses: u8,
}

/// Why a calibration is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Refusal {
    /// No contact was felt.
    NoContact,
    /// Too little torque or too few samples: press longer.
    TooFewSamples,
    /// No such place on the finger.
    NoSuchPlace,
    /// The curve is not that of a contact there, or of a stop: is the place right, does anything else touch?
    Misfit,
    /// So far from what was expected that a wrong place is more likely.
    Implausible,
    /// It tells neither factor nor cable better than they are known: choose another place.
    Uninformative,
}
