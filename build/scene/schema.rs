//! The keys of a scene file: what kind of value each has, and within which range.

use toml::{Table, Value};

/// Kind and range of a value.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number.
    Number(f64, f64),
    /// A number for each phalanx.
    PerPhalanx(f64, f64),
    /// A number for each stage of the linkage, or for each joint that another motor holds: one less than phalanges.
    PerStage(f64, f64),
    /// A number for each pulley: two a joint from the second.
    PerPulley(f64, f64),
    /// One of these words for each stage.
    Words(&'static [&'static str]),
    /// true or false.
    Flag,
    /// Any text.
    Text,
}

/// A key.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    pub name: &'static str,
    pub kind: Kind,
    pub optional: bool,
}

const fn must(name: &'static str, kind: Kind) -> Key {
    Key {
        name,
        kind,
        optional: false,
    }
}

const fn may(name: &'static str, kind: Kind) -> Key {
    Key {
        name,
        kind,
        optional: true,
    }
}

use Kind::{Flag, Number, PerPhalanx, PerPulley, PerStage, Text, Words};

/// Keys that every scene has, its own or by default, and keys that it may have. Ranges that depend on other values are in
/// `check`.
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    must("title", Text),
    // From a miniature gripper to a harvesting hand; millimetres or a lost zero (0.8 for 0.08) fall outside.
    must("finger.length_m", PerPhalanx(5e-3, 0.5)),
    must("finger.spring_nm_per_rad", PerPhalanx(0.0, 1e3)),
    must("finger.rest_deg", PerPhalanx(-90.0, 180.0)),
    must("finger.joint_min_deg", PerPhalanx(-180.0, 180.0)),
    must("finger.joint_max_deg", PerPhalanx(-180.0, 180.0)),
    must("finger.half_thickness_m", Number(1e-3, 0.1)),
    must("finger.hidden_base", Flag),
    // Weight that springs hide from the motor, with the direction in which it pulls.
    may("finger.mass_kg", PerPhalanx(0.0, 10.0)),
    may("finger.mounting_deg", Number(-180.0, 180.0)),
    // In place of springs: pulleys at the joints, tension with the finger open, and stiffness of the cable's spring.
    may("return_cable.pulley_m", PerPhalanx(1e-3, 0.1)),
    may("return_cable.tension_n", Number(0.01, 1e3)),
    may("return_cable.stiffness_n_per_m", Number(1.0, 1e6)),
    must("travel.stop_rad", Number(0.01, 6.0)),
    must("travel.free_rad", Number(0.01, 6.0)),
    must("motor.torque_constant_nm_per_a", Number(1e-4, 1.0)),
    must("motor.resistance_ohm", Number(0.1, 500.0)),
    must("motor.choke_ohm", Number(0.0, 100.0)),
    must("motor.rotor_inertia_kg_m2", Number(1e-10, 1e-3)),
    must("motor.viscous_nm_s_per_rad", Number(0.0, 1e-4)),
    must("motor.friction_nm", Number(1e-9, 1.0)),
    must("motor.winding_limit_c", Number(40.0, 155.0)),
    must("motor.ambient_c", Number(-20.0, 145.0)),
    must("motor.winding_thermal_resistance_k_per_w", Number(0.1, 200.0)),
    must("motor.housing_thermal_resistance_k_per_w", Number(0.1, 200.0)),
    must("motor.winding_thermal_time_constant_s", Number(0.1, 1000.0)),
    must("motor.housing_thermal_time_constant_s", Number(1.0, 10_000.0)),
    must("encoder.counts_per_rev", Number(4.0, 65_536.0)),
    must("gearhead.ratio", Number(1.0, 10_000.0)),
    must("gearhead.efficiency", Number(0.1, 1.0)),
    must("gearhead.backlash_counts", Number(0.0, 1e5)),
    must("worm.ratio", Number(1.0, 1000.0)),
    must("worm.efficiency", Number(0.05, 1.0)),
    must("worm.efficiency_per_speed", Number(0.0, 1.0)),
    must("worm.backlash_counts", Number(0.0, 1e5)),
    must("cable.fitted", Flag),
    must("cable.stiffness_n_per_m", Number(10.0, 1e8)),
    must("cable.pulley_radius_m", Number(1e-3, 1.0)),
    must("cable.creep_fraction", Number(0.0, 1.0)),
    must("cable.creep_time_s", Number(0.01, 1e4)),
    must("sense.reference_v", Number(1.0, 3.6)),
    must("sense.resistor_ohm", Number(10.0, 1e6)),
    must("sense.mirror_a_per_a", Number(1e-6, 0.1)),
    must("shunt.fitted", Flag),
    must("shunt.shunt_ohm", Number(1e-4, 10.0)),
    must("shunt.gain_v_per_v", Number(1.0, 1000.0)),
    must("identify.fitted", Flag),
    must("supply.divider", Number(0.01, 1.0)),
    must("hall.fitted", Flag),
    must("hall.zero_v", Number(-20.0, 20.0)),
    must("hall.sensitivity_v_per_rad", Number(-10.0, 10.0)),
    must("hall.min_rad", Number(-3.2, 3.2)),
    must("hall.max_rad", Number(-3.2, 3.2)),
    must("limits.current_a", Number(0.001, 100.0)),
    must("limits.current_trip_a", Number(0.001, 100.0)),
    must("limits.duty", Number(0.05, 1.0)),
    must("limits.speed_rad_per_s", Number(1e-3, 100.0)),
    must("limits.acceleration_rad_per_s2", Number(1e-3, 1e4)),
    must("limits.position_min_rad", Number(-100.0, 0.0)),
    must("limits.position_max_rad", Number(0.0, 100.0)),
    must("limits.overtravel_rad", Number(1e-3, 10.0)),
    must("limits.supply_min_v", Number(3.0, 40.0)),
    must("limits.supply_max_v", Number(3.0, 60.0)),
    must("motion.closing_rad_per_s", Number(0.02, 100.0)),
    must("motion.opening_rad_per_s", Number(0.02, 100.0)),
    must("motion.free_current_a", Number(1e-3, 100.0)),
    must("motion.homing_current_a", Number(1e-3, 100.0)),
    must("motion.probing_current_a", Number(1e-3, 100.0)),
    must("motion.probing_rad", Number(0.01, 3.0)),
    must("motion.holding_current_a", Number(0.0, 100.0)),
    must("motion.holding_s", Number(0.0, 600.0)),
    must("motion.hold_force_n", Number(0.01, 1000.0)),
    must("motion.rest_rad", Number(0.0, 0.5)),
    must("sensing.probe_torque_nm", Number(1e-3, 100.0)),
    must("sensing.wanted_sigma_m", Number(1e-6, 0.1)),
    must("sensing.pin_radius_m", Number(0.0, 1.0)),
    must("sensing.contact_friction", Number(0.0, 2.0)),
    must("sensing.contact_friction_sigma", Number(1e-4, 2.0)),
    must("sensing.joint_friction_nm", Number(0.0, 10.0)),
    must("sensing.joint_friction_sigma_nm", Number(1e-9, 10.0)),
    must("sensing.preload_nm", Number(0.0, 10.0)),
    must("sensing.preload_sigma_nm", Number(0.0, 10.0)),
    must("sensing.object_compliance_sigma_m_per_n", Number(1e-6, 1.0)),
    must("sensing.leverage_sigma", Number(0.0, 1.0)),
    must("sensing.worm_error_rad", Number(0.0, 0.02)),
    must("sensing.swing_nm", Number(0.0, 1.0)),
    must("sensing.torque_factor", Number(0.5, 1.5)),
    must("sensing.torque_factor_sigma", Number(1e-3, 1.0)),
    must("sensing.torque_constant_sigma", Number(0.0, 0.5)),
    must("sensing.cable_sigma_rad_per_nm", Number(0.0, 100.0)),
    must("sensing.cable_stiffening_per_nm", Number(0.0, 10.0)),
    must("sensing.cable_stiffening_sigma_per_nm", Number(0.0, 10.0)),
    must("sensing.inertia_sigma", Number(0.0, 1.0)),
    must("options.second_contact", Flag),
    must("options.contact_changes", Flag),
    must("options.object_stiffness", Flag),
    may("linkage.driving_m", PerStage(1e-4, 10.0)),
    may("linkage.coupler_m", PerStage(1e-4, 10.0)),
    may("linkage.driven_m", PerStage(1e-4, 10.0)),
    may("linkage.offset_deg", PerStage(-180.0, 180.0)),
    may("linkage.assembly", Words(&["clockwise", "counterclockwise"])),
    may("tendon.pulley_m", PerPulley(1e-4, 1.0)),
    // A motor at every joint: how far a joint from the second can turn between the flanks of the worm wheel that holds it.
    may("direct.backlash_deg", PerStage(0.0, 10.0)),
];

/// Checks that a file has no key that nobody reads.
pub(super) fn known(file: &Table) -> Result<(), String> {
    for (section, value) in file {
        let path = |name: &str| format!("{section}.{name}");
        let names: Vec<String> = match value {
            Value::Table(keys) => keys.keys().map(|name| path(name)).collect(),
            _ if sections().contains(&section.as_str()) => {
                return Err(format!(
                    "`{section}` = {value} must be a section, [{section}]"
                ));
            }
            _ => vec![section.clone()],
        };
        for name in names {
            if KEYS.iter().any(|key| key.name == name) {
                continue;
            }
            let beside: Vec<&str> = KEYS
                .iter()
                .filter_map(|key| key.name.strip_prefix(&path("")))
                .collect();
            let elsewhere = elsewhere(&name);
            return Err(if beside.is_empty() {
                format!(
                    "unknown key `{name}`{elsewhere}; the sections are: {}",
                    sections().join(", ")
                )
            } else {
                format!(
                    "unknown key `{name}`{elsewhere}; [{section}] has: {}",
                    beside.join(", ")
                )
            });
        }
    }
    Ok(())
}

/// The sections that have a key of this name, to be put behind it.
fn elsewhere(name: &str) -> String {
    let own = name.rsplit_once('.').map_or(name, |(_, own)| own);
    let sections: Vec<String> = KEYS
        .iter()
        .filter_map(|key| key.name.split_once('.'))
        .filter(|(_, key)| *key == own)
        .map(|(section, _)| format!("[{section}]"))
        .collect();
    if sections.is_empty() {
        String::new()
    } else {
        format!(", which belongs to {}", sections.join(" or "))
    }
}

fn sections() -> Vec<&'static str> {
    let mut sections: Vec<&str> = KEYS
        .iter()
        .filter_map(|key| Some(key.name.split_once('.')?.0))
        .collect();
    sections.dedup();
    sections
}
