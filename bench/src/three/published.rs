//! What a user would otherwise pick: (18) with nalgebra's LU decomposition, scanned and searched with Brent's method of
//! numeris, cosines from libm or micromath; in f32 and in f64.

use super::ThreePhalanges;
use super::matrix::{NEAREST, SCAN};
use crate::candidate::{NOWHERE, Roots, on_phalanx};
use micromath::F32Ext;
use nalgebra::{Matrix3, Vector3};
use numeris::optim::{RootSettings, brent};

macro_rules! published {
    ($(#[$doc:meta])* $name:ident, $real:ty, $width:literal, $cos:expr) => {
        $(#[$doc])*
        #[inline(never)]
        pub fn $name(input: &ThreePhalanges) -> Roots {
            let [l1, l2, length, x2, x3, stiffness1, h22, h23, h33, compliance] = [
                input.l[0], input.l[1], input.length(), input.x2, input.x3, input.stiffness1,
                input.h22, input.h23, input.h33, input.compliance,
            ]
            .map(<$real>::from);
            let stiffness = Matrix3::new(stiffness1, 0.0, 0.0, 0.0, h22, h23, 0.0, h23, h33);
            let x = Vector3::new(1.0, x2, x3);
            let distal = input.phalanx == 3;
            let (near, far) = if distal {
                (
                    l2 * $cos(input.theta3_rad),
                    l1 * $cos(input.theta2_rad + input.theta3_rad),
                )
            } else {
                (l1 * $cos(input.theta2_rad), 0.0)
            };
            let slopes = |k: $real| {
                let beta = 1.0 + near / k;
                let (one, two, gamma) = if distal {
                    let arm = beta + far / k;
                    (
                        Vector3::new(1.0, 0.0, -arm),
                        Vector3::new(0.0, 1.0, -beta),
                        Vector3::new(arm, beta, 1.0),
                    )
                } else {
                    (
                        Vector3::new(1.0, -beta, 0.0),
                        Vector3::new(0.0, 0.0, 1.0),
                        Vector3::new(beta, 1.0, 0.0),
                    )
                };
                Matrix3::from_rows(&[
                    (stiffness * one).transpose(),
                    (stiffness * two).transpose(),
                    gamma.transpose(),
                ])
                .lu()
                .solve(&Vector3::new(one.dot(&x), two.dot(&x), 0.0))
                .unwrap_or(Vector3::repeat(<$real>::NAN))
            };
            let residual = |k: $real| x.dot(&slopes(k)) - compliance;
            let settings = RootSettings { x_tol: $width * length, f_tol: $width * compliance, max_iter: 100 };
            let mut roots = NOWHERE;
            let mut lo = <$real>::from(NEAREST) * length;
            let mut was_positive = residual(lo) > 0.0;
            for stretch in 1..=SCAN {
                let hi = length * stretch as $real / SCAN as $real;
                let is_positive = residual(hi) > 0.0;
                if is_positive != was_positive {
                    if let Ok(root) = brent(residual, lo, hi, &settings) {
                        let tau = x - stiffness * slopes(root.x);
                        let presses = if distal { tau.z } else { tau.y };
                        if presses > 0.0 {
                            roots = [roots[1], on_phalanx(root.x as f32, input.length())];
                        }
                    }
                }
                (lo, was_positive) = (hi, is_positive);
            }
            roots
        }
    };
}

published!(
    /// f32 throughout, libm's cosines.
    f32_libm, f32, 1e-7, libm::cosf
);
published!(
    /// f32 throughout, micromath's cosines.
    f32_micromath, f32, 1e-7, |x: f32| F32Ext::cos(x)
);
published!(
    /// f64 throughout, libm's cosines.
    f64_libm, f64, 1e-12, |x: f32| libm::cos(f64::from(x))
);
