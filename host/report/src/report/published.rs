//! What a user would otherwise pick on a PC: (18) with nalgebra's LU decomposition and Brent's method of the crate `roots`,
//! which needs the standard library and cannot run on the chip. Judged on the same rows as the others; it has no cost there.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use palpate_bench::candidate::{Candidate, NOWHERE, Roots, on_phalanx};
use palpate_bench::three::ThreePhalanges;
use palpate_bench::two::TwoPhalanges;
use roots::{SimpleConvergency, find_root_brent};

/// Two phalanges.
pub const TWO: &[Candidate<TwoPhalanges, Roots>] = &[
    Candidate {
        name: "nalgebra_roots_f32",
        run: two_f32,
        chosen: None,
    },
    Candidate {
        name: "nalgebra_roots_f64",
        run: two_f64,
        chosen: None,
    },
];

/// Three phalanges.
pub const THREE: &[Candidate<ThreePhalanges, Roots>] = &[
    Candidate {
        name: "nalgebra_roots_f32",
        run: three_f32,
        chosen: None,
    },
    Candidate {
        name: "nalgebra_roots_f64",
        run: three_f64,
        chosen: None,
    },
];

/// The equation divides by k: brackets begin at this share of the length.
const NEAREST: f32 = 1e-6;
/// Stretches of the scan of a phalanx where nothing tells how the compliance turns.
const SCAN: u8 = 16;
/// Most steps of a search.
const MOST: usize = 100;

macro_rules! published {
    ($real:ident, $two:ident, $three:ident) => {
        /// The place as a share of the length; residuals are shares of the compliance, so one tolerance fits both.
        fn $two(input: &TwoPhalanges) -> Roots {
            let [l1, l2, x2, stiffness1, stiffness2, compliance, theta2] = [
                input.l1,
                input.l2,
                input.x2,
                input.stiffness1,
                input.stiffness2,
                input.compliance,
                input.theta2_rad,
            ]
            .map($real::from);
            let c = l1 * theta2.cos() / l2;
            let slopes = |share: $real| {
                let beta = 1.0 + c / share;
                Matrix2::new(stiffness1, -beta * stiffness2, beta, 1.0)
                    .lu()
                    .solve(&Vector2::new(1.0 - beta * x2, 0.0))
                    .unwrap_or(Vector2::repeat($real::NAN))
            };
            let residual = |share: $real| {
                let slopes = slopes(share);
                (slopes.x + x2 * slopes.y) / compliance - 1.0
            };
            input.brackets().map(|(lo, hi)| {
                let (lo, hi) = ($real::from(lo) / l2, $real::from(hi) / l2);
                let mut convergency = SimpleConvergency {
                    eps: $real::EPSILON,
                    max_iter: MOST,
                };
                match find_root_brent(lo.max(NEAREST.into()), hi, residual, &mut convergency) {
                    Ok(share) if x2 - stiffness2 * slopes(share).y > 0.0 => {
                        on_phalanx((share * l2) as f32, input.l2)
                    }
                    _ => f32::NAN,
                }
            })
        }

        /// The same from a scan of the phalanx.
        fn $three(input: &ThreePhalanges) -> Roots {
            let [
                l1,
                l2,
                length,
                x2,
                x3,
                stiffness1,
                h22,
                h23,
                h33,
                compliance,
                theta2,
                theta3,
            ] = [
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
                input.theta2_rad,
                input.theta3_rad,
            ]
            .map($real::from);
            let stiffness = Matrix3::new(stiffness1, 0.0, 0.0, 0.0, h22, h23, 0.0, h23, h33);
            let x = Vector3::new(1.0, x2, x3);
            let distal = input.phalanx == 3;
            let (near, far) = if distal {
                (l2 * theta3.cos(), l1 * (theta2 + theta3).cos())
            } else {
                (l1 * theta2.cos(), 0.0)
            };
            let slopes = |share: $real| {
                let beta = 1.0 + near / (share * length);
                let (one, two, gamma) = if distal {
                    let arm = beta + far / (share * length);
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
                .unwrap_or(Vector3::repeat($real::NAN))
            };
            let residual = |share: $real| x.dot(&slopes(share)) / compliance - 1.0;
            let mut found = NOWHERE;
            let mut lo = $real::from(NEAREST);
            let mut was_positive = residual(lo) > 0.0;
            for stretch in 1..=SCAN {
                let hi = $real::from(stretch) / $real::from(SCAN);
                let is_positive = residual(hi) > 0.0;
                let mut convergency = SimpleConvergency {
                    eps: $real::EPSILON,
                    max_iter: MOST,
                };
                if is_positive != was_positive
                    && let Ok(share) = find_root_brent(lo, hi, residual, &mut convergency)
                {
                    let tau = x - stiffness * slopes(share);
                    if (if distal { tau.z } else { tau.y }) > 0.0 {
                        found = [
                            found[1],
                            on_phalanx((share * length) as f32, input.length()),
                        ];
                    }
                }
                (lo, was_positive) = (hi, is_positive);
            }
            found
        }
    };
}

published!(f32, two_f32, three_f32);
published!(f64, two_f64, three_f64);
