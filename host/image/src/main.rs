//! `palpate-reach ELF...`: proves of each image that its control interrupt cannot panic, allocate or log, and runs from CCM
//! SRAM alone, that no function of the modules that compute reaches a panic, that its first instruction reads the SRAM before
//! anything is written, and that a barrier follows wherever the core sleeps.

use std::path::Path;
use std::process::ExitCode;

use anyhow::Result;
use palpate_image::{CCM, Image};

/// The control interrupt.
const CONTROL: &str = "ADC1_2";

/// Modules that compute what moves the motor and what is said of a contact.
const COMPUTING: [&str; 5] = [
    "palpate::drive",
    "palpate::finger",
    "palpate::joint_sensor",
    "palpate::numeric",
    "palpate::sensing",
];

/// What reads a word of each block of SRAM (`src/board/ram.rs`).
const READS_RAM: &str = "__pre_init";

fn main() -> ExitCode {
    let files: Vec<String> = std::env::args().skip(1).collect();
    if files.is_empty() || files.iter().any(|word| word.starts_with('-')) {
        eprintln!("usage: palpate-reach ELF...");
        return ExitCode::from(2);
    }
    let mut good = true;
    for file in &files {
        match check(Path::new(file)) {
            Ok(proved) => good &= proved,
            Err(error) => {
                eprintln!("error: {error:#}");
                good = false;
            }
        }
    }
    if good {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Prints what breaks a rule; true if nothing does.
fn check(file: &Path) -> Result<bool> {
    let image = Image::open(file)?;
    let first = image.first_call().map(palpate_image::Symbol::name);
    let reads_ram = first.as_deref() == Some(READS_RAM);
    if !reads_ram {
        println!(
            "{}: the first instruction after a reset calls {}, not {READS_RAM}",
            file.display(),
            first.as_deref().unwrap_or("nothing")
        );
    }
    let sleeps = image.sleeps();
    for function in &sleeps.bare {
        println!(
            "{}: {} sleeps without a barrier",
            file.display(),
            function.name()
        );
    }
    let reach = image.reach(CONTROL, &CCM)?;
    let panics = image.panics(&COMPUTING);
    for (from, found) in [(CONTROL, &reach), ("what computes", &panics)] {
        for violation in &found.violations {
            println!(
                "{from} reaches {:#010x}, which {}: {}",
                violation.address,
                violation.what,
                violation.path.join(" > ")
            );
        }
    }
    println!(
        "{}: {CONTROL} reaches {} functions, {} bytes, {} instructions, {} violations",
        file.display(),
        reach.functions.len(),
        reach.functions.iter().map(|f| f.size).sum::<u32>(),
        reach.instructions,
        reach.violations.len()
    );
    println!(
        "{}: {} functions that compute or are called there reach {} panics",
        file.display(),
        panics.functions.len(),
        panics.violations.len()
    );
    // Without names there is nothing to start at, and nothing is proved.
    let is_proved = !panics.functions.is_empty() && panics.violations.is_empty();
    println!("{}: {} sleeps", file.display(), sleeps.number);
    let sleeps_well = sleeps.number > 0 && sleeps.bare.is_empty();
    Ok(reads_ram && sleeps_well && reach.violations.is_empty() && is_proved)
}
