//! `palpate-image check ELF...`: the rules for an image; `palpate-image size NAME=ELF...`: what it takes.

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use palpate_image::Image;

/// The control interrupt.
const CONTROL: &str = "ADC1_2";
/// What the default scene may take, bytes.
const FLASH_LIMIT: u64 = 64 * 1024;
const RAM_LIMIT: u64 = 12 * 1024;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.split_first() {
        Some((command, files)) if command == "check" && !files.is_empty() => check(files),
        Some((command, files)) if command == "size" && !files.is_empty() => size(files),
        _ => {
            eprintln!("usage: palpate-image check ELF...\n       palpate-image size NAME=ELF...");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Prints what breaks a rule; true if nothing does.
fn check(files: &[String]) -> Result<bool> {
    let mut good = true;
    for file in files {
        let image = Image::open(Path::new(file))?;
        for function in image.software_doubles() {
            println!("{file}: software double precision: {}", function.name());
            good = false;
        }
        let reach = image.reach(CONTROL)?;
        for violation in &reach.violations {
            println!(
                "{file}: {CONTROL} reaches {:#010x}, which {}: {}",
                violation.address,
                violation.what,
                violation.path.join(" > ")
            );
            good = false;
        }
        println!(
            "{file}: {CONTROL} reaches {} functions, {} instructions, {} violations",
            reach.functions.len(),
            reach.instructions,
            reach.violations.len()
        );
    }
    Ok(good)
}

/// Prints flash and static RAM of each image against the limits; true if all keep them.
fn size(files: &[String]) -> Result<bool> {
    let mut good = true;
    println!("{:<12} {:>8} {:>8}", "scene", "flash B", "RAM B");
    for word in files {
        let Some((name, file)) = word.split_once('=') else {
            bail!("`{word}` is not NAME=ELF");
        };
        let size = Image::open(Path::new(file)).context("size")?.size();
        let fits = size.flash <= FLASH_LIMIT && size.ram <= RAM_LIMIT;
        let remark = if fits { "" } else { "  over the limit" };
        println!("{name:<12} {:>8} {:>8}{remark}", size.flash, size.ram);
        good &= fits;
    }
    println!("{:<12} {FLASH_LIMIT:>8} {RAM_LIMIT:>8}", "limit");
    Ok(good)
}
