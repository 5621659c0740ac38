//! The finger and drivetrain of the paper's prototype, which the examples use: put the numbers of yours here.

use palpate::finger::{
    Assembly, ConfigError, Finger, Levers, Linkage, Mechanics, Parameters, Springless,
};
use palpate::sensing::{Calibration, Drivetrain};

/// Two phalanges and a linkage.
pub type Prototype = Finger<2, Linkage<1>, Springless>;

/// The finger.
///
/// # Errors
/// A value out of its range, or a linkage that does not close.
pub fn finger() -> Result<Prototype, ConfigError> {
    Prototype::constant(
        Parameters {
            lengths_m: [0.090, 0.070],
            stiffness_nm_per_rad: [0.0, 0.05],
            rest_rad: [0.0, 0.0],
            range_rad: [[-0.5, 2.6], [0.0, 2.0]],
        },
        [Levers {
            driving_m: 0.060,
            coupler_m: 0.104,
            driven_m: 0.030,
            offset_rad: 120.0_f32.to_radians(),
            assembly: Assembly::Clockwise,
        }],
    )
}

/// Nothing was calibrated: the torque factor is known to 12 %, the cable (1.2 N m/rad) to 30 %.
pub const UNCALIBRATED: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.115,
    cable_rad_per_nm: 1.0 / 1.2,
    cable_sigma_rad_per_nm: 0.25,
    correlation: 0.0,
    stiffening_per_nm: 0.0,
    stiffening_sigma_per_nm: 0.2,
    joint_nm: 0.0,
    joint_sigma_nm: 0.0,
    joint_correlation: 0.0,
    worm_rad: [0.0; 2],
    contacts: 0,
    presses: 0,
};

/// A motor of 8.9 mN m/A with 1024 counts a turn behind a gearhead of 64:1 and a worm of 20:1.
pub fn drivetrain(finger: &Prototype) -> Drivetrain {
    let reduction = 64.0 * 20.0;
    let rad_per_count = core::f32::consts::TAU / (1024.0 * reduction);
    Drivetrain {
        torque_constant_sigma: 0.058,
        resistance_ohm: 39.0,
        rad_per_count,
        counts_per_turn: 1024,
        counts_per_worm_turn: 64 * 1024,
        creep: 0.05,
        creep_s: 5.0,
        opening_stop_rad: finger.input_angle_rad(&finger.rest()),
        torque_per_ampere_nm: 8.9e-3 * reduction,
        efficiency: 0.33,
        inertia_kg_m2: 1e-8 * reduction * reduction,
        inertia_sigma: 0.115,
        viscous_nm_s_per_rad: 2.3e-8 * reduction * reduction,
        efficiency_per_speed: 0.07,
        weight_share: 0.36,
        backlash_rad: 1456.0 * rad_per_count,
    }
}
