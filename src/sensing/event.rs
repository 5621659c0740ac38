//! Events: the output of sensing.

use crate::sensing::calibration::{Calibration, Refusal};

/// Why a contact was felt but not located.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotLocated {
    /// As soft as a contact on the proximal phalanx, where the stiffness does not depend on the place
    /// (docs/MECHANICS.md#contact-stiffness).
    Proximal,
    /// Softer than the finger without contact: back contact or a failing mechanism.
    TooSoft,
    /// Between a proximal contact and no contact: no place on the finger is that soft.
    Gap,
    /// Stiffer than any place on the finger.
    TooStiff,
    /// The curve fits no single contact: there are two, or the object yields or slips.
    Unexplained,
    /// The finger's stiffness hardly depends on the place in this posture, or two phalanges explain the curve alike.
    Unobservable,
    /// The motion ended, or the torque limit was reached, before there were enough points.
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
        /// Standard deviation of the residual.
        residual_nm: f32,
        /// Share of the travel that was recorded, 0 to 1.
        coverage: f32,
        /// Standard deviation of the wander of friction between two closings.
        wander_nm: f32,
        /// Time constant of the wander, second.
        wander_s: f32,
    },
    /// Too little of the motion could be used: a larger travel or a steadier speed is needed.
    FrictionNotRecorded {
        /// Share of the travel that was covered, 0 to 1.
        coverage: f32,
    },
    /// Friction has changed since it was recorded: record again.
    FrictionStale {
        /// Mean misfit.
        misfit_nm: f32,
    },
    /// Softer than expected without contact: contact on the back or a failing mechanism.
    Unusual {
        /// Measured global stiffness K_a (7), newton metre per radian.
        k_a_nm_per_rad: f32,
        /// Its standard deviation, from the uncertainty of friction.
        k_a_sigma_nm_per_rad: f32,
        /// Global stiffness expected without contact.
        k_a_free_nm_per_rad: f32,
    },
    /// A closing has ended, with or without a contact: global stiffness from rest to its end.
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
        /// Time of the decision, microseconds since boot.
        time_us: u64,
        /// Input-link angle at the onset of contact, radian.
        theta_a_rad: f32,
        /// Torque above friction when the contact was decided.
        torque_nm: f32,
    },
    /// A contact is located; repeated when the location improves.
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
        /// Final: more torque would not improve it, or the wanted deviation is reached.
        settled: bool,
    },
    /// Two places explain the same curve.
    Ambiguous {
        /// Candidate phalanges, the likelier first.
        phalanx: [u8; 2],
        /// Their probabilities.
        p_phalanx: [f32; 2],
        /// Candidate locations, metre.
        k_m: [f32; 2],
        /// Their standard deviations, metre.
        sigma_m: [f32; 2],
        /// Final: more torque would not improve it.
        settled: bool,
    },
    /// A contact that cannot be located. Final.
    NotLocated {
        /// Why.
        why: NotLocated,
        /// Torque above friction at the end.
        torque_nm: f32,
    },
    /// Torque factor or cable was calibrated.
    Calibrated {
        /// The new calibration.
        calibration: Calibration,
    },
    /// A calibration was refused; the previous one stays.
    CalibrationRefused {
        /// Why.
        why: Refusal,
    },
}
