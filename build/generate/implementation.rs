//! The implementation of the library's `Scene` trait, section by section.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use super::{finger, literal, type_name};
use crate::scene::Scene;

/// The type with its implementation of the trait.
pub fn rust(scene: &Scene) -> String {
    let sections = [
        types(scene),
        drive(scene),
        motion(scene),
        uncalibrated(scene),
        drivetrain(scene),
        mounting(scene),
        rest(scene),
    ];
    // Each ends its own line.
    sections.concat()
}

/// Types, names and the mechanism; the implementation stays open.
fn types(scene: &Scene) -> String {
    let name = type_name(&scene.name);
    let title = scene.text("title");
    let (finger, mechanism) = finger::of(scene);
    let joint = if scene.flag("hall.fitted") {
        "HallSensor"
    } else {
        "NoJointSensor"
    };
    let follows = if scene.flag("options.second_contact") {
        "palpate::sensing::Follow<Self::Finger>"
    } else {
        "palpate::sensing::FirstContactOnly"
    };
    let after = if scene.flag("options.contact_changes") {
        format!("palpate::sensing::Changes<{follows}>")
    } else {
        follows.to_owned()
    };
    let series = if scene.flag("cable.fitted") {
        "Cable"
    } else {
        "Rigid"
    };
    let series = if scene.flag("options.object_stiffness") {
        format!("SoftObject<palpate::sensing::{series}>")
    } else {
        series.to_owned()
    };
    format!(
        "/// {title}.
#[derive(Clone, Copy, Debug)]
pub struct {name};

#[allow(clippy::approx_constant, clippy::excessive_precision, reason = \"numbers of the scene's file\")]
impl palpate::scene::Scene for {name} {{
    const NAME: &'static str = {:?};
    const DIMENSIONS: &'static str = {:?};
    type Finger = {finger};
    type Joint = palpate::sensing::{joint};
    type Series = palpate::sensing::{series};
    type After = {after};
    const MECHANISM: Self::Finger = {mechanism};\n",
        scene.name,
        scene.dimensions()
    )
}

/// Motor, gears, analog inputs and limits.
fn drive(scene: &Scene) -> String {
    let of = |key: &str| literal(scene.number(key));
    let counts = scene.number("encoder.counts_per_rev");
    let torque_constant = scene.number("motor.torque_constant_nm_per_a");
    let parts = format!(
        "    const DRIVE: palpate::drive::config::Config = palpate::drive::config::Config {{
        motor: palpate::drive::config::Motor {{
            torque_constant_nm_per_a: {},
            resistance_ohm: {},
            choke_ohm: {},
            rotor_inertia_kg_m2: {},
            thermal: palpate::drive::config::Thermal {{
                limit_c: {},
                ambient_c: {},
                winding_k_per_w: {},
                housing_k_per_w: {},
                winding_s: {},
                housing_s: {},
            }},
        }},
        drivetrain: palpate::drive::config::Gearing {{
            counts_per_motor_rev: {},
            reduction: {},
        }},
        sense: palpate::drive::config::AnalogInputs {{
            reference_v: {},
            volt_per_a: {},
            zero_v: {},
            signed: {},
            supply_divider: {},
        }},
        limits: palpate::drive::config::Limits {{\n",
        literal(torque_constant),
        of("motor.resistance_ohm"),
        of("motor.choke_ohm"),
        of("motor.rotor_inertia_kg_m2"),
        of("motor.winding_limit_c"),
        of("motor.ambient_c"),
        of("motor.winding_thermal_resistance_k_per_w"),
        of("motor.housing_thermal_resistance_k_per_w"),
        of("motor.winding_thermal_time_constant_s"),
        of("motor.housing_thermal_time_constant_s"),
        literal(counts),
        literal(reduction(scene)),
        of("sense.reference_v"),
        literal(scene.sense_volt_per_a()),
        literal(scene.sense_zero_v()),
        scene.flag("shunt.fitted"),
        literal(1.0 / scene.number("supply.divider")),
    );
    let limits = [
        "current_a",
        "current_trip_a",
        "duty",
        "speed_rad_per_s",
        "acceleration_rad_per_s2",
        "position_min_rad",
        "position_max_rad",
        "overtravel_rad",
        "supply_min_v",
        "supply_max_v",
    ]
    .map(|field| format!("            {field}: {},\n", of(&format!("limits.{field}"))));
    format!("{parts}{}        }},\n    }};\n", limits.concat())
}

/// What the motion sequence does.
fn motion(scene: &Scene) -> String {
    let of = |key: &str| literal(scene.number(key));
    let fields = [
        "closing_rad_per_s",
        "opening_rad_per_s",
        "free_current_a",
        "homing_current_a",
        "probing_current_a",
        "probing_rad",
        "holding_current_a",
        "holding_s",
        "rest_rad",
    ]
    .map(|field| format!("        {field}: {},\n", of(&format!("motion.{field}"))));
    format!(
        "    const MOTION: palpate::drive::sequence::Motion = palpate::drive::sequence::Motion {{\n{}        travel_rad: {},\n    }};\n",
        fields.concat(),
        of("travel.free_rad")
    )
}

/// What is known of the finger by its data sheets.
fn uncalibrated(scene: &Scene) -> String {
    let of = |key: &str| literal(scene.number(key));
    let (mut cable, mut stiffening) = ([0.0; 2], [0.0; 2]);
    if scene.flag("cable.fitted") {
        let radius_m = scene.number("cable.pulley_radius_m");
        let stiffness = scene.number("cable.stiffness_n_per_m") * radius_m * radius_m;
        cable = [
            1.0 / stiffness,
            scene.number("sensing.cable_sigma_rad_per_nm"),
        ];
        stiffening = [
            scene.number("sensing.cable_stiffening_per_nm"),
            scene.number("sensing.cable_stiffening_sigma_per_nm"),
        ];
    }
    let [cable, cable_sigma] = cable.map(literal);
    let [stiffening, stiffening_sigma] = stiffening.map(literal);
    format!(
        "    const UNCALIBRATED: palpate::sensing::Calibration = palpate::sensing::Calibration {{
        torque_factor: {},
        torque_factor_sigma: {},
        cable_rad_per_nm: {cable},
        cable_sigma_rad_per_nm: {cable_sigma},
        correlation: 0.0,
        stiffening_per_nm: {stiffening},
        stiffening_sigma_per_nm: {stiffening_sigma},
        joint_nm: 0.0,
        joint_sigma_nm: 0.0,
        joint_correlation: 0.0,
        worm_rad: [0.0; 2],
        contacts: 0,
        presses: 0,
    }};\n",
        of("sensing.torque_factor"),
        of("sensing.torque_factor_sigma")
    )
}

/// Gears between motor and input link, as the sensing needs them.
fn drivetrain(scene: &Scene) -> String {
    let of = |key: &str| literal(scene.number(key));
    let reduction = reduction(scene);
    let gearhead = scene.number("gearhead.ratio");
    let counts = scene.number("encoder.counts_per_rev");
    let rad_per_count = TAU / (counts * reduction);
    let torque_constant = scene.number("motor.torque_constant_nm_per_a");
    let inertia = scene.number("motor.rotor_inertia_kg_m2") * reduction * reduction;
    let viscous = scene.number("motor.viscous_nm_s_per_rad") * reduction * reduction;
    let backlash = scene.number("gearhead.backlash_counts") + scene.number("worm.backlash_counts");
    let creep = if scene.flag("cable.fitted") {
        scene.number("cable.creep_fraction")
    } else {
        0.0
    };
    let creep = literal(creep);
    format!(
        "    const DRIVETRAIN: palpate::sensing::Drivetrain = palpate::sensing::Drivetrain {{
        rad_per_count: {},
        counts_per_turn: {},
        counts_per_worm_turn: {},
        creep: {creep},
        creep_s: {},
        opening_stop_rad: 0.0,
        torque_per_ampere_nm: {},
        torque_constant_sigma: {},
        resistance_ohm: {},
        efficiency: {},
        inertia_kg_m2: {},
        inertia_sigma: {},
        viscous_nm_s_per_rad: {},
        efficiency_per_speed: {},
        weight_share: {},
        backlash_rad: {},
    }};\n",
        literal(rad_per_count),
        counts.round(),
        if scene.number("worm.ratio") > 1.0 {
            (counts * gearhead).round()
        } else {
            0.0
        },
        of("cable.creep_time_s"),
        literal(reduction * torque_constant),
        of("sensing.torque_constant_sigma"),
        literal(scene.number("motor.resistance_ohm") + scene.number("motor.choke_ohm")),
        literal(efficiency(scene)),
        literal(inertia),
        of("sensing.inertia_sigma"),
        literal(viscous),
        of("worm.efficiency_per_speed"),
        literal(0.5 * scene.number("gearhead.efficiency")),
        literal(backlash * rad_per_count),
    )
}

/// Turns of the motor in one of the input link.
fn reduction(scene: &Scene) -> f64 {
    scene.number("gearhead.ratio") * scene.number("worm.ratio")
}

/// Share of the motor's torque that the gears pass on.
fn efficiency(scene: &Scene) -> f64 {
    scene.number("gearhead.efficiency") * scene.number("worm.efficiency")
}

/// How the finger hangs, where its scene states a weight.
fn mounting(scene: &Scene) -> String {
    if !scene.has("finger.mass_kg") {
        return String::new();
    }
    format!(
        "    const MOUNTING_RAD: f32 = {};\n",
        literal(scene.number("finger.mounting_deg").to_radians()),
    )
}

/// The rest of the implementation and what checks it.
fn rest(scene: &Scene) -> String {
    let of = |key: &str| literal(scene.number(key));
    let name = type_name(&scene.name);
    format!(
        "    const HOLD_FORCE_N: f32 = {};
    const FRICTION_NM: f32 = {};
    const IDENTIFIES: bool = {};
    const ANGLE_SENSOR: palpate::joint_sensor::AngleSensor = palpate::joint_sensor::AngleSensor {{
        zero_v: {},
        volt_per_rad: {},
        min_rad: {},
        max_rad: {},
    }};

    fn settings() -> palpate::sensing::Settings {{
        palpate::sensing::Settings {{
            speed_rad_per_s: Self::MOTION.closing_rad_per_s,
            travel_rad: Self::MOTION.travel_rad,
            torque_limit_nm: {},
            wanted_sigma_m: {},
            closing_stop_rad: {},
            half_thickness_m: {},
            pin_radius_m: {},
            contact_friction: [{}, {}],
            joint_friction_nm: [{}, {}],
            preload_nm: [{}, {}],
            object_give_m_per_n: {},
            leverage_sigma: {},
            worm_error_rad: {},
            swing_rms_nm_s_per_rad: {},
            ..palpate::sensing::Settings::default()
        }}
    }}
}}

// The compiler checks what the build script did, and more: whatever the library demands of its constants.
const _: &palpate::drive::config::CheckedConfig = &<{name} as palpate::scene::Scene>::CHECKED;
const _: &<{name} as palpate::scene::Scene>::Finger = &<{name} as palpate::scene::Scene>::MECHANISM;

",
        of("motion.hold_force_n"),
        of("motor.friction_nm"),
        scene.flag("identify.fitted"),
        of("hall.zero_v"),
        of("hall.sensitivity_v_per_rad"),
        of("hall.min_rad"),
        of("hall.max_rad"),
        of("sensing.probe_torque_nm"),
        of("sensing.wanted_sigma_m"),
        of("travel.stop_rad"),
        of("finger.half_thickness_m"),
        of("sensing.pin_radius_m"),
        of("sensing.contact_friction"),
        of("sensing.contact_friction_sigma"),
        of("sensing.joint_friction_nm"),
        of("sensing.joint_friction_sigma_nm"),
        literal(scene.number("sensing.preload_nm") + scene.preload_nm()),
        of("sensing.preload_sigma_nm"),
        of("sensing.object_compliance_sigma_m_per_n"),
        of("sensing.leverage_sigma"),
        of("sensing.worm_error_rad"),
        // Convert the finger's largest swing to the motor's torque before the gears' losses, root mean square per closing speed.
        literal(scene.number("sensing.swing_nm") * FRAC_1_SQRT_2 / (efficiency(scene) * scene.number("motion.closing_rad_per_s"))),
    )
}
