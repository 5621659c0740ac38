//! `p70-rigid`: the same finger without a cable needs no press, fits two numbers less, and has smaller deviations. Simulated.

use palpate::app::console::command::{Calibrate, Command};
use palpate::drive::sequence::Refused;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Shape};
use palpate_scenes::{P70Grasp, P70Rigid};
use palpate_simulation::{Simulated, Simulation, Verdict};

/// Error and deviation of a contact at every place, millimetre, with nothing calibrated and no press.
fn uncalibrated<S: Simulated>() -> Vec<(f64, f64)> {
    let mut simulation = Simulation::<S>::new(&S::parameters().unwrap(), 1).unwrap();
    simulation.prepare().unwrap();
    let forget = Command::Calibrate(Calibrate::Forget);
    simulation.slow().coordinator.command(forget).unwrap();
    simulation.idle(0.01);
    assert_eq!(simulation.calibration().presses, 0);
    let cylinder = Shape::Cylinder { diameter_m: 0.01 };
    [0.015, 0.03, 0.045, 0.06]
        .map(|k_m| {
            let mut simulation = simulation.clone();
            let outcome = simulation
                .close(&Grasp::touching(2, k_m, 0.8, cylinder.clone()))
                .unwrap();
            let Verdict::Located { sigma_m, .. } = outcome.verdict else {
                panic!("{k_m} m: {:?}", outcome.verdict);
            };
            let error_m = outcome.error_m().expect("on phalanx 2");
            println!("{k_m}: {:.2} +- {:.2} mm", 1e3 * error_m, 1e3 * sigma_m);
            (1e3 * error_m, 1e3 * sigma_m)
        })
        .to_vec()
}

#[test]
fn contacts_are_placed_without_a_cable_and_surer() {
    let (with, without) = (uncalibrated::<P70Grasp>(), uncalibrated::<P70Rigid>());
    for (error_mm, sigma_mm) in &without {
        assert!(error_mm.abs() < 0.05 * 70.0, "{error_mm}");
        assert!(error_mm.abs() < 3.0 * sigma_mm, "{error_mm} {sigma_mm}");
    }
    let mean = |of: &[(f64, f64)]| of.iter().map(|(_, s)| s).sum::<f64>() / of.len() as f64;
    assert!(mean(&without) < mean(&with), "{with:?} {without:?}");
}

#[test]
fn there_is_no_cable_to_calibrate_and_a_pin_teaches_the_torque_factor_alone() {
    let mut simulation = Simulation::<P70Rigid>::new(&P70Rigid::parameters().unwrap(), 1).unwrap();
    simulation.prepare().unwrap();
    let press = Command::Calibrate(Calibrate::Cable);
    assert_eq!(
        simulation.slow().coordinator.command(press).err(),
        Some(Refused::NoCable)
    );
    let before = *simulation.calibration();
    let learned = simulation.calibrate(2, 0.021, 0.8).unwrap();
    assert!(
        matches!(learned.events.last(), Some((_, Event::Calibrated { .. }))),
        "{:?}",
        learned.events
    );
    let after = simulation.calibration();
    assert!(after.torque_factor_sigma < 0.5 * before.torque_factor_sigma);
    assert_eq!(
        (after.cable_rad_per_nm, after.cable_sigma_rad_per_nm),
        (0.0, 0.0)
    );
}
