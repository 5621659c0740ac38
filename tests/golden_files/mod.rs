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
    families::evaluate(&table::Table::read(path)?)
}

/// Evaluates text as if it were a file of that name.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_text(name: &str, text: &str) -> Result<FileReport, FileError> {
    families::evaluate(&table::Table::parse(name, text)?)
}
