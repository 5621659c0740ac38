//! Joint 2 along a contact path.

use super::Path;
use crate::finger::{BaseJoint, Finger, JointPoint, Transmission};

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// See [`crate::finger::Mechanics::joint_2`].
    pub(crate) fn second_joint(&self, path: &Path<N, B>) -> Option<JointPoint> {
        let Path { start, last } = path;
        let local = start.local(&self.transmission, &last.at, last.rise)?;
        let [by_torque, by_k, by_friction, by_joint_friction] =
            local.joint_responses(last.at.force, 1)?;
        let point = JointPoint {
            at_contact_rad: *start.from.rad().get(1)?,
            rad: *last.at.delta.get(1)? + start.braked * by_joint_friction,
            by_torque_rad_per_nm: by_torque / start.stiffness_scale,
            by_k_rad_per_m: by_k / start.length_scale,
            by_friction_rad: by_friction,
            by_joint_friction_rad_per_nm: by_joint_friction / start.stiffness_scale,
        };
        let finite = [
            point.rad,
            point.by_torque_rad_per_nm,
            point.by_k_rad_per_m,
            by_friction,
            by_joint_friction,
        ];
        finite.iter().all(|x| x.is_finite()).then_some(point)
    }
}
