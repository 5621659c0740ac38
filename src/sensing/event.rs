//! Events: the output of sensing.

use crate::sensing::calibration::{Calibration, Refusal};

/// Why a contact was felt but not located.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotLocated {
    /// As soft as a contact on the proximal phalanx, anywhere on it: its place cannot be known
    /// (docs/MECHANICS.md#contact-stiffness).
    Proximal,
    /// Softer than the finger without contact: back contact or a failing mechanism.
    TooSoft,
    /// Between a proximal contact and no contact: no place on the finger is that soft.
    Gap,
    /// Stiffer than any place on the finger.
    TooStiff,
    /// No contact anywhere bends the curve like that: two contacts, an object that yields or slips.
    Unexplained,
    /// The finger's stiffness does not depend on the place: no curve determines it.
    Unobservable,
    /// The finger stopped, or torque ran out, before there was enough to judge.
    TooFewSamples,
}

/// An event of the sensing. Lengths in metre, torques at the input link in newton metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A free closing (and opening) was recorded.
    FrictionRecorded {
        /// Mean friction torque while closing.
        closing_nm: f32,
        /// Mean friction torque while opening, negative.
        opening_nm: f32,
        /// Standard deviation of what the table leaves unexplained.
        residual_nm: f32,
        /// Share of the travel that the table covers, 0 to 1.
        coverage: f32,
        /// How far friction wanders between two closings, standard deviation.
        wander_nm: f32,
        /// Time constant of the wander, second.
        wander_s: f32,
    },
    /// A free motion left too little of it to record: a larger travel, or a steadier speed, is needed.
    FrictionNotRecorded {
        /// Share of the travel that was covered, 0 to 1.
        coverage: f32,
    },
    /// The record no longer fits what a free motion shows: record again.
    FrictionStale {
        /// Mean misfit.
        misfit_nm: f32,
    },
    /// Softer than expected without contact: contact on the back or a failing mechanism.
    Unusual {
        /// Measured global stiffness K_a (7), newton metre per radian.
        k_a_nm_per_rad: f32,
        /// Standard deviation of it, from how far the friction may be off.
        k_a_sigma_nm_per_rad: f32,
        /// The same, expected without contact.
        k_a_free_nm_per_rad: f32,
    },
    /// A closing is over, with or without a contact: global stiffness from rest to its end.
    Stiffness {
        /// Measured global stiffness K_a (7), newton metre per radian.
        k_a_nm_per_rad: f32,
        /// Standard deviation of it, from how far the friction may be off.
        k_a_sigma_nm_per_rad: f32,
        /// The same, expected without contact.
        k_a_free_nm_per_rad: f32,
    },
    /// Contact begins.
    Touch {
        /// When it was decided, microseconds since boot.
        time_us: u64,
        /// Input-link angle at the onset of contact, radian from the opening stop.
        theta_a_rad: f32,
        /// Torque above friction when the contact was decided.
        torque_nm: f32,
    },
    /// A contact is located; sent again as it is refined.
    Located {
        /// Phalanx in contact, 2 for the second.
        phalanx: u8,
        /// Probability that it is this phalanx, 0 to 1.
        p_phalanx: f32,
        /// Contact location from the phalanx's joint, at first contact.
        k_m: f32,
        /// Standard deviation of `k_m`.
        sigma_m: f32,
        /// Instantaneous stiffness of the finger at contact K_c (8), newton metre per radian.
        k_c_nm_per_rad: f32,
        /// Contact force now (1), newton; NaN once the contact is lost: the finger has slid off, or the object gave way.
        force_n: f32,
        /// Standard deviation of `force_n`.
        force_sigma_n: f32,
        /// Effective contact radius, where the curve determines it (docs/MECHANICS.md#finite-torque-step); NaN where it
        /// does not.
        radius_m: f32,
        /// Standard deviation of `radius_m`.
        radius_sigma_m: f32,
        /// No further torque will improve it, or the wanted deviation is reached.
        settled: bool,
    },
    /// Two places explain the same curve.
    Ambiguous {
        /// Candidate phalanges, the likelier first.
        phalanx: [u8; 2],
        /// Their probabilities, each of all that touches that phalanx.
        p_phalanx: [f32; 2],
        /// Candidate locations, metre.
        k_m: [f32; 2],
        /// Their standard deviations, metre.
        sigma_m: [f32; 2],
        /// No further torque will improve it.
        settled: bool,
    },
    /// A contact without a location. Final.
    NotLocated {
        /// Why.
        why: NotLocated,
        /// Torque above friction when it was given up.
        torque_nm: f32,
    },
    /// A contact at a known place was used.
    Calibrated {
        /// What is known now.
        calibration: Calibration,
    },
    /// A calibration was refused; the one before stands.
    CalibrationRefused {
        /// Why.
        why: Refusal,
    },
}
