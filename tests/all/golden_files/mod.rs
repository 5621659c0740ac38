//! Reference files against the library: reading, evaluating, judging. Used by the library's tests and by the report.

mod families;
mod fingers;
mod measure;
mod table;

pub use measure::FileReport;
pub use table::FileError;

/// Evaluates the library on every row of one file.
///
/// # Errors
/// A file that cannot be read, is of no known family, or has a malformed row.
pub fn evaluate(path: &std::path::Path) -> Result<FileReport, FileError> {
    let name = path
        .file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned();
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|error| FileError {
        file: name.clone(),
        line: 0,
        what: error.to_string(),
    })?;
    evaluate_text(&name, &text)
}

/// Evaluates text as if it were a file of that name.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_text(name: &str, text: &str) -> Result<FileReport, FileError> {
    families::evaluate(&table::Table::parse(name, text)?)
}
