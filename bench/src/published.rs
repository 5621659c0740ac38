//! The obvious alternative for a user: equation (18) as it is printed, solved by nalgebra's LU decomposition at every trial
//! place, in f32 or f64, searched with a published root finder. Places are shares of the phalanx and residuals shares of the
//! compliance, so that one tolerance fits both.

use crate::candidate::{NOWHERE, Roots, on_phalanx};
use crate::three::ThreePhalanges;
use crate::two::TwoPhalanges;
use micromath::F32Ext;
use nalgebra::{Matrix2, Matrix3, RealField, Vector2, Vector3, one, zero};
use numeris::optim::{RootSettings, brent};

/// The equation divides by k: brackets begin at this share of the length.
const NEAREST: f32 = 1e-6;
/// Stretches of the scan of a phalanx where nothing tells how the compliance turns.
const SCAN: u8 = 16;
/// Most steps of a search.
pub const MOST: usize = 100;

/// f32 or f64.
pub trait Real: RealField + Copy + From<f32> {
    /// Rounded to f32.
    fn narrow(self) -> f32;
}

impl Real for f32 {
    fn narrow(self) -> f32 {
        self
    }
}

impl Real for f64 {
    fn narrow(self) -> f32 {
        self as f32
    }
}

/// A root finder over a bracket.
pub trait Method {
    /// What it computes with.
    type Real: Real;
    /// A zero of `f` between two ends; nothing where it finds none.
    fn search(f: impl Fn(Self::Real) -> Self::Real, ends: [Self::Real; 2]) -> Option<Self::Real>;
}

/// A finger of two phalanges, lengths as shares of the phalanx in contact.
struct Two<R> {
    c: R,
    x2: R,
    k1: R,
    h22: R,
}

impl<R: Real> Two<R> {
    /// theta' per torque with a contact at a share of the phalanx.
    #[inline(never)]
    fn slopes(&self, share: R) -> Vector2<R> {
        let beta = one::<R>() + self.c / share;
        Matrix2::new(self.k1, -beta * self.h22, beta, one())
            .lu()
            .solve(&Vector2::new(one::<R>() - beta * self.x2, zero()))
            .unwrap_or(Vector2::repeat(R::from(f32::NAN)))
    }
}

/// Two phalanges: the brackets on which the compliance is monotone are known.
// Once for each type of number: the chip's flash has no room for a copy for each cosine.
#[inline(never)]
pub fn two<M: Method>(input: &TwoPhalanges, cos: fn(f32) -> M::Real) -> Roots {
    let [l1, l2, x2, k1, h22, compliance] = [
        input.l1,
        input.l2,
        input.x2,
        input.stiffness1,
        input.stiffness2,
        input.compliance,
    ]
    .map(M::Real::from);
    let c = l1 * cos(input.theta2_rad) / l2;
    let finger = Two { c, x2, k1, h22 };
    let residual = |share: M::Real| {
        let slopes = finger.slopes(share);
        (slopes.x + x2 * slopes.y) / compliance - one()
    };
    input.brackets().map(|(lo, hi)| {
        let lo = M::Real::from(lo) / l2;
        let nearest = M::Real::from(NEAREST);
        let lo = if lo > nearest { lo } else { nearest };
        match M::search(residual, [lo, M::Real::from(hi) / l2]) {
            Some(share) if x2 - h22 * finger.slopes(share).y > zero() => {
                on_phalanx((share * l2).narrow(), input.l2)
            }
            _ => f32::NAN,
        }
    })
}

/// A finger of three phalanges, lengths as shares of the phalanx in contact.
struct Three<R: Real> {
    distal: bool,
    /// Moment arms of the joints before the contact's, less the place itself.
    near: R,
    far: R,
    x: Vector3<R>,
    stiffness: Matrix3<R>,
}

impl<R: Real> Three<R> {
    /// theta' per torque with a contact at a share of the phalanx.
    #[inline(never)]
    fn slopes(&self, share: R) -> Vector3<R> {
        let (zero, one): (R, R) = (zero(), one());
        let beta = one + self.near / share;
        let (first, second, gamma) = if self.distal {
            let arm = beta + self.far / share;
            (
                Vector3::new(one, zero, -arm),
                Vector3::new(zero, one, -beta),
                Vector3::new(arm, beta, one),
            )
        } else {
            (
                Vector3::new(one, -beta, zero),
                Vector3::new(zero, zero, one),
                Vector3::new(beta, one, zero),
            )
        };
        Matrix3::from_rows(&[
            (self.stiffness * first).transpose(),
            (self.stiffness * second).transpose(),
            gamma.transpose(),
        ])
        .lu()
        .solve(&Vector3::new(first.dot(&self.x), second.dot(&self.x), zero))
        .unwrap_or(Vector3::repeat(R::from(f32::NAN)))
    }

    /// The contact force grows with the torque.
    #[inline(never)]
    fn presses(&self, share: R) -> bool {
        let tau = self.x - self.stiffness * self.slopes(share);
        (if self.distal { tau.z } else { tau.y }) > zero()
    }
}

/// Three phalanges: brackets come from a scan of the phalanx.
// Once for each type of number: the chip's flash has no room for a copy for each cosine.
#[inline(never)]
pub fn three<M: Method>(input: &ThreePhalanges, cos: fn(f32) -> M::Real) -> Roots {
    let [l1, l2, length, x2, x3, k1, h22, h23, h33, compliance] = [
        input.l[0],
        input.l[1],
        input.length(),
        input.x2,
        input.x3,
        input.stiffness1,
        input.h22,
        input.h23,
        input.h33,
        input.compliance,
    ]
    .map(M::Real::from);
    let (zero, one): (M::Real, M::Real) = (zero(), one());
    let distal = input.phalanx == 3;
    let (near, far) = if distal {
        (
            l2 * cos(input.theta3_rad),
            l1 * cos(input.theta2_rad + input.theta3_rad),
        )
    } else {
        (l1 * cos(input.theta2_rad), zero)
    };
    let finger = Three {
        distal,
        near: near / length,
        far: far / length,
        x: Vector3::new(one, x2, x3),
        stiffness: Matrix3::new(k1, zero, zero, zero, h22, h23, zero, h23, h33),
    };
    let residual = |share: M::Real| finger.x.dot(&finger.slopes(share)) / compliance - one;
    let mut roots = NOWHERE;
    let mut lo = M::Real::from(NEAREST);
    let mut was_positive = residual(lo) > zero;
    for stretch in 1..=SCAN {
        let hi = M::Real::from(f32::from(stretch) / f32::from(SCAN));
        let is_positive = residual(hi) > zero;
        if is_positive != was_positive
            && let Some(share) = M::search(residual, [lo, hi])
            && finger.presses(share)
        {
            roots = [
                roots[1],
                on_phalanx((share * length).narrow(), input.length()),
            ];
        }
        (lo, was_positive) = (hi, is_positive);
    }
    roots
}

/// Brent's method of numeris, which runs on the chip.
macro_rules! numeris {
    ($method:ident, $real:ty, $width:literal) => {
        struct $method;

        impl Method for $method {
            type Real = $real;

            #[inline(always)]
            fn search(f: impl Fn($real) -> $real, [lo, hi]: [$real; 2]) -> Option<$real> {
                let settings = RootSettings {
                    x_tol: $width,
                    f_tol: $width,
                    max_iter: MOST,
                };
                Some(brent(f, lo, hi, &settings).ok()?.x)
            }
        }
    };
}

numeris!(NumerisF32, f32, 1e-7);
numeris!(NumerisF64, f64, 1e-12);

/// A candidate for each number of phalanges.
macro_rules! candidates {
    ($two:ident, $three:ident, $method:ident, $cos:expr) => {
        /// Two phalanges.
        #[inline(never)]
        pub fn $two(input: &TwoPhalanges) -> Roots {
            two::<$method>(input, $cos)
        }

        /// Three phalanges.
        #[inline(never)]
        pub fn $three(input: &ThreePhalanges) -> Roots {
            three::<$method>(input, $cos)
        }
    };
}

candidates!(two_f32_libm, three_f32_libm, NumerisF32, libm::cosf);
candidates!(two_f32_micromath, three_f32_micromath, NumerisF32, |x| {
    F32Ext::cos(x)
});
candidates!(two_f64_libm, three_f64_libm, NumerisF64, |x| libm::cos(
    f64::from(x)
));
