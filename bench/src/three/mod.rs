//! Task `k2_3p`: the same for phalanx 2 or 3 of a finger with three phalanges.

mod algebra;
mod bracketed;
mod library;
mod lookup;
mod matrix;

use crate::candidate::{Candidate, Roots};
use crate::published;
use crate::two::TwoPhalanges;

/// Reduced data of a finger with three phalanges at the instant of contact. Any consistent units.
#[derive(Clone, Copy, Debug)]
pub struct ThreePhalanges {
    /// Phalanx in contact, 2 or 3.
    pub phalanx: u8,
    /// Lengths.
    pub l: [f32; 3],
    /// Angle of joint 2, radian.
    pub theta2_rad: f32,
    /// Angle of joint 3, radian.
    pub theta3_rad: f32,
    /// cos theta_2, which the firmware has at hand, as the next two.
    pub cos2: f32,
    /// cos theta_3.
    pub cos3: f32,
    /// cos (theta_2 + theta_3).
    pub cos23: f32,
    /// Transmission factor x_2.
    pub x2: f32,
    /// Transmission factor x_3.
    pub x3: f32,
    /// Stiffness of joint 1.
    pub stiffness1: f32,
    /// Stiffness H = K - G of joints 2 and 3: H_22.
    pub h22: f32,
    /// H_23.
    pub h23: f32,
    /// H_33.
    pub h33: f32,
    /// C = 1/K_c, measured.
    pub compliance: f32,
}

impl ThreePhalanges {
    /// Length of the phalanx in contact.
    #[inline(always)]
    pub fn length(&self) -> f32 {
        if self.phalanx == 3 {
            self.l[2]
        } else {
            self.l[1]
        }
    }

    /// A contact on phalanx 2 leaves joint 3 free: the finger is one of two phalanges with these values
    /// (docs/MECHANICS.md#contact-stiffness).
    /// Nothing where joint 3 alone is softer than what was measured.
    #[inline(always)]
    fn effective(&self) -> Option<TwoPhalanges> {
        let compliance = self.compliance - self.x3 * self.x3 / self.h33;
        (compliance >= 0.0).then_some(TwoPhalanges {
            l1: self.l[0],
            l2: self.l[1],
            theta2_rad: self.theta2_rad,
            cos2: self.cos2,
            x2: self.x2 - self.h23 * self.x3 / self.h33,
            stiffness1: self.stiffness1,
            stiffness2: self.h22 - self.h23 * self.h23 / self.h33,
            compliance,
        })
    }
}

/// The candidates.
pub const CANDIDATES: &[Candidate<ThreePhalanges, Roots>] = &[
    Candidate::bisection(library::bisected),
    Candidate::closed_form(library::closed),
    Candidate::rival("textbook_k", algebra::textbook),
    Candidate::rival("bisection_12", bracketed::bisection_12),
    Candidate::rival("bisection_20", bracketed::bisection_20),
    Candidate::rival("bisection_28", bracketed::bisection_28),
    Candidate::rival("itp", bracketed::itp),
    Candidate::rival("chandrupatla", bracketed::chandrupatla),
    Candidate::rival("newton_bracketed", bracketed::newton),
    Candidate::rival("matrix_18_bisection_28", matrix::bisection),
    Candidate::rival("matrix_18_chandrupatla", matrix::chandrupatla),
    Candidate::rival("table_257", lookup::table),
    Candidate::rival("nalgebra_numeris_f32_libm", published::three_f32_libm),
    Candidate::rival(
        "nalgebra_numeris_f32_micromath",
        published::three_f32_micromath,
    ),
    Candidate::rival("nalgebra_numeris_f64_libm", published::three_f64_libm),
];
