//! `golden`: the f32 library on every row of a folder of reference files.

// The very evaluation that the library's own tests run.
#[path = "../../../tests/all/golden_files/mod.rs"]
mod golden_files;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use golden_files::{FileError, FileReport};
use serde_json::json;

/// How many misclassified rows are listed.
const LISTED: usize = 5;

/// Arguments of `golden`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of reference files (*.csv).
    dir: PathBuf,
    /// One JSON object a file instead of tables.
    #[arg(long)]
    json: bool,
}

/// Evaluates every reference file of the folder and prints what came out; true if every limit holds.
///
/// # Errors
/// A folder that cannot be read or holds no reference file. A file that cannot be understood is reported, counts as
/// failed, and does not keep the others from being evaluated.
pub fn run(arguments: &Arguments) -> anyhow::Result<bool> {
    let files = reference_files(&arguments.dir)?;
    let mut passes = true;
    for file in &files {
        match golden_files::evaluate(file) {
            Ok(report) => {
                passes &= report.passes();
                if arguments.json {
                    print_json(&report)
                } else {
                    print_table(&report)
                }
            }
            Err(error) => {
                passes = false;
                print_error(&error, arguments.json);
            }
        }
    }
    if !arguments.json {
        println!(
            "{} files: {}",
            files.len(),
            if passes {
                "every limit holds"
            } else {
                "FAILED"
            }
        );
    }
    Ok(passes)
}

fn reference_files(dir: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let entries = std::fs::read_dir(dir)
        .with_context(|| format!("cannot read the folder {}", dir.display()))?;
    for entry in entries {
        let path = entry
            .with_context(|| format!("cannot read the folder {}", dir.display()))?
            .path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            files.push(path);
        }
    }
    if files.is_empty() {
        bail!("{} holds no reference file (*.csv)", dir.display());
    }
    files.sort();
    Ok(files)
}

fn print_json(report: &FileReport) {
    let quantities: Vec<_> = report
        .quantities
        .iter()
        .map(|quantity| {
            json!({
                "name": quantity.name,
                "rows": quantity.rows(),
                "median": quantity.quantile(0.5),
                "p99": quantity.quantile(0.99),
                "max": quantity.quantile(1.0),
                "nonfinite": quantity.nonfinite,
                "pass": quantity.passes(),
            })
        })
        .collect();
    let listed: Vec<_> = report
        .misclassified
        .iter()
        .take(LISTED)
        .map(|(l, w)| json!({"line": l, "what": w}))
        .collect();
    let file = json!({
        "type": "file",
        "file": report.file,
        "rows": report.rows,
        "quantities": quantities,
        "misclassified": report.misclassified.len(),
        "misclassified_rows": listed,
        "pass": report.passes(),
    });
    println!("{file}");
}

fn print_table(report: &FileReport) {
    let verdict = if report.passes() { "pass" } else { "FAIL" };
    println!(
        "{}: {} rows, {} misclassified: {verdict}",
        report.file,
        report.rows,
        report.misclassified.len()
    );
    for quantity in &report.quantities {
        println!("  {quantity}");
    }
    for (line, what) in report.misclassified.iter().take(LISTED) {
        println!("  line {line}: {what}");
    }
}

fn print_error(error: &FileError, json: bool) {
    if json {
        println!(
            "{}",
            json!({"type": "error", "file": error.file, "line": error.line, "message": error.what, "pass": false})
        );
    } else {
        println!("{error}: FAIL");
    }
}

#[cfg(test)]
mod tests {
    use super::golden_files::evaluate_text;

    const HEADER: &str = "g,a,b,c,psi,mode,v,gamma,F,h,x,dx,d2x,status\n";

    #[test]
    fn a_malformed_row_is_named_by_its_line() {
        let text = format!("# comment\n{HEADER}1,2,3\n");
        let error = evaluate_text("x.csv", &text).expect_err("three values under fourteen columns");
        assert_eq!(
            (
                error.line,
                error.to_string().starts_with("x.csv:3: 3 values")
            ),
            (3, true),
            "{error}"
        );
        let text = format!("{HEADER}1,zero,1,1,0,-1,0,0,0,0,0,0,0,ok\n");
        let error = evaluate_text("x.csv", &text).expect_err("a word for a number");
        assert!(
            error.to_string().contains("a is \"zero\", not a number"),
            "{error}"
        );
    }

    #[test]
    fn an_unknown_header_is_refused_and_an_empty_file_does_not_pass() {
        let error = evaluate_text("x.csv", "a,b\n1,2\n").expect_err("no family has that header");
        assert!(error.to_string().contains("no known family"), "{error}");
        assert!(evaluate_text("x.csv", "# nothing\n").is_err());
        assert!(
            !evaluate_text("x.csv", HEADER)
                .expect("a header alone can be read")
                .passes()
        );
    }

    #[test]
    fn a_wrong_reference_fails() {
        // The four-bar of P70 at v = 0 has x = 0.4577; a file that says otherwise must not pass.
        let row =
            |x: &str| format!("{HEADER}90,60,104,30,2.094395,-1,0,-0.2,0,75.96,{x},0.297,nan,ok\n");
        let judged = |x| evaluate_text("x.csv", &row(x)).expect("a well-formed row");
        let worst = |x| {
            judged(x)
                .quantities
                .iter()
                .find(|q| q.name == "x, over 1")
                .map(|q| q.quantile(1.0))
        };
        assert!(worst("0.4577").is_some_and(|e| e < 1e-4));
        assert!(worst("0.4677").is_some_and(|e| e > 9e-3));
        assert!(!judged("0.4677").passes());
    }
}
