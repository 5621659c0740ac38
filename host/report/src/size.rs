//! `size`: flash and RAM of firmware images, and a look for what they must not carry.

use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::elf::Image;

/// Limits of the default scene.
const FLASH_MOST: u64 = 64 * 1024;
const RAM_MOST: u64 = 12 * 1024;
/// SRAM1 and SRAM2.
const RAM_BYTES: u64 = 22 * 1024;

/// What follows `size`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Images: NAME=ELF; the first is the default scene, which limits apply to.
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
            ["nalgebra::", "numeris::", "libm::"]
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
        .flat_map(|symbol| {
            FORBIDDEN
                .iter()
                .filter(|forbidden| (forbidden.matches)(&symbol.name))
                .map(|forbidden| (symbol.name.clone(), forbidden.what))
        })
        .collect()
}

/// Prints the table; false where an image is too large or carries what it must not.
pub fn run(arguments: &Arguments) -> Result<bool> {
    let mut good = true;
    if !arguments.json {
        println!(
            "scene            flash      static RAM   CCM     left for stacks   f64, software sqrt, nalgebra"
        );
    }
    for (at, word) in arguments.images.iter().enumerate() {
        let (name, path) = word
            .split_once('=')
            .with_context(|| format!("'{word}' is not NAME=ELF"))?;
        let image = Image::read(&PathBuf::from(path))?;
        let footprint = image.footprint;
        let forbidden = forbidden(&image);
        let left = RAM_BYTES.saturating_sub(footprint.ram_bytes);
        if arguments.json {
            let names: Vec<&String> = forbidden.iter().map(|(name, _)| name).collect();
            println!(
                "{}",
                serde_json::json!({
                    "type": "size", "scene": name, "flash_bytes": footprint.flash_bytes,
                    "ram_bytes": footprint.ram_bytes, "ccm_bytes": footprint.ccm_bytes, "left_bytes": left,
                    "forbidden": names,
                })
            );
        } else {
            println!(
                "{name:<14} {:>7} B   {:>9} B   {:>5} B   {left:>8} B         {}",
                footprint.flash_bytes,
                footprint.ram_bytes,
                footprint.ccm_bytes,
                if forbidden.is_empty() {
                    "none"
                } else {
                    "PRESENT"
                }
            );
        }
        for (symbol, why) in &forbidden {
            good = false;
            eprintln!("{name}: carries {symbol}: {why}");
        }
        if at == 0 && (footprint.flash_bytes > FLASH_MOST || footprint.ram_bytes > RAM_MOST) {
            good = false;
            eprintln!(
                "{name}: more than {FLASH_MOST} bytes of flash or {RAM_MOST} bytes of static RAM"
            );
        }
    }
    Ok(good)
}

#[cfg(test)]
mod tests {
    use super::{is_soft_double, is_soft_root};

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
    fn knows_a_square_root_in_software() {
        assert!(is_soft_root("libm::math::sqrtf") && is_soft_root("sqrt"));
        assert!(!is_soft_root("palpate::sensing::sqrt_rate"));
    }
}
