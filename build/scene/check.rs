//! What a scene must satisfy: kind and range of every key, then the ranges that depend on other values.

mod closing;
mod finger;
mod linkage;
mod single;

use std::f64::consts::TAU;

use toml::Value;

use super::schema::{KEYS, Key, Kind};
use super::{Scene, TRANSMISSIONS};

type Checked = Result<(), String>;

pub(super) fn check(scene: &Scene) -> Checked {
    let count = scene.phalanges();
    if !(2..=3).contains(&count) {
        const LENGTHS: &str = "finger.length_m";
        return Err(match scene.value(LENGTHS) {
            None => format!("`{LENGTHS}` is missing: it has no default"),
            Some(Value::Array(list)) if list.len() == count => {
                format!("`{LENGTHS}` has {count} numbers, expected 2 or 3")
            }
            Some(value) => format!("`{LENGTHS}` = {value} must be a list of 2 or 3 numbers"),
        });
    }
    transmission(scene)?;
    for key in KEYS {
        match scene.value(key.name) {
            Some(value) => kind(key, value, count)?,
            None if key.optional => {}
            None => return Err(format!("`{}` is missing: it has no default", key.name)),
        }
    }
    finger::joints(scene)?;
    linkage::check(scene)?;
    drive(scene)?;
    motion(scene)?;
    closing::check(scene)?;
    finger::return_cable(scene)?;
    finger::preload(scene)?;
    finger::hidden_base(scene)?;
    finger::held_joint(scene)?;
    finger::leverage(scene)?;
    finger::weight(scene)?;
    soft_object(scene)?;
    hall(scene)?;
    single::check(scene)
}

/// NaN is out of every range.
fn within(key: &str, value: f64, min: f64, max: f64) -> Checked {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(format!(
            "`{key}` = {value} is out of range, allowed {} to {}",
            short(min),
            short(max)
        ))
    }
}

/// A limit without the digits that a computation leaves behind.
fn short(limit: f64) -> f64 {
    format!("{limit:.4e}").parse().unwrap_or(limit)
}

fn kind(key: &Key, value: &Value, count: usize) -> Checked {
    let name = key.name;
    let wrong = |expected: &str| Err(format!("`{name}` = {value} must be {expected}"));
    let each = |expected: usize, check: &dyn Fn(&str, &Value) -> Checked| {
        let Some(list) = value.as_array() else {
            return wrong(&format!("a list of {expected}"));
        };
        if list.len() != expected {
            return Err(format!(
                "`{name}` has {} values, expected {expected} in a finger of {count} phalanges",
                list.len()
            ));
        }
        let mut numbered = list.iter().enumerate();
        numbered.try_for_each(|(i, value)| check(&format!("{name}[{i}]"), value))
    };
    let ranged = |min, max| {
        move |name: &str, value: &Value| match super::number(value) {
            Some(number) => within(name, number, min, max),
            None => Err(format!(
                "`{name}` = {value} must be a number from {min} to {max}"
            )),
        }
    };
    match key.kind {
        Kind::Number(min, max) => ranged(min, max)(name, value),
        Kind::PerPhalanx(min, max) => each(count, &ranged(min, max)),
        Kind::PerStage(min, max) => each(count - 1, &ranged(min, max)),
        Kind::PerPulley(min, max) => each(2 * (count - 1), &ranged(min, max)),
        Kind::Words(words) => each(count - 1, &|name, value| match value.as_str() {
            Some(word) if words.contains(&word) => Ok(()),
            _ => Err(format!(
                "`{name}` = {value} must be one of: {}",
                words.join(", ")
            )),
        }),
        Kind::Flag if value.is_bool() => Ok(()),
        Kind::Flag => wrong("true or false"),
        // A title becomes a comment of one line in the generated code.
        Kind::Text
            if value
                .as_str()
                .is_some_and(|text| !text.contains(char::is_control)) =>
        {
            Ok(())
        }
        Kind::Text => wrong("a text of one line"),
    }
}

/// A linkage with all its keys, a tendon, or a motor at every joint.
fn transmission(scene: &Scene) -> Checked {
    let mut has = TRANSMISSIONS.iter().filter(|section| scene.has(section));
    let (Some(section), None) = (has.next(), has.next()) else {
        return Err("a finger has one transmission: [linkage], [tendon] or [direct]".to_owned());
    };
    let lacking = KEYS.iter().find(|key| {
        let of = key.name.split_once('.').map(|(section, _)| section);
        of == Some(section) && !scene.has(key.name)
    });
    lacking.map_or(Ok(()), |key| {
        Err(format!("`{}` is missing: it has no default", key.name))
    })
}

fn drive(scene: &Scene) -> Checked {
    let of = |key: &str| scene.number(key);
    let full_scale_a = (of("sense.reference_v") - scene.sense_zero_v()) / scene.sense_volt_per_a();
    let counts_per_rad =
        of("encoder.counts_per_rev") * of("gearhead.ratio") * of("worm.ratio") / TAU;
    for (key, min, max) in [
        // The drive's arithmetic: at most 16 counts a control period, positions within a quarter of 32 bits.
        ("motor.ambient_c", -20.0, of("motor.winding_limit_c") - 10.0),
        (
            "limits.speed_rad_per_s",
            1e-3,
            16.0 * 20_000.0 / counts_per_rad,
        ),
        ("limits.position_min_rad", -5e8 / counts_per_rad, 0.0),
        ("limits.position_max_rad", 0.0, 5e8 / counts_per_rad),
        ("limits.overtravel_rad", 1e-3, 5e8 / counts_per_rad),
        // Saturation of the sense would hide more.
        ("limits.current_trip_a", 0.001, 0.95 * full_scale_a),
        // Below the trip by what a motor 20 % off its resistance overshoots.
        ("limits.current_a", 0.001, 0.8 * of("limits.current_trip_a")),
    ] {
        within(key, of(key), min, max)?;
    }
    let (supply_min_v, supply_max_v) = (of("limits.supply_min_v"), of("limits.supply_max_v"));
    let readable_v = of("sense.reference_v") / of("supply.divider");
    within(
        "limits.supply_max_v",
        supply_max_v,
        supply_min_v,
        readable_v,
    )
    .map_err(|range| {
        format!("{range}: `limits.supply_min_v` to `sense.reference_v` / `supply.divider`")
    })?;
    // What the sense makes of an ampere, 0.01 to 1000 V, by the part that a board changes.
    let (part, per_part) = if scene.flag("shunt.fitted") {
        ("shunt.shunt_ohm", of("shunt.gain_v_per_v"))
    } else {
        ("sense.resistor_ohm", of("sense.mirror_a_per_a"))
    };
    within(part, of(part), 0.01 / per_part, 1000.0 / per_part)?;
    let reduction = of("gearhead.ratio") * of("worm.ratio");
    if (1.0..=10_000.0).contains(&reduction) {
        return Ok(());
    }
    within(
        "gearhead.ratio",
        of("gearhead.ratio"),
        1.0,
        10_000.0 / of("worm.ratio"),
    )
}

fn motion(scene: &Scene) -> Checked {
    let of = |key: &str| scene.number(key);
    let (current, speed) = (of("limits.current_a"), of("limits.speed_rad_per_s"));
    for (key, min, max) in [
        ("motion.closing_rad_per_s", 0.02, speed),
        ("motion.opening_rad_per_s", 0.02, speed),
        ("motion.free_current_a", 1e-3, current),
        ("motion.homing_current_a", 1e-3, current),
        ("motion.probing_current_a", 1e-3, current),
        ("motion.holding_current_a", 0.0, current),
        (
            "travel.free_rad",
            of("motion.rest_rad") + 0.05,
            of("limits.position_max_rad"),
        ),
        // The drive must reach the closing stop: a press on it calibrates the cable.
        (
            "travel.stop_rad",
            of("travel.free_rad"),
            of("limits.position_max_rad"),
        ),
        // What the probing current gives at the input link, without friction.
        (
            "sensing.probe_torque_nm",
            1e-3,
            of("motion.probing_current_a") * scene.torque_nm_per_a(),
        ),
    ] {
        within(key, of(key), min, max)?;
    }
    voltage(scene)
}

/// The highest supply must turn the motor at the speeds that are asked for, with the current of free motion.
fn voltage(scene: &Scene) -> Checked {
    let of = |key: &str| scene.number(key);
    let most_v = of("limits.duty") * of("limits.supply_max_v");
    let drop_v = of("motion.free_current_a") * (of("motor.resistance_ohm") + of("motor.choke_ohm"));
    let reduction = of("gearhead.ratio") * of("worm.ratio");
    let left_v = (most_v - drop_v).max(0.0);
    let most_rad_per_s = left_v / (reduction * of("motor.torque_constant_nm_per_a"));
    for key in ["motion.closing_rad_per_s", "motion.opening_rad_per_s"] {
        within(key, of(key), 0.0, most_rad_per_s).map_err(|range| {
            format!(
                "{range}: of `limits.duty` x `limits.supply_max_v` = {most_v} V, `motion.free_current_a` takes {drop_v:.2} V through \
                 `motor.resistance_ohm`; the rest turns a motor of this `motor.torque_constant_nm_per_a` no faster"
            )
        })?;
    }
    Ok(())
}

/// What follows a first contact takes the object to be rigid.
fn soft_object(scene: &Scene) -> Checked {
    for key in ["options.second_contact", "options.contact_changes"] {
        if scene.flag(key) && scene.flag("options.object_stiffness") {
            return Err(format!(
                "`{key}` = true is not possible with `options.object_stiffness` = true: an object that gives way changes the stiffness \
                 as well"
            ));
        }
    }
    Ok(())
}

/// Both ends of the sensor's range must stand clear of what a broken wire and a short read.
fn hall(scene: &Scene) -> Checked {
    if !scene.flag("hall.fitted") {
        return Ok(());
    }
    let of = |key: &str| scene.number(key);
    let (zero, slope, reference) = (
        of("hall.zero_v"),
        of("hall.sensitivity_v_per_rad"),
        of("sense.reference_v"),
    );
    let margin = 0.02 * reference;
    if slope.abs() < 0.01 {
        return Err(format!(
            "`hall.sensitivity_v_per_rad` = {slope} is out of range, allowed 0.01 to 10, or negative"
        ));
    }
    within("hall.max_rad", of("hall.max_rad"), of("hall.min_rad"), 3.2)?;
    for key in ["hall.min_rad", "hall.max_rad"] {
        let [first, last] = [margin, reference - margin].map(|volt| (volt - zero) / slope);
        within(key, of(key), first.min(last), first.max(last))?;
    }
    let rest_deg = scene.list("finger.rest_deg")[1].max(scene.list("finger.joint_min_deg")[1]);
    let rest = rest_deg.to_radians();
    for (key, min, max) in [("hall.min_rad", -3.2, rest), ("hall.max_rad", rest, 3.2)] {
        within(key, of(key), min, max)
            .map_err(|range| format!("{range}: joint 2 rests at {rest_deg} deg"))?;
    }
    Ok(())
}
