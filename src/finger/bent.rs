//! The free finger bent by its weight, where the input link alone holds that (docs/SENSING.md#gravity).

// Indices are those of the matrices in the equations; loops over 1..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::{BaseJoint, Configuration, Finger, Free, Transmission};
use crate::numeric::Bounded;

/// Rounds in which a weight bends the finger: each leaves a third of what the one before it did of a bend of 0.3 rad.
const BENDING_ROUNDS: u8 = 5;

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// See [`super::Mechanics::weighed`].
    pub(crate) fn under_weight(
        &self,
        free: &Free<Configuration<N>>,
        torque_nm: f32,
        preload_nm: f32,
    ) -> Option<(Free<Configuration<N>>, f32)> {
        if !self.springless() {
            return None;
        }
        let parameters = &self.parameters;
        let length_m: f32 = parameters.lengths_m.iter().sum();
        let from = free.configuration.rad();
        let (mut at, mut first_nm) = (free.configuration, 0.0);
        for round in 0..BENDING_ROUNDS {
            let gear = self.transmission.factors(&at)?;
            let (mut rad, mut beyond_m) = (from, length_m);
            for i in 1..N {
                beyond_m -= parameters.lengths_m[i - 1];
                // Of the weight's torque about joint 1, what acts about this joint.
                let share = beyond_m / length_m;
                let turning_nm = (gear.x[i] - share * share) * torque_nm;
                let low = parameters.range_rad[i][0];
                let held_nm = preload_nm - turning_nm;
                rad[i] = (from[i] - held_nm / parameters.stiffness_nm_per_rad[i]).at_least(low);
                rad[0] -= gear.x[i] * (rad[i] - from[i]);
                // Away from its stop the joint turns at once.
                if round == 0 && i == 1 && from[i] <= low {
                    first_nm = held_nm;
                }
            }
            at = Configuration::of(rad)?;
        }
        let weighed = Free {
            configuration: at,
            torque_nm,
        };
        Some((weighed, first_nm))
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use crate::finger::{Mechanics, Transmission};
    use crate::scene::{P70, Scene, Tendon2};

    const PRELOAD_NM: f32 = 0.4e-3;

    #[test]
    fn a_weight_bends_the_finger_or_is_held_by_a_stop() {
        let finger = P70::MECHANISM;
        let free = finger.free_at_angle(0.7, &finger.rest()).unwrap();
        // Mass m, even over phalanges in line and at right angles to its weight: torques m g l/2 about either joint.
        let [l_1, l_2] = finger.parameters.lengths_m;
        let share = (l_2 * l_2) / ((l_1 + l_2) * (l_1 + l_2));
        let stiffness = finger.parameters.stiffness_nm_per_rad[1];
        for torque_nm in [0.004f32, 0.012] {
            let (bent, held_nm) = finger.weighed(&free, torque_nm, PRELOAD_NM).unwrap();
            let joint_rad = finger.joint_rad(&bent.configuration, 2).unwrap();
            // Where it is bent the spring balances it; where it is not, a stop would have to.
            let [bent_nm, stopped_nm] = [&bent, &free].map(|at| {
                let gear = finger.transmission.factors(&at.configuration).unwrap();
                (gear.x[1] - share) * torque_nm - PRELOAD_NM
            });
            let left_nm = bent_nm - stiffness * joint_rad;
            assert!(
                left_nm.abs() < 1e-7 && (held_nm + stopped_nm).abs() < 1e-7,
                "{left_nm} {held_nm}"
            );
            assert_eq!(bent.torque_nm, torque_nm);
            // The input link stays where it was, to the bend's second order.
            let moved = finger.input_angle_rad(&bent.configuration) - 0.7;
            assert!(
                moved.abs() < 0.4 * joint_rad * joint_rad,
                "{moved} {joint_rad}"
            );
        }
        let (closed, held_nm) = finger.weighed(&free, -0.01, PRELOAD_NM).unwrap();
        assert_eq!(finger.joint_rad(&closed.configuration, 2), Some(0.0));
        let gear = finger.transmission.factors(&free.configuration).unwrap();
        assert!((held_nm - PRELOAD_NM - 0.01 * (gear.x[1] - share)).abs() < 1e-7);
        // Elsewhere the springs hold the input link, and a weight cannot be told from them.
        let sprung = Tendon2::MECHANISM;
        let free = sprung.free_at_angle(1.3, &sprung.rest()).unwrap();
        assert!(sprung.weighed(&free, 0.01, 0.0).is_none());
    }
}
