//! What all scenes share: a Maxon RE10 with its gears and cable, a DRV8876 on a NUCLEO-G431RB.
//!
//! Marks of the sources: V read in a primary source, V2 a secondary one, I computed or inferred, R from memory and
//! unverified. Measure what is marked R on your own finger, or let the calibration find it.

use core::f32::consts::TAU;

use crate::drive::config::{self, AnalogInputs, Config, Limits, Motor, Thermal};
use crate::drive::joint::AngleSensor;
use crate::drive::sequence::Motion;
use crate::sensing::{Calibration, Drivetrain};

/// 256 lines, four edges each (V).
const COUNTS_PER_MOTOR_REV: f32 = 1024.0;
/// Planetary gearhead 64:1, worm 20:1, pulleys 1:1 (V).
const REDUCTION: f32 = 64.0 * 20.0;
/// Torque constant of the 12 V winding (I).
const TORQUE_CONSTANT_NM_PER_A: f32 = 8.9e-3;
/// Rotor inertia, 0.10 g cm2 (R).
const ROTOR_INERTIA_KG_M2: f32 = 1.0e-8;
/// Gearhead 0.73 (I) times worm 0.45 running (I): nominal, the calibration finds the real one.
pub const EFFICIENCY: f32 = 0.33;
/// Viscous friction of the motor, 0.03 mNm at 12,500 rpm (I).
const VISCOUS_NM_S_PER_RAD: f32 = 2.3e-8;
/// From the worm's running friction 0.124 exp(-2.233 v^0.645) (V) at 0.3 rad/s of a wheel with 20 teeth of some 4 mm worm
/// radius and 4.5 degree of lead: friction 0.10, falling by 13 % of itself per unit of ln v, over 0.18 in the screw's
/// equation (I).
const EFFICIENCY_PER_SPEED: f32 = 0.07;
/// Gearhead 364 and worm 1092 counts at the wheel (I).
const BACKLASH_COUNTS: f32 = 364.0 + 1092.0;
/// Torque at the input link at which probing ends. With 120 mA, less some 15 mA of friction, the motor gives 0.4 N m.
pub const PROBE_TORQUE_NM: f32 = 0.35;

/// Motor, gears, board and limits.
pub const DRIVE: Config = Config {
    motor: Motor {
        torque_constant_nm_per_a: TORQUE_CONSTANT_NM_PER_A,
        // 12 V winding (I).
        resistance_ohm: 35.0,
        rotor_inertia_kg_m2: ROTOR_INERTIA_KG_M2,
        thermal: Thermal {
            // V2.
            limit_c: 85.0,
            ambient_c: 25.0,
            // Together 42 K/W (I); how they share it is R.
            winding_k_per_w: 12.0,
            housing_k_per_w: 30.0,
            // R.
            winding_s: 4.0,
            housing_s: 150.0,
        },
    },
    drivetrain: config::Gearing {
        counts_per_motor_rev: COUNTS_PER_MOTOR_REV,
        reduction: REDUCTION,
    },
    sense: AnalogInputs {
        reference_v: 3.3,
        // 1000 uA/A (V2) through 6.8 kohm.
        volt_per_a: 6.8,
        // 82 kohm above 18 kohm: 18.3 V full scale.
        supply_divider: 100.0 / 18.0,
    },
    limits: Limits {
        // The gearhead's continuous torque is 0.05-0.1 N m (R): raise this only when yours is known.
        current_a: 0.12,
        // Below the stall current of 347 mA (I), above what a running motor takes for an instant.
        current_trip_a: 0.25,
        duty: 0.95,
        // The motor without load makes 1.0 rad/s at the input link (V2): some voltage must be left for load.
        speed_rad_per_s: 0.8,
        acceleration_rad_per_s2: 10.0,
        // Pressing on the closing stop winds the cable up: 0.35 N m over 1.2 N m/rad beyond the longest travel.
        position_min_rad: -0.4,
        position_max_rad: 2.8,
        overtravel_rad: 0.15,
        supply_min_v: 9.0,
        supply_max_v: 15.0,
    },
};

/// A linear Hall sensor at joint 2 (chosen): 0.5 V at zero, 1 V/rad; what it reads beyond the joint's stops is a fault.
pub const ANGLE_SENSE: AngleSensor = AngleSensor {
    zero_v: 0.5,
    volt_per_rad: 1.0,
    min_rad: -0.4,
    max_rad: 2.2,
};

/// Speeds, currents and times for a finger whose free closing ends at `travel_rad`.
pub const fn motion(travel_rad: f32) -> Motion {
    Motion {
        // Fast enough that the softest contact is felt within 60 ms, slow enough that the torque rises over hundreds of
        // samples; one speed for recording, closing and probing because the worm's friction depends on speed.
        closing_rad_per_s: 0.3,
        opening_rad_per_s: 0.6,
        // Friction takes some 15 mA; three times that breaks away a worm that has settled under load.
        free_current_a: 0.06,
        homing_current_a: 0.06,
        probing_current_a: 0.12,
        probing_rad: 1.0,
        holding_current_a: 0.06,
        holding_s: 0.5,
        rest_rad: 0.03,
        travel_rad,
    }
}

/// What is assumed before a contact at a known place has been felt.
pub const UNCALIBRATED: Calibration = Calibration {
    torque_factor: 1.0,
    // Uniform spreads (docs/HARDWARE.md#drivetrain): torque constant 10 %, spring 10 %, gearhead 10 %, worm 9 %,
    // current sense 5 %.
    torque_factor_sigma: 0.115,
    // Nylon of 3 kN/m (V2, 1.5 to 10) on pulleys of 20 mm: 1.2 N m/rad.
    cable_rad_per_nm: 1.0 / 1.2,
    cable_sigma_rad_per_nm: 0.25,
    correlation: 0.0,
    contacts: 0,
    presses: 0,
};

/// The drivetrain as the sensing sees it; `opening_stop_rad` is the input link's angle there.
pub fn drivetrain(opening_stop_rad: f32) -> Drivetrain {
    let rad_per_count = TAU / (COUNTS_PER_MOTOR_REV * REDUCTION);
    Drivetrain {
        rad_per_count,
        counts_per_turn: COUNTS_PER_MOTOR_REV as u32,
        counts_per_worm_turn: (COUNTS_PER_MOTOR_REV * 64.0) as u32,
        // 5 % within 5 s (R); 3 to 7 % is as likely.
        creep: [0.05, 0.015],
        creep_s: 5.0,
        opening_stop_rad,
        torque_per_ampere_nm: REDUCTION * TORQUE_CONSTANT_NM_PER_A,
        efficiency: EFFICIENCY,
        inertia_kg_m2: ROTOR_INERTIA_KG_M2 * REDUCTION * REDUCTION,
        // +-20 % (R), uniform.
        inertia_share: 0.115,
        viscous_nm_s_per_rad: VISCOUS_NM_S_PER_RAD * REDUCTION * REDUCTION,
        efficiency_per_speed: EFFICIENCY_PER_SPEED,
        backlash_rad: BACKLASH_COUNTS * rad_per_count,
    }
}
