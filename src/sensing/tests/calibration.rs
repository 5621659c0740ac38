use crate::sensing::{Calibration, Refusal};

const START: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.1,
    cable_rad_per_nm: 0.8,
    cable_sigma_rad_per_nm: 0.3,
    correlation: 0.0,
    stiffening_per_nm: 0.0,
    stiffening_sigma_per_nm: 0.3,
    joint_nm: 0.0,
    joint_sigma_nm: 0.0,
    joint_correlation: 0.0,
    worm_rad: [0.0; 2],
    contacts: 0,
    presses: 0,
};

#[test]
fn a_press_is_taken_as_it_was_fitted_and_counted_apart() {
    let found = Calibration {
        cable_rad_per_nm: 0.95,
        cable_sigma_rad_per_nm: 0.01,
        ..START
    };
    let after = START.with_press(&found, 0.8).unwrap();
    assert_eq!(
        (after.cable_rad_per_nm, after.cable_sigma_rad_per_nm),
        (0.95, 0.01)
    );
    assert_eq!((after.torque_factor, after.torque_factor_sigma), (1.0, 0.1));
    assert_eq!((after.presses, after.contacts), (1, 0));
}

#[test]
fn how_much_the_cable_stiffens_is_learned_from_a_press_alone() {
    let found = Calibration {
        torque_factor_sigma: 0.02,
        cable_sigma_rad_per_nm: 0.01,
        stiffening_per_nm: 0.4,
        stiffening_sigma_per_nm: 0.1,
        ..START
    };
    let stiffening = |c: &Calibration| (c.stiffening_per_nm, c.stiffening_sigma_per_nm);
    let pressed = START.with_press(&found, 4.0).unwrap();
    assert_eq!(stiffening(&pressed), (0.4, 0.2));
    let touched = START.with_contact(&found, 1.0, 1.0).unwrap();
    assert_eq!(stiffening(&touched), (0.0, 0.3));
}

#[test]
fn what_cannot_be_or_tells_nothing_is_refused() {
    let cable = |cable_rad_per_nm, cable_sigma_rad_per_nm| Calibration {
        cable_rad_per_nm,
        cable_sigma_rad_per_nm,
        ..START
    };
    let far = cable(3.0, 0.1);
    assert_eq!(START.with_press(&far, 1.0), Err(Refusal::Implausible));
    for bad in [cable(f32::NAN, 0.1), cable(0.8, f32::NAN), cable(-0.1, 0.1)] {
        assert_eq!(START.with_press(&bad, 1.0), Err(Refusal::Misfit), "{bad:?}");
    }
    assert_eq!(START.with_press(&START, 1.0), Err(Refusal::Uninformative));

    let found = Calibration {
        torque_factor: 1.08,
        torque_factor_sigma: 0.02,
        ..START
    };
    let after = START.with_contact(&found, 1.0, 1.0).unwrap();
    assert_eq!((after.torque_factor, after.contacts), (1.08, 1));
    // What the fit left unexplained makes it less sure, but never less than before.
    let unsure = START.with_contact(&found, 4.0, 1.0).unwrap();
    assert!((unsure.torque_factor_sigma - 0.04).abs() < 1e-6);
    assert_eq!(START.with_contact(&found, 5.0, 1.0), Err(Refusal::Misfit));
    assert_eq!(
        START.with_contact(&found, f32::NAN, 1.0),
        Err(Refusal::Misfit)
    );
    assert_eq!(
        START.with_contact(&START, 1.0, 1.0),
        Err(Refusal::Uninformative)
    );
    let far = Calibration {
        torque_factor: 1.6,
        ..found
    };
    assert_eq!(
        START.with_contact(&far, 1.0, 1.0),
        Err(Refusal::Implausible)
    );
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
            |c: &mut Calibration, v| c.stiffening_per_nm = v,
            |c: &mut Calibration, v| c.stiffening_sigma_per_nm = v,
        ] {
            let mut calibration = START;
            change(&mut calibration, bad);
            assert!(!calibration.is_valid(), "{calibration:?}");
        }
    }
}

#[test]
fn elsewhere_the_factor_is_less_sure_and_the_cable_is_not() {
    let here = Calibration {
        torque_factor: 0.9,
        torque_factor_sigma: 0.03,
        cable_rad_per_nm: 0.3,
        cable_sigma_rad_per_nm: 0.02,
        correlation: 0.8,
        stiffening_per_nm: 0.2,
        stiffening_sigma_per_nm: 0.1,
        joint_nm: 0.0,
        joint_sigma_nm: 0.0,
        joint_correlation: 0.0,
        worm_rad: [0.0; 2],
        contacts: 1,
        presses: 1,
    };
    let mut there = here;
    there.widen(0.04);
    assert!((there.torque_factor_sigma - 0.05).abs() < 1e-6);
    // The covariance stays, and with it what the cable does with the part that was learned together with it.
    let covariance =
        |of: &Calibration| of.correlation * of.torque_factor_sigma * of.cable_sigma_rad_per_nm;
    assert!((covariance(&there) - covariance(&here)).abs() < 1e-9);
    let same = Calibration {
        torque_factor_sigma: here.torque_factor_sigma,
        correlation: here.correlation,
        ..there
    };
    assert_eq!(same, here);
    let mut same = here;
    same.widen(0.0);
    assert_eq!(same, here);
}

#[test]
fn at_another_speed_what_was_told_is_less_sure_and_nothing_else_is() {
    let mut told = Calibration {
        torque_factor: 0.9,
        torque_factor_sigma: 0.02,
        cable_rad_per_nm: 0.8,
        cable_sigma_rad_per_nm: 0.03,
        correlation: -0.6,
        contacts: 2,
        presses: 1,
        ..START
    };
    let before = told;
    told.change_speed(0.0);
    assert_eq!(told, before);
    // Ten percent more efficient, with a deviation of seven.
    told.change_speed(0.1);
    let more = told.torque_factor / before.torque_factor;
    assert!(
        (more - 1.105).abs() < 1e-3 && (told.cable_rad_per_nm - 0.8 * more).abs() < 1e-6,
        "{told:?}"
    );
    assert!((told.torque_factor_sigma - 0.09).abs() < 1e-6, "{told:?}");
    assert!(
        told.cable_sigma_rad_per_nm > 0.06 && told.is_valid(),
        "{told:?}"
    );
    // Back at the old speed all is as it was, but less sure.
    let mut back = told;
    back.change_speed(-0.1);
    assert!(
        (back.torque_factor - before.torque_factor).abs() < 1e-6
            && (back.cable_rad_per_nm - before.cable_rad_per_nm).abs() < 1e-6,
        "{back:?}"
    );
    // Deviations along the change, both alike, cover it.
    let [f, c] = [
        told.torque_factor_sigma,
        told.cable_sigma_rad_per_nm / told.cable_rad_per_nm,
    ];
    let alike = f * f + c * c + 2.0 * told.correlation * f * c;
    assert!(alike > 2.0 * 0.07 * 0.07, "{alike}");
    // What is only assumed is assumed for every speed.
    let mut assumed = START;
    assumed.change_speed(0.1);
    assert_eq!(assumed, START);
    // So is a torque factor that no pin has told; the cable of a press was measured at this speed.
    let pressed = Calibration {
        contacts: 0,
        ..before
    };
    let mut faster = pressed;
    faster.change_speed(0.1);
    assert_eq!(faster.torque_factor, pressed.torque_factor);
    assert_eq!(faster.torque_factor_sigma, pressed.torque_factor_sigma);
    assert_eq!(faster.cable_rad_per_nm, told.cable_rad_per_nm);
    assert_eq!(faster.cable_sigma_rad_per_nm, told.cable_sigma_rad_per_nm);
}

#[test]
fn a_free_closing_corrects_a_factor_that_no_pin_has_told() {
    let corrected = |start: Calibration, told| {
        let mut calibration = start;
        calibration.correct_factor(told);
        (calibration.torque_factor, calibration.torque_factor_sigma)
    };
    // As sure as the prior: half way, and surer by the root of two.
    let (factor, sigma) = corrected(START, [1.1, 0.1]);
    assert!((factor - 1.05).abs() < 1e-6 && (sigma - 0.1 / 2f32.sqrt()).abs() < 1e-6);
    // Nobody would expect that.
    assert_eq!(corrected(START, [2.0, 0.1]), (1.0, 0.1));
    assert_eq!(corrected(START, [f32::NAN, 0.1]), (1.0, 0.1));
    let pinned = Calibration {
        contacts: 1,
        ..START
    };
    assert_eq!(corrected(pinned, [1.1, 0.1]), (1.0, 0.1));
}
