//! Task `k2_2p`: where on phalanx 2 of a finger with two phalanges is a contact of a measured compliance (18)?

mod algebra;
pub(crate) mod bracketed;
pub(crate) mod library;
pub(crate) mod lookup;
mod matrix;

use crate::candidate::{Candidate, Roots};
use crate::published;
pub(crate) use algebra::textbook_k_part;

/// Reduced data of a finger with two phalanges at the instant of contact. Any consistent units.
#[derive(Clone, Copy, Debug)]
pub struct TwoPhalanges {
    /// Length of phalanx 1.
    pub l1: f32,
    /// Length of phalanx 2.
    pub l2: f32,
    /// Angle of joint 2, radian.
    pub theta2_rad: f32,
    /// Its cosine, which the firmware has at hand.
    pub cos2: f32,
    /// Transmission factor x_2 = d theta_a / d theta_2.
    pub x2: f32,
    /// Stiffness of joint 1.
    pub stiffness1: f32,
    /// Stiffness of joint 2 less the transmission's share: K_2' = K_2 - G_22.
    pub stiffness2: f32,
    /// C = 1/K_c, measured.
    pub compliance: f32,
}

impl TwoPhalanges {
    /// c = l_1 cos theta_2.
    #[inline(always)]
    fn c(&self) -> f32 {
        self.l1 * self.cos2
    }

    /// Change of theta_2 per torque when the contact is at `k`; d f / d T_a = (x_2 - K_2' theta_2') / k must be
    /// positive for a contact that closing makes.
    #[inline(always)]
    fn presses(&self, k: f32, theta2_slope: f32) -> bool {
        (self.x2 - self.stiffness2 * theta2_slope) * k > 0.0
    }

    /// Brackets on which the compliance is monotone and every root is physical: below the stiffest point e_2 (27), and
    /// beyond it. An empty bracket has both ends NaN.
    #[inline(always)]
    pub fn brackets(&self) -> [(f32, f32); 2] {
        let c = self.c();
        let l2 = self.l2;
        if c > 0.0 {
            let rest = 1.0 - self.x2;
            let e2 = c * self.x2 / rest;
            if rest > 0.0 && e2 < l2 {
                [(0.0, e2), (e2, l2)]
            } else {
                [(0.0, l2), (f32::NAN, f32::NAN)]
            }
        } else {
            // Folded beyond 90 degrees: physical only beyond the softest point.
            let softest = -c / (1.0 + self.x2 * self.stiffness1 / self.stiffness2);
            [(f32::NAN, f32::NAN), (softest, l2)]
        }
    }
}

/// The candidates.
pub const CANDIDATES: &[Candidate<TwoPhalanges, Roots>] = &[
    Candidate::bisection(library::bisected),
    Candidate::closed_form(library::closed),
    Candidate::rival("textbook_beta", algebra::textbook_beta),
    Candidate::rival("textbook_k", algebra::textbook_k),
    Candidate::rival("bisection_8", bracketed::bisection_8),
    Candidate::rival("bisection_12", bracketed::bisection_12),
    Candidate::rival("bisection_16", bracketed::bisection_16),
    Candidate::rival("bisection_20", bracketed::bisection_20),
    Candidate::rival("bisection_24", bracketed::bisection_24),
    Candidate::rival("bisection_28", bracketed::bisection_28),
    Candidate::rival("itp", bracketed::itp),
    Candidate::rival("chandrupatla", bracketed::chandrupatla),
    Candidate::rival("newton_bracketed", bracketed::newton),
    Candidate::rival("matrix_18_bisection_28", matrix::bisection),
    Candidate::rival("matrix_18_chandrupatla", matrix::chandrupatla),
    Candidate::rival("table_9x9x17", lookup::table),
    Candidate::rival("nalgebra_numeris_f32_libm", published::two_f32_libm),
    Candidate::rival(
        "nalgebra_numeris_f32_micromath",
        published::two_f32_micromath,
    ),
    Candidate::rival("nalgebra_numeris_f64_libm", published::two_f64_libm),
];
