//! What `identify` says of each quantity: beside the data sheet's value, in the units of data sheets; and what is used of it.
//!
//! The values that are used replace those of the scene when the firmware starts: loops and protection take them with the drive's
//! configuration, the sensing with its torque factor before calibration.

use crate::drive::config::{CheckedConfig, OutOfRange};
use crate::drive::identify::{Identified, Quantity};
use crate::drive::io::DEAD_TIME_S;
use crate::numeric::{Bounded, sqrt};
use crate::scene::Scene;
use crate::sensing::Calibration;

/// Least deviation of a torque factor that no contact has calibrated, as a share of it.
const LEAST_SIGMA: f32 = 0.03;

/// A quantity as it is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Name in the log.
    pub name: &'static str,
    /// Unit of what follows.
    pub unit: &'static str,
    /// Measured value.
    pub value: f32,
    /// Its standard deviation.
    pub sigma: f32,
    /// Value of the scene.
    pub datasheet: f32,
    /// The measured value lies in the range that a motor of this data sheet may have: it is used.
    pub plausible: bool,
}

impl Report {
    /// Of a quantity in a scene.
    // Not inlined: it is called for the log and for each value that is used.
    #[inline(never)]
    pub fn of<S: Scene>(quantity: Quantity, identified: &Identified) -> Self {
        let motor = &S::DRIVE.motor;
        // Range: as multiples of the data sheet's value.
        let (name, unit, per_si, datasheet, range) = match quantity {
            Quantity::Resistance => ("resistance", "ohm", 1.0, motor.circuit_ohm(), (0.6, 1.6)),
            Quantity::TorqueConstant => (
                "torque-constant",
                "mNm/A",
                1e3,
                motor.torque_constant_nm_per_a,
                (0.75, 1.3),
            ),
            Quantity::Inertia => (
                "inertia",
                "gcm2",
                1e7,
                motor.rotor_inertia_kg_m2,
                (0.5, 2.0),
            ),
            Quantity::Friction => ("friction", "mNm", 1e3, S::FRICTION_NM, (0.2, 5.0)),
            Quantity::DeadTime => ("dead-time", "us", 1e6, DEAD_TIME_S, (-0.5, 5.0)),
        };
        let estimate = identified.of(quantity);
        let share = estimate.value / datasheet;
        Self {
            name,
            unit,
            value: per_si * estimate.value,
            sigma: per_si * estimate.sigma,
            datasheet: per_si * datasheet,
            plausible: share >= range.0 && share <= range.1,
        }
    }

    /// Deviation from the data sheet, percent.
    pub fn deviation_percent(&self) -> f32 {
        100.0 * (self.value / self.datasheet - 1.0)
    }

    /// Verdict in the log.
    pub fn result(&self) -> &'static str {
        if self.plausible { "ok" } else { "implausible" }
    }
}

/// A value that is used: the measured one where it is plausible, else the scene's.
fn used<S: Scene>(quantity: Quantity, identified: &Identified, datasheet: f32) -> f32 {
    if Report::of::<S>(quantity, identified).plausible {
        identified.of(quantity).value
    } else {
        datasheet
    }
}

/// The drive with the motor as it was measured.
///
/// # Errors
/// A value that the drive's arithmetic cannot use.
pub fn drive<S: Scene>(
    drive: CheckedConfig,
    identified: &Identified,
) -> Result<CheckedConfig, OutOfRange> {
    let mut motor = S::DRIVE.motor;
    // What was measured is winding and choke; the choke hardly warms.
    motor.resistance_ohm =
        used::<S>(Quantity::Resistance, identified, motor.circuit_ohm()) - motor.choke_ohm;
    for (quantity, value) in [
        (
            Quantity::TorqueConstant,
            &mut motor.torque_constant_nm_per_a,
        ),
        (Quantity::Inertia, &mut motor.rotor_inertia_kg_m2),
    ] {
        *value = used::<S>(quantity, identified, *value);
    }
    drive.with_motor(motor)
}

/// What the sensing may assume before a contact has calibrated it: the torque factor has the measured torque constant in it, and
/// its deviation no longer that constant's tolerance; and that tolerance, 0 then.
pub fn uncalibrated<S: Scene>(identified: &Identified) -> (Calibration, f32) {
    let mut calibration = S::UNCALIBRATED;
    let tolerance = S::DRIVETRAIN.torque_constant_sigma;
    let constant = Report::of::<S>(Quantity::TorqueConstant, identified);
    if !constant.plausible {
        return (calibration, tolerance);
    }
    let share = constant.sigma / constant.value;
    let sigma = calibration.torque_factor_sigma;
    calibration.torque_factor *= constant.value / constant.datasheet;
    calibration.torque_factor_sigma = sqrt(
        (sigma * sigma - tolerance * tolerance + share * share).at_least(LEAST_SIGMA * LEAST_SIGMA),
    )
    .at_most(sigma);
    (calibration, 0.0)
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::*;
    use crate::drive::identify::Estimate;
    use crate::scene::P70;

    fn identified(share: f32) -> Identified {
        let mut identified = Identified::default();
        for (quantity, estimate) in Quantity::ALL.into_iter().zip(&mut identified.estimates) {
            let nominal = Report::of::<P70>(quantity, &Identified::default());
            let si = match quantity {
                Quantity::Resistance => 1.0,
                Quantity::TorqueConstant | Quantity::Friction => 1e-3,
                Quantity::Inertia => 1e-7,
                Quantity::DeadTime => 1e-6,
            };
            *estimate = Estimate {
                value: share * si * nominal.datasheet,
                sigma: 0.01 * si * nominal.datasheet,
            };
        }
        identified
    }

    #[test]
    fn a_measured_motor_replaces_the_data_sheet_s() {
        let measured = identified(1.2);
        for quantity in Quantity::ALL {
            let report = Report::of::<P70>(quantity, &measured);
            assert!(
                (report.deviation_percent() - 20.0).abs() < 0.01,
                "{report:?}"
            );
            assert_eq!(report.result(), "ok");
        }
        let drive = drive::<P70>(P70::CHECKED, &measured).expect("in range");
        let (motor, nominal) = (drive.config().motor, P70::DRIVE.motor);
        assert!((motor.circuit_ohm() / nominal.circuit_ohm() - 1.2).abs() < 1e-5);
        assert_eq!(motor.choke_ohm, nominal.choke_ohm);
        assert!((motor.rotor_inertia_kg_m2 / nominal.rotor_inertia_kg_m2 - 1.2).abs() < 1e-5);
        let emf = |drive: &CheckedConfig| drive.scale().emf_v_per_count_per_period();
        assert!((emf(&drive) / emf(&P70::CHECKED) - 1.2).abs() < 1e-5);
        assert_eq!(motor.thermal, nominal.thermal);
    }

    #[test]
    fn the_torque_factor_knows_the_constant_and_is_surer() {
        let (prior, tolerance) = uncalibrated::<P70>(&identified(1.2));
        assert_eq!(tolerance, 0.0);
        assert!((prior.torque_factor - 1.2).abs() < 1e-5);
        assert!(prior.is_valid());
        let sigma = P70::UNCALIBRATED.torque_factor_sigma;
        assert!((0.09..sigma).contains(&prior.torque_factor_sigma));
    }

    #[test]
    fn what_no_such_motor_can_be_is_not_used() {
        for share in [0.1, 10.0, f32::NAN] {
            let measured = identified(share);
            assert_eq!(drive::<P70>(P70::CHECKED, &measured), Ok(P70::CHECKED));
            assert_eq!(
                uncalibrated::<P70>(&measured),
                (P70::UNCALIBRATED, P70::DRIVETRAIN.torque_constant_sigma)
            );
            let report = Report::of::<P70>(Quantity::Resistance, &measured);
            assert_eq!(report.result(), "implausible");
        }
    }
}
