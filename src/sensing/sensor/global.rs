//! K_a against K_a' (7): the global stiffness that a closing ends with.

use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::Event;
use crate::sensing::detector;
use crate::sensing::location::SeriesElement;

/// K_a (7), measured and expected without contact, newton metre per radian.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlobalStiffness {
    nm_per_rad: f32,
    sigma_nm_per_rad: f32,
    free_nm_per_rad: f32,
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// Ends a closing and reports the global stiffness from rest to its last block; `free` means without a contact. If it lies
    /// below that of a free finger by more than the uncertainty of friction, something pushes on the back or a spring has lost
    /// its hold (Fig. 8).
    pub(super) fn conclude_closing(&mut self, free: bool) {
        let Some((theta_a_rad, residual_nm)) = self.last_residual.take() else {
            return;
        };
        let Some(k_a) = self.k_a(theta_a_rad, residual_nm) else {
            return;
        };
        let blocks = self.settings.travel_rad
            / self.drivetrain.rad_per_count
            / self.drivetrain.counts_per_turn.max(1) as f32;
        let threshold = detector::threshold(self.settings.false_contacts_per_thousand, blocks);
        let below = (k_a.free_nm_per_rad - k_a.nm_per_rad) / k_a.sigma_nm_per_rad;
        if free && below > 0.0 && below * below > 2.0 * threshold {
            self.emit_unusual(&k_a);
        }
        self.emit(Event::Stiffness {
            k_a_nm_per_rad: k_a.nm_per_rad,
            k_a_sigma_nm_per_rad: k_a.sigma_nm_per_rad,
            k_a_free_nm_per_rad: k_a.free_nm_per_rad,
        });
    }

    pub(super) fn emit_unusual(&mut self, k_a: &GlobalStiffness) {
        self.emit(Event::Unusual {
            k_a_nm_per_rad: k_a.nm_per_rad,
            k_a_sigma_nm_per_rad: k_a.sigma_nm_per_rad,
            k_a_free_nm_per_rad: k_a.free_nm_per_rad,
        });
    }

    /// K_a (7) at an angle from the residual torque there. None at rest.
    pub(super) fn k_a(&self, theta_a_rad: f32, residual_nm: f32) -> Option<GlobalStiffness> {
        let rest_rad = self.finger.input_angle_rad(&self.finger.rest());
        let free_nm_per_rad = self
            .free(theta_a_rad)
            .and_then(|free| self.finger.expected_k_a(&free))
            .unwrap_or(0.0);
        let wander = self
            .friction
            .as_ref()?
            .wander(self.settings.speed_rad_per_s);
        let friction_nm =
            sqrt(wander.rms_nm * wander.rms_nm + wander.level_sigma_nm * wander.level_sigma_nm);
        // From the motor's torque to the springs'.
        let share = self.drivetrain.efficiency * self.calibration.torque_factor;
        let per_rad = share / (theta_a_rad - rest_rad);
        let found = GlobalStiffness {
            nm_per_rad: free_nm_per_rad + per_rad * residual_nm,
            sigma_nm_per_rad: per_rad.abs() * friction_nm,
            free_nm_per_rad,
        };
        (found.nm_per_rad + found.sigma_nm_per_rad)
            .is_finite()
            .then_some(found)
    }
}
