//! Constraints with a stiffness in newton per metre (or newton metre per radian).
//!
//! At rest the engine's one-sided constraints push with `f = k d r / R`, `R = w (1 - d) / d`, `k = K / d^2`, where `r` is
//! the depth, `w` the inverse weight that the engine estimates for each constraint, `d` the impedance and `K` the number
//! in the model. With a constant `d` that is a spring of known stiffness `K / (w (1 - d))`, so that stops and contacts
//! are as stiff as the parameters say.

use mujoco_rs::prelude::MjModel;

/// Impedance of stops and contacts; constant, so that the force is linear in the depth.
pub(crate) const IMPEDANCE: f64 = 0.9;

/// Stiffest constraint in the engine's measure, per square second (chosen: what the shortest step takes with ease).
const STIFFEST_PER_S2: f64 = 8e7;

/// Of the constraints that push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stiffness {
    pub stop_nm_per_rad: f64,
    pub contact_n_per_m: f64,
}

/// Stiffness and damping as the engine takes them: negative, per unit of inverse weight.
fn reference(stiffness: f64, inverse_weight: f64, step_s: f64) -> [f64; 2] {
    // Beyond 0.5 the explicit part of a step would overshoot.
    let most = STIFFEST_PER_S2.min(0.5 / (step_s * step_s));
    let scaled = (stiffness * inverse_weight * (1.0 - IMPEDANCE)).min(most);
    // Critical: with less, a contact rings with the regularisation as its mass.
    [-scaled, -2.0 * scaled.sqrt()]
}

impl Stiffness {
    /// Gives stops and contacts of a compiled model their stiffness.
    pub fn set(self, model: &mut MjModel) {
        let step_s = model.opt().timestep;
        let weights = model.dof_invweight0().to_vec();
        for (place, weight) in model.jnt_solref_mut().iter_mut().zip(weights) {
            *place = reference(self.stop_nm_per_rad, weight, step_s);
        }
        let weights = model.tendon_invweight0().to_vec();
        for (place, weight) in model.tendon_solref_lim_mut().iter_mut().zip(weights) {
            *place = reference(self.stop_nm_per_rad, weight, step_s);
        }
        let weights: Vec<f64> = model
            .pair_signature()
            .iter()
            .map(|signature| {
                let bodies = [signature >> 16, signature & 0xFFFF];
                bodies
                    .iter()
                    .filter_map(|&body| model.body_invweight0().get(usize::try_from(body).ok()?))
                    .map(|[translation, _]| translation)
                    .sum()
            })
            .collect();
        for (place, weight) in model.pair_solref_mut().iter_mut().zip(weights) {
            *place = reference(self.contact_n_per_m, weight, step_s);
        }
    }
}
