//! What a user would otherwise pick: (18) with nalgebra's LU decomposition, searched with Brent's method of numeris, the
//! cosine from libm or micromath; in f32 and in f64.

use super::TwoPhalanges;
use crate::candidate::{Roots, on_phalanx};
use micromath::F32Ext;
use nalgebra::{Matrix2, Vector2};
use numeris::optim::{RootSettings, brent};

macro_rules! published {
    ($(#[$doc:meta])* $name:ident, $real:ty, $width:literal, $cos:expr) => {
        $(#[$doc])*
        #[inline(never)]
        pub fn $name(input: &TwoPhalanges) -> Roots {
            let c = <$real>::from(input.l1) * $cos(input.theta2_rad);
            let [l2, x2, stiffness1, stiffness2, compliance] = [
                input.l2, input.x2, input.stiffness1, input.stiffness2, input.compliance,
            ]
            .map(<$real>::from);
            let slopes = |k: $real| {
                let beta = 1.0 + c / k;
                Matrix2::new(stiffness1, -beta * stiffness2, beta, 1.0)
                    .lu()
                    .solve(&Vector2::new(1.0 - beta * x2, 0.0))
                    .unwrap_or(Vector2::repeat(<$real>::NAN))
            };
            let residual = |k: $real| {
                let slopes = slopes(k);
                slopes.x + x2 * slopes.y - compliance
            };
            let settings = RootSettings { x_tol: $width * l2, f_tol: $width * compliance, max_iter: 100 };
            let nearest = 1e-6 * l2;
            input.brackets().map(|(lo, hi)| {
                let lo = <$real>::from(lo).max(nearest);
                match brent(residual, lo, <$real>::from(hi), &settings) {
                    Ok(root) if (x2 - stiffness2 * slopes(root.x).y) > 0.0 => {
                        on_phalanx(root.x as f32, input.l2)
                    }
                    _ => f32::NAN,
                }
            })
        }
    };
}

published!(
    /// f32 throughout, libm's cosine.
    f32_libm, f32, 1e-7, libm::cosf
);
published!(
    /// f32 throughout, micromath's cosine.
    f32_micromath, f32, 1e-7, |x: f32| F32Ext::cos(x)
);
published!(
    /// f64 throughout, libm's cosine.
    f64_libm, f64, 1e-12, |x: f32| libm::cos(f64::from(x))
);
