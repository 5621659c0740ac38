//! `size`: flash and RAM of firmware images, and a check for forbidden symbols.

use palpate_document::table::head;
use std::path::PathBuf;

use anyhow::{Context, Result};

use palpate::scene::Scene;

use palpate_image::{Footprint, Image, Symbol};

/// Budget of the default scene: flash.
pub const FLASH_MOST: u64 = 96 * 1024;
/// Statics in SRAM: tighter than what the linker has for them.
pub const RAM_MOST: u64 = 14 * 1024;
/// RAM that is never touched in the deepest run.
pub const RAM_FREE_LEAST: u64 = 6 * 1024;
/// SRAM1, SRAM2 and CCM SRAM, which follow each other.
pub const RAM_BYTES: u64 = 32 * 1024;

/// What follows `size`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Images: NAME=ELF; the first is the default scene, which has targets.
    #[arg(required = true)]
    images: Vec<String>,
    /// One JSON object a line.
    #[arg(long)]
    json: bool,
}

/// Something that no firmware image may carry, and why.
struct Forbidden {
    what: &'static str,
    matches: fn(&str) -> bool,
}

/// Soft double precision, square roots in software, and the crates that only the benchmarks use.
const FORBIDDEN: &[Forbidden] = &[
    Forbidden {
        what: "f64 in software",
        matches: is_soft_double,
    },
    Forbidden {
        what: "square root in software",
        matches: is_soft_root,
    },
    Forbidden {
        what: "a crate of the benchmarks",
        matches: |name| {
            ["nalgebra::", "numeris::"]
                .iter()
                .any(|of| name.contains(of))
        },
    },
];

fn is_soft_double(name: &str) -> bool {
    const AEABI: &[&str] = &[
        "add", "sub", "rsub", "mul", "div", "cmpeq", "cmplt", "cmple", "cmpge", "cmpgt", "cmpun",
        "2iz", "2uiz", "2lz", "2ulz", "2f", "cdcmpeq", "cdcmple", "cdrcmple",
    ];
    const GNU: &[&str] = &[
        "adddf3",
        "subdf3",
        "muldf3",
        "divdf3",
        "extendsfdf2",
        "truncdfsf2",
        "floatsidf",
        "floatunsidf",
        "floatdidf",
        "floatundidf",
        "fixdfsi",
        "fixunsdfsi",
        "fixdfdi",
        "fixunsdfdi",
        "ltdf2",
        "gtdf2",
        "ledf2",
        "gedf2",
        "eqdf2",
        "nedf2",
        "unorddf2",
    ];
    let last = name.rsplit("::").next().unwrap_or(name);
    last.strip_prefix("__aeabi_d")
        .is_some_and(|rest| AEABI.contains(&rest))
        || [
            "__aeabi_f2d",
            "__aeabi_i2d",
            "__aeabi_ui2d",
            "__aeabi_l2d",
            "__aeabi_ul2d",
        ]
        .contains(&last)
        || last
            .strip_prefix("__")
            .is_some_and(|rest| GNU.contains(&rest))
}

fn is_soft_root(name: &str) -> bool {
    matches!(name.rsplit("::").next(), Some("sqrt" | "sqrtf"))
}

/// What an image carries that it must not: names with the reason.
pub fn forbidden(image: &Image) -> Vec<(String, &'static str)> {
    image
        .symbols()
        .filter(|symbol| symbol.is_code)
        .map(Symbol::name)
        .flat_map(|name| {
            let carried = FORBIDDEN.iter().filter(|it| (it.matches)(&name));
            let told = carried.map(|it| (name.clone(), it.what));
            told.collect::<Vec<_>>()
        })
        .collect()
}

/// What not every scene has: a part of the names of its code, and of the type by which a scene chooses it. A scene of another
/// type may not carry it; that those of this type do shows that the name still finds something.
const FEATURES: &[(&str, &str)] = &[
    ("finger::tendon::", "finger::tendon::Tendon<"),
    ("finger::fourbar::", "finger::linkage::Linkage<"),
    ("finger::direct::", "finger::direct::Direct<"),
    (
        "return_cable::ReturnedContact::",
        "return_cable::ReturnCable",
    ),
    ("finger::build::Preloaded", "finger::build::Preloaded"),
    ("joint_sensor::HallSensor", "joint_sensor::HallSensor"),
    ("::start_joint", "joint_sensor::HallSensor"),
    ("sensing::location::Rigid", "sensing::location::Rigid"),
    ("sensing::location::Cable", "sensing::location::Cable"),
    ("::learn_from_press", "sensing::location::Cable"),
    ("log::events::object", "sensing::location::SoftObject"),
    ("following::watch::", "following::watch::Follow<"),
    ("finger::held::", "following::watch::Follow<"),
    ("following::changes::", "following::changes::Changes<"),
];

/// The types that a scene is made of; of an image that is no scene, nothing is expected or refused.
fn types(scene: &str) -> Option<&'static str> {
    fn name<S: Scene>() -> &'static str {
        std::any::type_name::<(S::Finger, S::Joint, S::Series, S::After)>()
    }
    palpate_scenes::for_scene!(scene, |S| name::<S>())
}

/// Features that a scene does not have and of which its image carries something, each with a name that shows it.
fn unused<'a>(types: Option<&str>, names: impl Iterator<Item = &'a str> + Clone) -> Vec<String> {
    FEATURES
        .iter()
        .filter(|(_, of)| types.is_some_and(|types| !types.contains(of)))
        .filter_map(|(part, _)| names.clone().find(|name| name.contains(part)))
        .map(str::to_owned)
        .collect()
}

/// Features that a scene has and of which its image shows nothing: their names no longer find them anywhere.
fn unfound<'a>(
    types: Option<&str>,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Vec<&'static str> {
    FEATURES
        .iter()
        .filter(|(_, of)| types.is_some_and(|types| types.contains(of)))
        .map(|(part, _)| *part)
        .filter(|part| !names.clone().any(|name| name.contains(part)))
        .collect()
}

/// A firmware image and what it weighs.
pub struct Row {
    scene: String,
    footprint: Footprint,
    forbidden: Vec<(String, &'static str)>,
    unused: Vec<String>,
    unfound: Vec<&'static str>,
    paths: Vec<String>,
}

impl Row {
    /// As an object of a line of its own.
    pub fn json(&self) -> serde_json::Value {
        let forbidden: Vec<&String> = self.forbidden.iter().map(|(name, _)| name).collect();
        serde_json::json!({
            "type": "size", "scene": self.scene, "flash_bytes": self.footprint.flash_bytes,
            "ram_bytes": self.footprint.ram_bytes, "ccm_bytes": self.footprint.ccm_bytes, "left_bytes": self.left(),
            "forbidden": forbidden, "unused": self.unused, "paths": self.paths,
        })
    }

    /// RAM apart from statics and code in CCM, bytes: stacks and spare room.
    pub fn left(&self) -> u64 {
        RAM_BYTES.saturating_sub(self.footprint.ram_bytes + self.footprint.ccm_bytes)
    }

    /// Name.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Code, constants, initial values.
    pub fn flash_bytes(&self) -> u64 {
        self.footprint.flash_bytes
    }

    /// Statics in SRAM.
    pub fn ram_bytes(&self) -> u64 {
        self.footprint.ram_bytes
    }

    /// Code and statics in CCM SRAM.
    pub fn ccm_bytes(&self) -> u64 {
        self.footprint.ccm_bytes
    }

    /// Number of functions that it must not carry.
    pub fn forbidden(&self) -> usize {
        self.forbidden.len()
    }
}

/// Reads images given as NAME=ELF.
pub fn rows(images: &[String]) -> Result<Vec<Row>> {
    images
        .iter()
        .map(|word| {
            let (scene, path) = word
                .split_once('=')
                .with_context(|| format!("'{word}' is not NAME=ELF"))?;
            let image = Image::open(&PathBuf::from(path))?;
            let (names, types): (Vec<String>, _) = (image.names().collect(), types(scene));
            let names = || names.iter().map(String::as_str);
            Ok(Row {
                scene: scene.to_owned(),
                footprint: image.footprint,
                forbidden: forbidden(&image),
                unused: unused(types, names()),
                unfound: unfound(types, names()),
                paths: image.machine_paths(),
            })
        })
        .collect()
}

/// The table, in Markdown.
pub fn table(rows: &[Row]) -> String {
    let mut text = head(
        "scene | flash, bytes | static RAM | code in CCM SRAM | left for stacks | f64, software sqrt, nalgebra | unused features",
    );
    for row in rows {
        let list = |names: usize| {
            if names == 0 {
                "none".to_owned()
            } else {
                format!("{names} PRESENT")
            }
        };
        let Footprint {
            flash_bytes,
            ram_bytes,
            ccm_bytes,
        } = row.footprint;
        text += &format!(
            "| {} | {flash_bytes} | {ram_bytes} | {ccm_bytes} | {} | {} | {} |\n",
            row.scene,
            row.left(),
            list(row.forbidden.len()),
            list(row.unused.len())
        );
    }
    text
}

/// What is wrong, a line each.
pub fn check(rows: &[Row]) -> Vec<String> {
    let mut wrong = Vec::new();
    for row in rows {
        let scene = &row.scene;
        wrong.extend(
            row.forbidden
                .iter()
                .map(|(symbol, why)| format!("{scene}: carries {symbol}: {why}")),
        );
        wrong.extend(
            row.unused
                .iter()
                .map(|symbol| format!("{scene}: carries {symbol}, which it does not use")),
        );
        wrong.extend(row.unfound.iter().map(|part| {
            format!("{scene}: nothing in it is named {part}: the look for what a scene does not use is blind to that")
        }));
        wrong.extend(
            row.paths
                .iter()
                .map(|path| format!("{scene}: carries a path of the building machine: {path}")),
        );
    }
    wrong
}

/// Targets of the default scene that are missed, a line each. The linker fails where an image does not fit the chip; these
/// are tighter.
pub fn missed(rows: &[Row]) -> Vec<String> {
    let Some(row) = rows.first() else {
        return Vec::new();
    };
    let weighed = [
        ("bytes of flash", row.footprint.flash_bytes, FLASH_MOST),
        ("bytes of static RAM", row.footprint.ram_bytes, RAM_MOST),
    ];
    weighed
        .into_iter()
        .filter(|(_, bytes, most)| bytes > most)
        .map(|(what, bytes, most)| {
            format!(
                "missed target: {}: {bytes} {what}, at most {most} were wanted",
                row.scene
            )
        })
        .collect()
}

/// Prints the table; false where an image carries what it must not.
pub fn run(arguments: &Arguments) -> Result<bool> {
    let rows = rows(&arguments.images)?;
    if arguments.json {
        for row in &rows {
            println!("{}", row.json());
        }
    } else {
        print!("{}", table(&rows));
    }
    for line in missed(&rows) {
        eprintln!("note: {line}");
    }
    let wrong = check(&rows);
    for line in &wrong {
        eprintln!("{line}");
    }
    Ok(wrong.is_empty())
}

#[cfg(test)]
mod tests {
    use super::{is_soft_double, is_soft_root, types, unfound, unused};

    #[test]
    fn knows_double_precision_by_both_names() {
        assert!(
            is_soft_double("__aeabi_dmul")
                && is_soft_double("__adddf3")
                && is_soft_double("__aeabi_f2d")
        );
        assert!(is_soft_double("compiler_builtins::float::add::__adddf3"));
        assert!(!is_soft_double("__aeabi_fmul") && !is_soft_double("__aeabi_uldivmod"));
        assert!(!is_soft_double("palpate::drive::double"));
    }

    #[test]
    fn a_feature_is_found_where_it_does_not_belong_and_missed_where_it_does() {
        let hall = [
            "palpate::finger::tendon::Tendon::x",
            "palpate::sensing::sensor::state::SensorState<F, H, palpate::sensing::location::Cable>::learn_from_press",
            "<palpate::sensing::sensor::Sensor<F, palpate::joint_sensor::HallSensor>>::update",
            "palpate::board::sampling::start_joint",
        ];
        let unused = |scene: &str| unused(types(scene), hall.into_iter());
        let unfound =
            |scene: &str, names: &[&'static str]| unfound(types(scene), names.iter().copied());
        assert_eq!(unused("tendon2-hall"), [""; 0]);
        assert_eq!(unfound("tendon2-hall", &hall), [""; 0]);
        assert_eq!(unused("tendon2"), hall[2..]);
        assert_eq!(unfound("tendon2-hall", &hall[..3]), ["::start_joint"]);
        // Of the tendon, the sensor, its pin, and the cable by two names.
        assert_eq!(unused("p70-rigid").len(), 5);
        assert_eq!(
            unfound("p70-rigid", &[]),
            ["finger::fourbar::", "sensing::location::Rigid"]
        );
        assert_eq!(types("no-scene"), None);
    }

    #[test]
    fn knows_a_square_root_in_software() {
        assert!(is_soft_root("libm::math::sqrtf") && is_soft_root("sqrt"));
        assert!(!is_soft_root("palpate::sensing::sqrt_rate"));
    }
}
