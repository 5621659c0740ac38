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

use crate::numeric::Bounded;
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
/// Normal equations of kappa, rho and e, of all blocks since the last recording of friction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TorqueConstant {
    blocks: f32,
    r: f32,
    e: f32,
    rr: f32,
    re: f32,
    ee: f32,
    y: f32,
    ry: f32,
    ey: f32,
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
        self.blocks += 1.0;
        self.r += r;
        self.e += e;
        self.rr += r * r;
        self.re += r * e;
        self.ee += e * e;
        self.y += y;
        self.ry += r * y;
        self.ey += e * y;
    }

    /// Posterior of kappa: rho and e are eliminated from the normal equations, which have the priors on their diagonal.
    #[inline(never)]
    pub(super) fn shift(&self, drivetrain: &Drivetrain) -> ConstantShift {
        const VARIANCE: f32 = BLOCK_SIGMA * BLOCK_SIGMA;
        const RESISTANCE: f32 = VARIANCE / (RESISTANCE_SIGMA * RESISTANCE_SIGMA);
        const BRIDGE: f32 = VARIANCE / (BRIDGE_SIGMA_V * BRIDGE_SIGMA_V);
        let prior = drivetrain.torque_constant_sigma * drivetrain.torque_constant_sigma;
        let by_e = 1.0 / (self.ee + BRIDGE);
        let (re, ke) = (self.re * by_e, self.e * by_e);
        let rr = (self.rr + RESISTANCE - re * self.re).at_least(RESISTANCE);
        let kr = self.r - ke * self.re;
        let ry = self.ry - re * self.ey;
        let by_r = kr / rr;
        // Information of kappa by the blocks alone, and its mean times that.
        let told = (self.blocks - ke * self.e - by_r * kr).at_least(0.0) / VARIANCE;
        let weighted = (self.y - ke * self.ey - by_r * ry) / VARIANCE;
        let variance = prior / (1.0 + prior * told);
        let share = variance * weighted;
        // Of a mean that is expected within the prior; nor is it a NaN.
        if share * share <= IMPLAUSIBLE * IMPLAUSIBLE * prior {
            ConstantShift {
                share,
                variance: prior - variance,
            }
        } else {
            ConstantShift::default()
        }
    }
}
