//! The motor's torque constant from its back-EMF while the finger closes: a good part of what is not known of a torque factor before a
//! pin tells it.
//!
//! The constant k is both newton metre per ampere and volt second per radian. At a speed of the input link where the nominal motor
//! makes the EMF `E`, the measured one exceeds it by a share
//!
//! ```text
//! y = kappa + rho R i / E + e / E
//! ```
//!
//! of `E`: `kappa` is the deviation of k, `rho` that of the resistance R that was assumed at the current i, `e` what bridge and supply
//! are off by. Friction's current hardly varies, so that a free closing does not separate kappa from rho; the rise after a contact
//! does. Nothing separates `e` at one speed (docs/MECHANICS.md#torque-constant).

use crate::numeric::Bounded;
use crate::sensing::Drivetrain;
use crate::sensing::block::Block;

/// Standard deviation of the resistance, winding and its temperature, as a share: 20 %, uniform (R).
const RESISTANCE_SIGMA: f32 = 0.115;
/// Standard deviation of the EMF by what the bridge's dead time takes beyond the nominal 300 ns, 30 % of 0.36 V, uniform, and by the
/// supply's divider, 1 % of 4 V (R), volt.
const BRIDGE_SIGMA_V: f32 = 0.08;
/// Standard deviation of one block, as a share: commutation and the speed loop (R, chosen); some hundred blocks average it.
const BLOCK_SIGMA: f32 = 0.02;
/// A deviation of the constant that is larger, in standard deviations of what is expected, is a fault of the measurement.
const IMPLAUSIBLE: f32 = 4.0;

/// Sums over the blocks of a closing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TorqueConstant {
    blocks: f32,
    y: f32,
    x: f32,
    xx: f32,
    xy: f32,
    /// Sum of 1/E.
    per_v: f32,
}

/// What a closing tells of the torque constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ConstantShift {
    /// Expected deviation of the constant from the nominal one, as a share.
    pub(super) share: f32,
    /// Variance of that share that is no longer unknown.
    pub(super) variance: f32,
}

impl TorqueConstant {
    /// Adds a block of a closing; one without a back-EMF adds nothing.
    pub(super) fn push(&mut self, block: &Block, drivetrain: &Drivetrain, speed_rad_per_s: f32) {
        let nominal_v = drivetrain.torque_per_ampere_nm * speed_rad_per_s * (1.0 + block.overspeed);
        let per_v = 1.0 / nominal_v;
        let current_a = block.drive_torque_nm / drivetrain.torque_per_ampere_nm;
        let y = block.emf_v * per_v - 1.0;
        let x = drivetrain.resistance_ohm * current_a * per_v;
        // A NaN is left out.
        if y.abs() <= 1.0 && x.abs() <= f32::MAX {
            self.blocks += 1.0;
            self.y += y;
            self.x += x;
            self.xx += x * x;
            self.xy += x * y;
            self.per_v += per_v;
        }
    }

    /// Means of kappa and rho given their priors, by least squares; of kappa what the priors of kappa and `e / E` share.
    // Not inlined: called once a round of the fit.
    #[inline(never)]
    pub(super) fn shift(&self, drivetrain: &Drivetrain) -> ConstantShift {
        if self.blocks < 1.0 {
            return ConstantShift::default();
        }
        let constant2 = drivetrain.torque_constant_sigma * drivetrain.torque_constant_sigma;
        let bridge = BRIDGE_SIGMA_V * self.per_v / self.blocks;
        // Of kappa + e / E, which one speed does not separate.
        let sum2 = constant2 + bridge * bridge;
        const WEIGHT: f32 = 1.0 / (BLOCK_SIGMA * BLOCK_SIGMA);
        let kk = WEIGHT * self.blocks + 1.0 / sum2;
        let kr = WEIGHT * self.x;
        let rr = WEIGHT * self.xx + 1.0 / (RESISTANCE_SIGMA * RESISTANCE_SIGMA);
        let variance = rr / (kk * rr - kr * kr).at_least(f32::MIN_POSITIVE);
        let mean = variance * WEIGHT * (self.y - kr / rr * self.xy);
        let gain = constant2 / sum2;
        if mean * mean <= IMPLAUSIBLE * IMPLAUSIBLE * sum2 {
            ConstantShift {
                share: gain * mean,
                // Of the sum `variance` is still unknown.
                variance: gain * gain * (sum2 - variance).at_least(0.0),
            }
        } else {
            ConstantShift::default()
        }
    }
}
