//! Compares the reference files with recomputed values, or rewrites them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use palpate_golden::table::Table;
use palpate_golden::{compare, generate, is_recomputing, sample};

/// Largest relative difference that rounding to f64 explains, with the last digit of the other evaluation.
const ROUNDING: f64 = 4.5e-16;

#[derive(Parser)]
#[command(
    name = "palpate-golden",
    about = "Recomputes the reference files from positions and energy, with 77 digits",
    after_help = "Examples:\n  cargo xtask golden --generator --rows 3\n  cargo xtask golden --generator --only kc --all"
)]
struct Arguments {
    /// Folder of the reference files.
    #[arg(long, default_value = "tests/data/golden")]
    directory: PathBuf,
    /// Only files whose name begins so.
    #[arg(long)]
    only: Option<String>,
    /// Rows of each file.
    #[arg(long, default_value_t = 12)]
    rows: usize,
    /// Compare every row, not a sample.
    #[arg(long, conflicts_with = "rows")]
    all: bool,
    /// Write the files with recomputed outputs into this folder instead of comparing.
    #[arg(long, value_name = "DIR")]
    generate: Option<PathBuf>,
    /// Also draw the inputs of a new file with this many rows, for example `kc_4L`: a kind, the number of phalanges, and T
    /// for tendon or L for linkage.
    #[arg(long, value_name = "NAME", requires = "generate")]
    new: Option<String>,
}

/// Writes a file into a folder.
fn write(directory: &Path, name: &str, text: &str) -> Result<(), String> {
    let target = directory.join(name);
    std::fs::create_dir_all(directory)
        .and_then(|()| std::fs::write(&target, text))
        .map_err(|error| format!("{}: {error}", target.display()))?;
    println!("written file={}", target.display());
    Ok(())
}

fn files(directory: &Path, only: &str) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(directory)
        .map_err(|error| format!("{}: {error}", directory.display()))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .collect();
    files.retain(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.ends_with(".csv") && name.starts_with(only)
    });
    files.sort();
    Ok(files)
}

/// True where every file agrees.
fn run(arguments: &Arguments) -> Result<bool, String> {
    if arguments.rows == 0 {
        return Err("--rows = 0 compares nothing, allowed 1 and more".to_owned());
    }
    if let (Some(name), Some(directory)) = (&arguments.new, &arguments.generate) {
        let table = palpate_golden::inputs::table(name, arguments.rows)?;
        write(directory, &format!("{name}.csv"), &table.text())?;
        return Ok(true);
    }
    let files = files(
        &arguments.directory,
        arguments.only.as_deref().unwrap_or_default(),
    )?;
    if files.is_empty() {
        return Err(format!(
            "{}: no reference files",
            arguments.directory.display()
        ));
    }
    let mut agree = true;
    let bar = palpate_cli::progress::bar(files.len(), "files");
    for file in files {
        let table = Table::read(&file)?;
        if let Some(directory) = &arguments.generate {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let text = generate(&table)?;
            bar.suspend(|| write(directory, &name, &text))?;
            bar.inc(1);
            continue;
        }
        let count = if arguments.all {
            table.rows.len()
        } else {
            arguments.rows
        };
        let found = compare(&table, sample(&table, count))?;
        if found.cells == 0 {
            return Err(format!("{}: no rows to compare", file.display()));
        }
        agree &= found.worst.deviation <= ROUNDING;
        bar.inc(1);
        bar.suspend(|| println!(
            "compared file={} rows={} cells={} equal={} largest_relative={:.1e} row={} column={}",
            table.name,
            found.rows,
            found.cells,
            found.equal,
            found.worst.deviation,
            found.worst.row,
            found.worst.column
        ));
    }
    bar.finish_and_clear();
    Ok(agree)
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // A panic that refuses a row is told as an error. Print any other: it is a fault of this program.
    std::panic::set_hook(Box::new(|panic| {
        if !is_recomputing() {
            eprintln!("palpate-golden: {panic}");
        }
    }));
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!(
                "palpate-golden: a recomputed value differs by more than the rounding of f64"
            );
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("palpate-golden: {error}");
            ExitCode::from(2)
        }
    }
}
