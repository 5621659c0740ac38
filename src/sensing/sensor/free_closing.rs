//! What the record of a free closing tells of the torque factor of a finger with springs (docs/SENSING.md#what-a-free-closing-tells).

use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::location::SeriesElement;

/// Standard deviation of the change of friction from the first to the last third of a closing, as a share of the friction (R, chosen):
/// nearly twice what the recordings of another engine show, whose change has an rms of 4.5 % and is 6.7 % at most.
const UNEVEN_SHARE: f32 = 0.08;

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// Torque factor, and its standard deviation as a share of it: rise of the free finger's torque from the first to the last third of the
    /// record, over the rise that the motor had to give there. The springs' rise is the finger's own; friction hardly differs between the
    /// two. `None` once a pin has told the factor, for a finger whose weight, which would rise and fall with the springs, is not stated,
    /// for one whose cable nothing has told, without a record, and where nothing rises.
    // Not inlined: rarely called, and solves for two postures.
    #[inline(never)]
    pub(super) fn closing_factor(&self) -> Option<[f32; 2]> {
        let is_cable_told = !X::FLEXIBLE || self.calibration.presses > 0;
        if !F::WEIGHS || !is_cable_told || self.calibration.contacts > 0 {
            return None;
        }
        let friction = self.friction.as_ref()?;
        let shift_counts = self.shift_counts?;
        let [(from_counts, from_nm), (to_counts, to_nm)] = friction.thirds()?;
        let free_nm = |counts: f32| {
            let counts = (counts as i32).wrapping_sub(shift_counts);
            self.free(self.drivetrain.closing_rad(counts))
                .map(|free| free.torque_nm)
        };
        let rise_nm = free_nm(to_counts)? - free_nm(from_counts)?;
        let taken_nm = self.drivetrain.efficiency * (to_nm - from_nm);
        let wander_nm = friction.wander(self.settings.speed_rad_per_s).rms_nm;
        // The springs help the motor to open as much as they hinder it to close.
        let uneven_nm = UNEVEN_SHARE * 0.5 * (friction.mean_nm()? - friction.opening_nm);
        let noise_nm =
            self.drivetrain.efficiency * sqrt(uneven_nm * uneven_nm + 2.0 * wander_nm * wander_nm);
        // Count the whole uncertainty of the losses on the way to the joints, although they act on a part of the rise.
        let [_, loss_sigma] = F::JOINT_LOSS;
        let lost_nm = loss_sigma * rise_nm;
        let sigma_nm = sqrt(noise_nm * noise_nm + lost_nm * lost_nm);
        let told = [rise_nm / taken_nm, sigma_nm / taken_nm];
        (rise_nm > 0.0 && taken_nm > 0.0 && told.iter().all(|value| value.is_finite()))
            .then_some(told)
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::UNEVEN_SHARE;
    use crate::finger::Mechanics;
    use crate::scene::{P70, Scene, Tendon2};
    use crate::sensing::friction::{BINS, Friction};
    use crate::sensing::{Calibration, Sensor};

    const FRICTION_NM: f32 = 0.17;

    /// What a record tells, of a finger on gears with a torque factor, whose friction grows by a share of itself from the first to the
    /// last third of the closing.
    fn told<S: Scene>(factor: f32, grown: f32) -> Option<[f32; 2]> {
        told_after::<S>(factor, grown, FRICTION_NM, [1, 0])
    }

    /// The same with this much friction, after so many presses and pins.
    fn told_after<S: Scene>(
        factor: f32,
        grown: f32,
        friction_nm: f32,
        [presses, contacts]: [u16; 2],
    ) -> Option<[f32; 2]> {
        let finger = S::MECHANISM;
        let drivetrain = S::drivetrain(&finger);
        let calibration = Calibration {
            presses,
            contacts,
            ..S::UNCALIBRATED
        };
        let mut sensor: Sensor<S::Finger> =
            Sensor::new(finger, drivetrain, S::settings(), calibration);
        let state = &mut sensor.state;
        let mut record = Friction::empty(state.travel_counts(), &drivetrain);
        let bins = (state.travel_counts() / record.bin_counts as i32) as usize;
        for index in 8..bins.min(BINS) {
            let counts = ((index as f32 + 0.5) * record.bin_counts as f32) as i32;
            let free = state.free(drivetrain.closing_rad(counts)).unwrap();
            let rubs_nm = friction_nm * (1.0 + 1.5 * grown * index as f32 / bins as f32);
            record.closing_nm.mean[index] =
                rubs_nm + free.torque_nm / (drivetrain.efficiency * factor);
            record.closing_nm.count[index] = 1;
        }
        // The springs help.
        record.opening_nm = record.mean_nm().unwrap() - 2.0 * friction_nm;
        record.speed_rad_per_s = 0.3;
        state.friction = Some(record);
        state.closing_factor()
    }

    #[test]
    fn the_springs_rise_tells_the_factor() {
        for factor in [0.7, 1.0, 1.3] {
            let [found, sigma] = told::<Tendon2>(factor, 0.0).unwrap();
            assert!((found / factor - 1.0).abs() < 5e-3, "{factor}: {found}");
            assert!((0.03..0.15).contains(&sigma), "{sigma}");
        }
    }

    #[test]
    fn friction_that_changes_on_the_way_is_within_the_deviation() {
        for grown in [-UNEVEN_SHARE, UNEVEN_SHARE] {
            let [found, sigma] = told::<Tendon2>(1.0, grown).unwrap();
            let error = found.ln().abs();
            assert!(
                (0.3 * sigma..1.3 * sigma).contains(&error),
                "{grown}: {found} +- {sigma}"
            );
        }
    }

    /// Nothing rubs, but its pulleys may.
    #[test]
    fn a_rise_without_friction_is_no_better_known_than_the_losses() {
        let [_, loss_sigma] = <Tendon2 as Scene>::Finger::JOINT_LOSS;
        let [_, sigma] = told_after::<Tendon2>(1.0, 0.0, 0.0, [1, 0]).unwrap();
        assert!(
            (0.9 * loss_sigma..2.0 * loss_sigma).contains(&sigma),
            "{sigma}"
        );
    }

    #[test]
    fn a_finger_without_springs_or_with_an_unknown_cable_is_told_nothing() {
        const { assert!(!<P70 as Scene>::Finger::WEIGHS) }
        assert_eq!(told::<P70>(1.0, 0.0), None);
        assert_eq!(told_after::<Tendon2>(1.0, 0.0, FRICTION_NM, [0, 0]), None);
        // Pins know better.
        assert_eq!(told_after::<Tendon2>(1.0, 0.0, FRICTION_NM, [1, 1]), None);
        // Torque falls where springs would have to rise.
        assert_eq!(told::<Tendon2>(1.0, -4.0), None);
    }
}
