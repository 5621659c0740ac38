use crate::sensing::{Calibration, Refusal};

const START: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.1,
    cable_rad_per_nm: 0.8,
    cable_sigma_rad_per_nm: 0.3,
    correlation: 0.0,
    contacts: 0,
    presses: 0,
};

#[test]
fn a_press_and_what_is_known_are_weighed_by_their_variances() {
    let after = START.with_press(1.1, 0.3).unwrap();
    assert!((after.cable_rad_per_nm - 0.95).abs() < 1e-6);
    assert!((after.cable_sigma_rad_per_nm - 0.3 / 2f32.sqrt()).abs() < 1e-6);
    assert_eq!((after.torque_factor, after.torque_factor_sigma), (1.0, 0.1));
    assert_eq!((after.presses, after.contacts), (1, 0));
}

#[test]
fn a_press_moves_the_factor_too_where_the_two_are_correlated() {
    let before = Calibration {
        correlation: 0.8,
        ..START
    };
    // A perfect measurement: what is left of the factor is its part that does not go with the cable.
    let after = before.with_press(1.1, 1e-4).unwrap();
    assert!((after.cable_rad_per_nm - 1.1).abs() < 1e-4);
    assert!(
        (after.torque_factor - (1.0 + 0.8 * 0.1)).abs() < 1e-3,
        "{after:?}"
    );
    assert!((after.torque_factor_sigma - 0.06).abs() < 1e-3);
    assert!(after.correlation.abs() < 1e-2);
}

#[test]
fn what_cannot_be_or_tells_nothing_is_refused() {
    assert_eq!(START.with_press(3.0, 0.1), Err(Refusal::Implausible));
    for (slope, sigma) in [
        (f32::NAN, 0.1),
        (0.8, f32::NAN),
        (-0.1, 0.1),
        (0.8, 0.0),
        (0.8, f32::INFINITY),
    ] {
        assert_eq!(
            START.with_press(slope, sigma),
            Err(Refusal::Misfit),
            "{slope} {sigma}"
        );
    }
    assert_eq!(START.with_press(0.8, 5.0), Err(Refusal::Uninformative));

    let found = Calibration {
        torque_factor: 1.08,
        torque_factor_sigma: 0.02,
        ..START
    };
    let after = START.with_contact(&found, 1.0).unwrap();
    assert_eq!((after.torque_factor, after.contacts), (1.08, 1));
    // What the fit left unexplained makes it less sure, but never less than before.
    let unsure = START.with_contact(&found, 4.0).unwrap();
    assert!((unsure.torque_factor_sigma - 0.04).abs() < 1e-6);
    assert_eq!(START.with_contact(&found, 100.0), Err(Refusal::Misfit));
    assert_eq!(START.with_contact(&found, f32::NAN), Err(Refusal::Misfit));
    assert_eq!(START.with_contact(&START, 1.0), Err(Refusal::Uninformative));
    let far = Calibration {
        torque_factor: 1.6,
        ..found
    };
    assert_eq!(START.with_contact(&far, 1.0), Err(Refusal::Implausible));
}

#[test]
fn a_damaged_calibration_is_not_valid() {
    assert!(START.is_valid());
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        for change in [
            |c: &mut Calibration, v| c.torque_factor = v,
            |c: &mut Calibration, v| c.torque_factor_sigma = v,
            |c: &mut Calibration, v| c.cable_rad_per_nm = v,
            |c: &mut Calibration, v| c.cable_sigma_rad_per_nm = v,
        ] {
            let mut calibration = START;
            change(&mut calibration, bad);
            assert!(!calibration.is_valid(), "{calibration:?}");
        }
    }
}
