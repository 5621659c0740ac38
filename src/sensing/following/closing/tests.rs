//! What a corner is measured with.

use super::*;

/// What was measured behind a corner that a straight line waits with is none of another corner, which the end of the motion shows.
#[test]
fn a_corner_that_the_end_shows_has_no_slope_of_another() {
    let noise = BlockNoise {
        white_nm2: 1e-8,
        walk_nm2: 0.0,
        worm_turn_rad: 0.3,
        worm_error_rad: 0.0,
    };
    for corner_rad in [0.38, f32::INFINITY] {
        let mut search = SecondContact::default();
        search.begin(0.0, 0.0, 0.01);
        for block in 0..80 {
            let theta_a_rad = 0.005 * block as f32;
            let torque_nm = 0.2 * theta_a_rad + (theta_a_rad - corner_rad).at_least(0.0);
            let told = search.push(theta_a_rad, torque_nm, &noise, true);
            assert_eq!(told, None, "not while it is still getting better");
        }
        let later = Later {
            theta_a_rad: 0.37,
            torque_nm: 0.07,
            slope_nm_per_rad: 0.2,
            sigma_nm_per_rad: 0.01,
        };
        let mut closing = Closing::<(), ()>::new(0.0, 0.0, 0.1);
        closing.later = Some(later);
        closing.end(&mut search);
        let ends_in_corner = corner_rad.is_finite();
        assert!(closing.is_over && closing.change.is_some() == ends_in_corner);
        assert_eq!(closing.later, (!ends_in_corner).then_some(later));
    }
}

/// How far the finger has turned is asked without the twist of a cable, which turns the motor alone.
#[cfg(feature = "firmware")]
#[test]
fn the_cable_s_twist_is_no_rotation() {
    use crate::scene::{Scene, Tendon3};
    use crate::sensing::Calibration;
    type Finger = <Tendon3 as Scene>::Finger;
    let finger = Tendon3::MECHANISM;
    let drivetrain = Tendon3::drivetrain(&finger);
    let turned_rad = |cable_rad_per_nm, torque_nm| {
        let calibration = Calibration {
            cable_rad_per_nm,
            stiffening_per_nm: 0.0,
            ..Tendon3::UNCALIBRATED
        };
        let settings = Tendon3::settings();
        let sensor: Sensor<Finger> = Sensor::new(finger, drivetrain, settings, calibration);
        let onset_rad = drivetrain.closing_rad(0) + 0.6;
        let free_nm = sensor.free_at(onset_rad).expect("a posture").torque_nm;
        let change = SlopeChange {
            theta_a_rad: onset_rad + 0.3,
            torque_nm: free_nm + torque_nm,
            before_nm_per_rad: 0.2,
            after_nm_per_rad: 0.6,
            after_sigma_nm_per_rad: 0.05,
            spacing_rad: 0.005,
        };
        let first = Contact {
            phalanx: 2,
            k_m: 0.03,
            radius_m: 0.014,
        };
        let closing = Closing::<_, <Finger as HoldsTwice>::Weighing>::new(onset_rad, 0.0, 0.1);
        let measured = closing.measured(&sensor, &change, First::At(first, 1e-3));
        measured.asked.expect("a first contact").2.rotation_rad
    };
    for torque_nm in [0.05, 0.1, 0.2] {
        for cable in [0.0, 0.4, 0.8] {
            let off_rad = turned_rad(cable, torque_nm) - (0.3 - cable * torque_nm);
            assert!(off_rad.abs() < 1e-4, "{cable} {torque_nm}: {off_rad}");
        }
    }
}
