//! Reads scene files: finds them, lays each over its base and the defaults, and checks every key.
//!
//! Build scripts (the firmware's, and that of the scenes' types for host programs) and the simulated worlds include this module by
//! path, so that one reader serves them all and a scene is written once. It knows TOML and ranges, nothing of the library.

mod check;
pub mod list;
pub mod schema;

use std::fmt;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

/// The values of the keys that a scene leaves out.
const DEFAULTS: &str = "common/defaults.toml";
/// Sections on which a record of friction or a calibration depends.
const DIMENSIONS: [&str; 12] = [
    "finger",
    "linkage",
    "tendon",
    "direct",
    "return_cable",
    "travel",
    "encoder",
    "gearhead",
    "worm",
    "cable",
    "sense",
    "shunt",
];
/// Keys of other sections on which one depends.
const OF_OTHERS: [&str; 10] = [
    "motor.torque_constant_nm_per_a",
    "motion.closing_rad_per_s",
    "sensing.pin_radius_m",
    "sensing.torque_factor",
    "sensing.torque_factor_sigma",
    "sensing.cable_sigma_rad_per_nm",
    "sensing.cable_stiffening_per_nm",
    "sensing.cable_stiffening_sigma_per_nm",
    "sensing.joint_friction_nm",
    "sensing.preload_nm",
];
/// Sections of which a finger has one.
const TRANSMISSIONS: [&str; 3] = ["linkage", "tendon", "direct"];
/// Longest chain of bases: a longer one is a circle.
const MOST_BASES: usize = 8;

/// Why a scene cannot be used: the file, then key, value and range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error(String);

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A scene with every key that it has, checked.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Name of its file without the extension.
    pub name: String,
    /// Its sections.
    pub values: Table,
}

/// Names of the scenes in a folder, the default one first.
fn names(folder: &Path) -> Result<Vec<String>, Error> {
    list::names(folder).map_err(|error| Error(format!("{}: {error}", folder.display())))
}

/// The folder of scenes that is in use, and that of the project: host programs name some of its scenes. `root` is the root of the
/// package.
fn folders(root: &Path) -> [PathBuf; 2] {
    [list::folder(root), root.join(list::FOLDER)]
}

/// Tells cargo what the scenes of a build script depend on.
pub fn watch(root: &Path) {
    println!("cargo::rerun-if-env-changed={}", list::VARIABLE);
    for folder in folders(root) {
        println!("cargo::rerun-if-changed={}", folder.display());
    }
}

/// Names of all scenes: those of the folder in use, and those of the project that it does not have.
pub fn names_of_all(root: &Path) -> Result<Vec<String>, Error> {
    let [used, project] = folders(root);
    let mut all = names(&used)?;
    for name in names(&project)? {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    Ok(all)
}

/// All scenes, in the order of [`names_of_all`].
pub fn load_all(root: &Path) -> Result<Vec<Scene>, Error> {
    let names = names_of_all(root)?;
    names.iter().map(|name| find(root, name)).collect()
}

/// A scene of the folder in use, or else one of the project.
pub fn find(root: &Path, name: &str) -> Result<Scene, Error> {
    let [used, project] = folders(root);
    let has = |folder: &Path| folder.join(format!("{name}.toml")).exists();
    let folder = if !has(&used) && has(&project) {
        project
    } else {
        used
    };
    load(&folder, name)
}

/// A scene by its name.
pub fn load(folder: &Path, name: &str) -> Result<Scene, Error> {
    let mut scene = Scene {
        name: name.to_owned(),
        values: Table::new(),
    };
    let word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !(name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(word)) {
        return Err(Error(format!(
            "scene '{name}': a name begins with a small letter and has small letters, digits and '-'"
        )));
    }
    if !folder.join(format!("{name}.toml")).exists() {
        let known = names(folder)?.join(", ");
        return Err(Error(format!(
            "there is no scene '{name}'; there are: {known}"
        )));
    }
    scene.read(folder, &format!("{name}.toml"), 0)?;
    // Keep the message on one line, even where it quotes a value of several.
    check::check(&scene)
        .map_err(|problem| Error(format!("scene '{name}': {}", problem.replace('\n', " "))))?;
    Ok(scene)
}

impl Scene {
    /// Reads a file over its base, and that over the defaults.
    fn read(&mut self, folder: &Path, file: &str, depth: usize) -> Result<(), Error> {
        // By its name: the folder may be a copy, in which the user must not look for the mistake.
        let scene = file.trim_end_matches(".toml");
        let named = |problem: String| Error(format!("scene '{scene}': {problem}"));
        let path = folder.join(file);
        let text = std::fs::read_to_string(&path)
            .map_err(|error| Error(format!("{}: {error}", path.display())))?;
        let mut own: Table = text.parse().map_err(|error: toml::de::Error| {
            // One line: cargo shows no more of what a build script says.
            let all = error.to_string();
            let place = all.lines().next().unwrap_or_default();
            named(format!("{place}: {}", error.message().replace('\n', ", ")))
        })?;
        let base = match own.remove("base") {
            None if file == DEFAULTS => None,
            None => Some(DEFAULTS.to_owned()),
            Some(Value::String(base)) if depth < MOST_BASES => Some(format!("{base}.toml")),
            Some(Value::String(base)) => {
                return Err(named(format!("`base` = \"{base}\" leads in a circle")));
            }
            Some(other) => {
                return Err(named(format!(
                    "`base` = {other} must be the name of a scene"
                )));
            }
        };
        if let Some(base) = base {
            if base != DEFAULTS && !folder.join(&base).exists() {
                let mut known = names(folder)?;
                known.retain(|name| name != scene);
                return Err(named(format!(
                    "`base` = \"{}\" is no scene; there are: {}",
                    base.trim_end_matches(".toml"),
                    known.join(", ")
                )));
            }
            self.read(folder, &base, depth + 1)?;
        }
        sections_are_known(&own).map_err(named)?;
        schema::known(&own).map_err(named)?;
        // A finger has one transmission: its own takes the place of its base's.
        if TRANSMISSIONS
            .iter()
            .any(|section| own.contains_key(*section))
        {
            for section in TRANSMISSIONS {
                if !own.contains_key(section) {
                    self.values.remove(section);
                }
            }
        }
        for (name, value) in own {
            match (self.values.get_mut(&name), value) {
                (Some(Value::Table(section)), Value::Table(own)) => section.extend(own),
                (_, value) => {
                    self.values.insert(name, value);
                }
            }
        }
        Ok(())
    }

    fn value(&self, key: &str) -> Option<&Value> {
        match key.split_once('.') {
            Some((section, name)) => self.values.get(section)?.get(name),
            None => self.values.get(key),
        }
    }

    /// Whether it has a section or key.
    pub fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// Every key on which a record of friction or a calibration depends, with its value: two scenes that differ in none can share one.
    pub fn dimensions(&self) -> String {
        let mut text = String::new();
        for section in DIMENSIONS {
            let keys = self.values.get(section).and_then(Value::as_table);
            for key in keys.into_iter().flat_map(Table::keys) {
                text += &self.written(&format!("{section}.{key}"));
            }
        }
        for key in OF_OTHERS {
            text += &self.written(key);
        }
        text
    }

    /// A key and its value; the same for 4 and 4.0.
    fn written(&self, key: &str) -> String {
        let value = match self.value(key) {
            Some(Value::Array(_)) if self.list(key).is_empty() => format!("{:?}", self.value(key)),
            Some(Value::Array(_)) => format!("{:?}", self.list(key)),
            Some(value) => {
                number(value).map_or_else(|| value.to_string(), |number| format!("{number:?}"))
            }
            None => String::new(),
        };
        format!("{key}={value};")
    }

    /// Torque with which springs at rest beyond their stops hold their joints there, newton metre: the largest of them.
    pub fn preload_nm(&self) -> f64 {
        let lists = ["rest_deg", "joint_min_deg", "spring_nm_per_rad"];
        let [rest, low, spring] = lists.map(|name| self.list(&format!("finger.{name}")));
        (1..rest.len())
            .map(|i| spring[i] * (low[i] - rest[i]).to_radians())
            .fold(0.0, f64::max)
    }

    /// A number; zero where there is none, which the check excludes for every key that must be there.
    pub fn number(&self, key: &str) -> f64 {
        self.value(key).and_then(number).unwrap_or_default()
    }

    /// A list of numbers; empty where there is none.
    pub fn list(&self, key: &str) -> Vec<f64> {
        let list = self.value(key).and_then(Value::as_array);
        list.into_iter().flatten().filter_map(number).collect()
    }

    /// A list of words; empty where there is none.
    pub fn words(&self, key: &str) -> Vec<&str> {
        let list = self.value(key).and_then(Value::as_array);
        list.into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .collect()
    }

    /// Whether something is so; false where nothing is said.
    pub fn flag(&self, key: &str) -> bool {
        self.value(key).and_then(Value::as_bool).unwrap_or_default()
    }

    /// A text; empty where there is none.
    pub fn text(&self, key: &str) -> &str {
        self.value(key).and_then(Value::as_str).unwrap_or_default()
    }

    /// Volt per ampere of the current sense: the bridge's mirror into its resistor, or an amplifier on a shunt.
    pub fn sense_volt_per_a(&self) -> f64 {
        if self.flag("shunt.fitted") {
            self.number("shunt.shunt_ohm") * self.number("shunt.gain_v_per_v")
        } else {
            self.number("sense.resistor_ohm") * self.number("sense.mirror_a_per_a")
        }
    }

    /// Its voltage at no current: the amplifier stands in the middle of the converter's reference.
    pub fn sense_zero_v(&self) -> f64 {
        if self.flag("shunt.fitted") {
            0.5 * self.number("sense.reference_v")
        } else {
            0.0
        }
    }

    /// Torque at the input link per ampere of the motor, less what the gears lose, newton metre per ampere.
    pub fn torque_nm_per_a(&self) -> f64 {
        [
            "motor.torque_constant_nm_per_a",
            "gearhead.ratio",
            "worm.ratio",
            "gearhead.efficiency",
            "worm.efficiency",
        ]
        .map(|key| self.number(key))
        .iter()
        .product()
    }

    /// Number of phalanges.
    pub fn phalanges(&self) -> usize {
        self.list("finger.length_m").len()
    }
}

/// Checks that a file has no section of which no key is read.
fn sections_are_known(own: &Table) -> Result<(), String> {
    let sections = schema::KEYS
        .iter()
        .filter_map(|key| key.name.split_once('.'));
    let mut known: Vec<&str> = sections.map(|(section, _)| section).collect();
    known.dedup();
    let mut tables = own.iter().filter(|(_, value)| value.is_table());
    match tables.find(|(name, _)| !known.contains(&name.as_str())) {
        None => Ok(()),
        Some((name, _)) => {
            let known = known.join(", ");
            Err(format!("unknown section [{name}]; there are: {known}"))
        }
    }
}

/// A number, written with or without a point.
#[expect(
    clippy::cast_precision_loss,
    reason = "values of scenes are far below 2^53"
)]
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(value) => Some(*value),
        Value::Integer(value) => Some(*value as f64),
        _ => None,
    }
}
