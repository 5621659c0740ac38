//! The motor's torque constant, from the back-EMF of steady motion: a good part of what is not known of a torque factor before a pin
//! tells it.
//!
//! The constant k is both newton metre per ampere and volt second per radian. At a speed where the nominal motor makes the EMF `E`,
//! the measured one exceeds it by the share
//!
//! ```text
//! y = kappa + rho R i / E + e / E
//! ```
//!
//! `kappa` is the deviation of k, `rho` that of the resistance R that was assumed at the current i, `e` what bridge, supply and sense are
//! off by. The rise of the current after a contact tells rho, a second speed (of the opening) tells e. Least squares with the priors of
//! all three take what there is (docs/SENSING.md#torque-constant).

use crate::numeric::{Bounded, dot};
use crate::sensing::block::Block;
use crate::sensing::{Drive, Drivetrain};

/// Standard deviation of the resistance, as a share: winding and its temperature, 20 %, uniform (R).
pub(super) const RESISTANCE_SIGMA: f32 = 0.115;
/// Standard deviation of what else is in the EMF, volt: the 0.4 V that the bridge's dead time takes by half of themselves, uniform,
/// the supply's divider by 1 % of 4 V, a milliampere of the sense's offset (R).
pub(super) const BRIDGE_SIGMA_V: f32 = 0.15;
/// Standard deviation of one block, as a share: commutation and the speed loop (R, chosen); hundreds of blocks average it.
const BLOCK_SIGMA: f32 = 0.02;
/// Deviation of the constant, in standard deviations of what is expected, that is a fault of the measurement.
pub(super) const IMPLAUSIBLE: f32 = 4.0;

/// What is known of kappa, rho and e by the blocks since the last recording of friction: means and covariance. A filter and not the normal
/// equations: where the finger closes as fast as it opens these are nearly singular, and differences of sums over thousands of blocks
/// are rounding.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TorqueConstant {
    mean: [f32; 3],
    covariance: [[f32; 3]; 3],
}

/// What is known of the torque constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ConstantShift {
    /// Expected deviation from the nominal constant, as a share.
    pub(super) share: f32,
    /// Variance of that share that is no longer unknown.
    pub(super) variance: f32,
}

impl TorqueConstant {
    /// Adds a block; one without a back-EMF adds nothing.
    // Not inlined: its caller is the hot path of every block.
    #[inline(never)]
    pub(super) fn push(&mut self, block: &Block, drivetrain: &Drivetrain) {
        let direction = if block.drive == Drive::Opening {
            -1.0
        } else {
            1.0
        };
        let way_rad = block.width_counts as f32 * drivetrain.rad_per_count;
        let per_v = direction * block.duration_s / (way_rad * drivetrain.torque_per_ampere_nm);
        let current_a = block.drive_torque_nm / drivetrain.torque_per_ampere_nm;
        let y = block.emf_v * per_v - 1.0;
        let r = drivetrain.resistance_ohm * current_a * per_v;
        let e = direction * per_v;
        // A NaN is left out; a motor that does not turn shows nothing.
        if !(y.abs() < 1.0 && r.abs() < 10.0 && e < 10.0) {
            return;
        }
        if self.covariance[1][1] <= 0.0 {
            let sigmas = [
                drivetrain.torque_constant_sigma,
                RESISTANCE_SIGMA,
                BRIDGE_SIGMA_V,
            ];
            for (index, sigma) in sigmas.into_iter().enumerate() {
                self.covariance[index][index] = sigma * sigma;
            }
        }
        let row = [1.0, r, e];
        let mut with_row = [0.0; 3];
        for (with, line) in with_row.iter_mut().zip(&self.covariance) {
            *with = dot(line, &row);
        }
        let variance = BLOCK_SIGMA * BLOCK_SIGMA + dot(&row, &with_row);
        let news = y - dot(&row, &self.mean);
        let lines = self.mean.iter_mut().zip(&mut self.covariance);
        for ((mean, line), with) in lines.zip(&with_row) {
            let gain = with / variance;
            *mean += gain * news;
            for (value, other) in line.iter_mut().zip(&with_row) {
                *value -= gain * other;
            }
        }
    }

    /// Posterior of kappa.
    pub(super) fn shift(&self, drivetrain: &Drivetrain) -> ConstantShift {
        let prior = drivetrain.torque_constant_sigma * drivetrain.torque_constant_sigma;
        let ([share, ..], [[left, ..], line, _]) = (self.mean, self.covariance);
        // Of a mean that is expected within the prior; nor is it a NaN.
        if line[1] > 0.0 && share * share <= IMPLAUSIBLE * IMPLAUSIBLE * prior {
            ConstantShift {
                share,
                variance: (prior - left).at_least(0.0),
            }
        } else {
            ConstantShift::default()
        }
    }
}
