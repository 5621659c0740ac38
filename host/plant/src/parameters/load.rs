//! A scene's nominal values, the default world, and a user's file over both.

use super::scenes::{default_scene, values};
use super::{DEFAULT_TOML, Engine, ObjectMount, Parameters};
use crate::Error;
use toml::{Table, Value};

/// Stiffness of the short steel shaft that takes the cable's place where the worm wheel is on the input link, newton metre
/// per radian.
const SHAFT_NM_PER_RAD: f64 = 4e3;

/// Keys of a scene with another name in a world; those of the sections below have the same name in both.
const RENAMED: &[(&str, &str)] = &[
    ("travel.stop_rad", "finger.travel_rad"),
    ("linkage.driving_m", "finger.lever_m"),
    ("linkage.coupler_m", "finger.coupler_m"),
    ("linkage.driven_m", "finger.driven_m"),
    ("linkage.offset_deg", "finger.offset_deg"),
    ("tendon.pulley_m", "finger.pulley_m"),
    ("finger.mass_kg", "finger.stated_mass_kg"),
    ("direct.backlash_deg", "finger.held_backlash_deg"),
    ("return_cable.pulley_m", "finger.return_pulley_m"),
    ("return_cable.tension_n", "finger.return_tension_n"),
    ("return_cable.stiffness_n_per_m", "finger.return_n_per_m"),
    (
        "finger.half_thickness_m",
        "mechanism.phalanx_half_thickness_m",
    ),
    ("sense.reference_v", "sense.full_scale_v"),
    ("motor.choke_ohm", "choke.resistance_ohm"),
];

/// Keys of a scene that a world has under the same name.
const SAME: &[&str] = &[
    "finger.length_m",
    "finger.hidden_base",
    "finger.spring_nm_per_rad",
    "finger.rest_deg",
    "finger.joint_min_deg",
    "finger.joint_max_deg",
    "motor.torque_constant_nm_per_a",
    "motor.resistance_ohm",
    "motor.rotor_inertia_kg_m2",
    "motor.viscous_nm_s_per_rad",
    "motor.winding_thermal_resistance_k_per_w",
    "motor.housing_thermal_resistance_k_per_w",
    "motor.winding_thermal_time_constant_s",
    "motor.housing_thermal_time_constant_s",
    "gearhead.ratio",
    "gearhead.efficiency",
    "gearhead.backlash_counts",
    "worm.ratio",
    "worm.backlash_counts",
    "cable.stiffness_n_per_m",
    "cable.pulley_radius_m",
    "cable.creep_fraction",
    "cable.creep_time_s",
    "encoder.counts_per_rev",
    "sense.resistor_ohm",
    "sense.mirror_a_per_a",
    "supply.divider",
    "hall.zero_v",
    "hall.sensitivity_v_per_rad",
];

/// A world without its scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World {
    overlay: Table,
    /// What computes finger and object.
    pub engine: Engine,
    /// How the object is held, if not as in the file.
    pub mount: Option<ObjectMount>,
}

impl World {
    /// Reads a TOML text; keys that it does not contain keep the value of `default.toml` or of the scene.
    ///
    /// # Errors
    /// [`Error`]: not TOML, an unknown key, a value of the wrong kind or out of its range. Only a scene says what its finger needs, so that
    /// a world with a finger is checked with the scene that it is [used with](Self::of).
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let world = Self {
            overlay: text.parse().map_err(syntax)?,
            ..Self::default()
        };
        let parameters = world.parsed(default_scene())?;
        if !world.overlay.contains_key("finger") {
            parameters.validate()?;
        }
        Ok(world)
    }

    /// Parameters of a scene in this world.
    ///
    /// # Errors
    /// [`Error`]: no such scene, one with a wrong value, or a world that does not fit it.
    pub fn of(&self, scene: &str) -> Result<Parameters, Error> {
        let parameters = self.parsed(scene)?;
        parameters.validate()?;
        Ok(parameters)
    }

    /// Parameters whose values are not checked.
    fn parsed(&self, scene: &str) -> Result<Parameters, Error> {
        let mut merged: Table = DEFAULT_TOML.parse().map_err(syntax)?;
        nominal(&mut merged, &values(scene)?);
        overlay(&mut merged, self.overlay.clone(), "")?;
        merged.insert("scene".to_owned(), Value::String(scene.to_owned()));
        let mut parameters: Parameters = Value::Table(merged).try_into().map_err(syntax)?;
        parameters.engine = self.engine;
        parameters.object.mount = self.mount.unwrap_or(parameters.object.mount);
        Ok(parameters)
    }
}

impl Parameters {
    /// The default scene in the world of a TOML text: see [`World::from_toml`].
    ///
    /// # Errors
    /// Those of [`World::from_toml`].
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        World::from_toml(text)?.of(default_scene())
    }

    /// A scene in the default world.
    ///
    /// # Errors
    /// [`Error::Scene`]: no such scene, or one with a wrong value.
    pub fn of(scene: &str) -> Result<Self, Error> {
        World::default().of(scene)
    }
}

/// Overrides values of the world by nominal values of a scene.
fn nominal(world: &mut Table, scene: &Table) {
    // A finger has one kind of transmission; the values of the other kind are removed.
    for key in [
        "pulley_m",
        "lever_m",
        "coupler_m",
        "driven_m",
        "offset_deg",
        "mode",
        "held_backlash_deg",
        "return_pulley_m",
        "stated_mass_kg",
    ] {
        set(world, &format!("finger.{key}"), Value::Array(Vec::new()));
    }
    for (from, to) in SAME
        .iter()
        .map(|key| (key, key))
        .chain(RENAMED.iter().map(|(a, b)| (a, b)))
    {
        if let Some(value) = get(scene, from) {
            set(world, to, float(value.clone()));
        }
    }
    let modes = get(scene, "linkage.assembly").and_then(Value::as_array);
    let mode = |word: &Value| match word.as_str() {
        Some("clockwise") => Value::Float(-1.0),
        _ => Value::Float(1.0),
    };
    if let Some(modes) = modes {
        set(
            world,
            "finger.mode",
            Value::Array(modes.iter().map(mode).collect()),
        );
    }
    if get(scene, "shunt.fitted").and_then(Value::as_bool) == Some(true) {
        let number = |key| get(scene, key).and_then(|value| float(value.clone()).as_float());
        let volt_per_a = number("shunt.shunt_ohm")
            .zip(number("shunt.gain_v_per_v"))
            .map(|(ohm, gain)| ohm * gain);
        // The amplifier's zero is half the converter's reference.
        let zero_v = number("sense.reference_v").map(|volt| 0.5 * volt);
        for (key, value) in [("shunt_v_per_a", volt_per_a), ("shunt_zero_v", zero_v)] {
            if let Some(value) = value {
                set(world, &format!("sense.{key}"), Value::Float(value));
            }
        }
    }
    if get(scene, "cable.fitted").and_then(Value::as_bool) == Some(false) {
        let radius_m = get(scene, "cable.pulley_radius_m")
            .and_then(Value::as_float)
            .unwrap_or(0.02);
        set(
            world,
            "cable.stiffness_n_per_m",
            Value::Float(SHAFT_NM_PER_RAD / (radius_m * radius_m)),
        );
        set(world, "cable.creep_fraction", Value::Float(0.0));
    }
}

fn get<'a>(table: &'a Table, key: &str) -> Option<&'a Value> {
    let (section, name) = key.split_once('.')?;
    table.get(section)?.get(name)
}

fn set(table: &mut Table, key: &str, value: Value) {
    let Some((section, name)) = key.split_once('.') else {
        return;
    };
    let section = table
        .entry(section)
        .or_insert_with(|| Value::Table(Table::new()));
    if let Some(section) = section.as_table_mut() {
        section.insert(name.to_owned(), value);
    }
}

/// Converts integers to floating point, so that a file may write either.
fn float(value: Value) -> Value {
    match value {
        #[expect(
            clippy::cast_precision_loss,
            reason = "values of scenes are far below 2^53"
        )]
        Value::Integer(integer) => Value::Float(integer as f64),
        Value::Array(list) => Value::Array(list.into_iter().map(float).collect()),
        other => other,
    }
}

fn syntax(error: toml::de::Error) -> Error {
    Error::Syntax(error.to_string())
}

fn overlay(base: &mut Table, user: Table, path: &str) -> Result<(), Error> {
    for (name, value) in user {
        let key = if path.is_empty() {
            name.clone()
        } else {
            format!("{path}.{name}")
        };
        let Some(slot) = base.get_mut(&name) else {
            let expected = base.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(Error::UnknownKey { key, expected });
        };
        match (slot, value) {
            (Value::Table(inner), Value::Table(user)) => overlay(inner, user, &key)?,
            (slot @ Value::Float(_), value) => *slot = number(value, &key)?,
            (slot @ Value::String(_), value @ Value::String(_)) => *slot = value,
            (slot @ Value::Array(_), Value::Array(list)) => {
                let numbers = list
                    .into_iter()
                    .enumerate()
                    .map(|(i, v)| number(v, &format!("{key}[{i}]")));
                *slot = Value::Array(numbers.collect::<Result<_, _>>()?);
            }
            (slot, value) => {
                return Err(Error::WrongType {
                    key,
                    found: value.type_str(),
                    expected: slot.type_str(),
                });
            }
        }
    }
    Ok(())
}

/// A number, written with or without a point.
fn number(value: Value, key: &str) -> Result<Value, Error> {
    match value {
        Value::Float(_) => Ok(value),
        #[expect(clippy::cast_precision_loss, reason = "parameters are far below 2^53")]
        Value::Integer(integer) => Ok(Value::Float(integer as f64)),
        other => Err(Error::WrongType {
            key: key.to_owned(),
            found: other.type_str(),
            expected: "a number",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::scene::schema::{KEYS, Kind};
    use super::*;

    /// What a scene may say a world can compute: at either end of a key's range no world finds it out of range.
    #[test]
    fn a_world_takes_every_value_that_a_scene_may_have() {
        let names = SAME.iter().map(|key| (key, key));
        let names = names.chain(RENAMED.iter().map(|(from, to)| (from, to)));
        let mut tried = 0;
        for (from, to) in names {
            // Ranges that follow from each other, in scenes and worlds alike.
            if ["joint_min_deg", "joint_max_deg", "rest_deg"]
                .iter()
                .any(|name| from.ends_with(name))
            {
                continue;
            }
            let key = KEYS.iter().find(|key| key.name == *from);
            let key = key.unwrap_or_else(|| panic!("no key {from}"));
            let (number, ends) = match key.kind {
                Kind::Number(min, max) => (None, [min, max]),
                // Those of the default scene.
                Kind::PerPhalanx(min, max) | Kind::PerPulley(min, max) => (Some(2), [min, max]),
                Kind::PerStage(min, max) => (Some(1), [min, max]),
                Kind::Words(_) | Kind::Flag | Kind::Text => continue,
            };
            let (section, name) = to.split_once('.').expect("a section");
            for end in ends {
                // Both want a spring beyond joint 1.
                let end = if *from == "finger.spring_nm_per_rad" {
                    end.max(1e-6)
                } else {
                    end
                };
                let value = number.map_or(format!("{end:e}"), |number| {
                    format!("{:?}", vec![end; number])
                });
                let world = World::from_toml(&format!("[{section}]\n{name} = {value}\n"))
                    .and_then(|world| world.of(default_scene()));
                tried += 1;
                if let Err(Error::OutOfRange { key, .. }) = &world {
                    assert!(!key.starts_with(*to), "{from} = {value}: {world:?}");
                }
                assert!(
                    !matches!(world, Err(Error::Syntax(_))),
                    "{value}: {world:?}"
                );
            }
        }
        assert!(tried > 60, "{tried}");
    }
}
