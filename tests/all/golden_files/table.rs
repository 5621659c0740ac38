//! A reference file: comment lines, a header, rows of comma-separated values.

use std::fmt;

/// Why a reference file could not be evaluated.
#[derive(Debug)]
pub struct FileError {
    /// The file.
    pub file: String,
    /// Its line, from 1; 0 where the file as a whole is meant.
    pub line: usize,
    /// What is wrong.
    pub what: String,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}: {}", self.file, self.what),
            line => write!(f, "{}:{line}: {}", self.file, self.what),
        }
    }
}

impl std::error::Error for FileError {}

/// A file read: its header and rows, values still text.
pub struct Table {
    /// File name without folder.
    pub name: String,
    columns: Vec<String>,
    rows: Vec<(usize, Vec<String>)>,
}

impl Table {
    /// Reads text.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileError> {
        let error = |line, what: String| FileError {
            file: name.to_owned(),
            line,
            what,
        };
        let mut lines = (1..)
            .zip(text.lines())
            .filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty());
        let (_, header) = lines
            .next()
            .ok_or_else(|| error(0, "no header".to_owned()))?;
        let split = |line: &str| {
            line.split(',')
                .map(|cell| cell.trim().to_owned())
                .collect::<Vec<_>>()
        };
        let columns = split(header);
        let mut rows = Vec::new();
        for (number, line) in lines {
            let cells = split(line);
            if cells.len() != columns.len() {
                return Err(error(
                    number,
                    format!("{} values under {} columns", cells.len(), columns.len()),
                ));
            }
            rows.push((number, cells));
        }
        Ok(Self {
            name: name.to_owned(),
            columns,
            rows,
        })
    }

    /// All of these columns are there.
    pub fn has(&self, columns: &[&str]) -> bool {
        columns
            .iter()
            .all(|column| self.columns.iter().any(|c| c == column))
    }

    /// Its rows.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|(line, cells)| Row {
            table: self,
            line: *line,
            cells,
            nudge: None,
        })
    }

    /// An error about the file as a whole.
    pub fn error(&self, what: String) -> FileError {
        FileError {
            file: self.name.clone(),
            line: 0,
            what,
        }
    }
}

/// One row.
#[derive(Clone, Copy)]
pub struct Row<'t> {
    table: &'t Table,
    /// Its line in the file.
    pub line: usize,
    cells: &'t [String],
    nudge: Option<(&'t str, f64)>,
}

impl<'t> Row<'t> {
    /// The same row with one value changed by a share of it: how much an answer depends on it.
    pub fn nudged(&self, column: &'t str, share: f64) -> Self {
        Self {
            nudge: Some((column, share)),
            ..*self
        }
    }

    /// The columns up to one, itself included: what a row gives before it says what follows from it.
    pub fn columns_to(&self, last: &str) -> &'t [String] {
        let end = self
            .table
            .columns
            .iter()
            .position(|c| c == last)
            .map_or(0, |i| i + 1);
        self.table.columns.get(..end).unwrap_or_default()
    }

    /// The text in a column.
    pub fn text(&self, column: &str) -> Result<&str, FileError> {
        let place = self.table.columns.iter().position(|c| c == column);
        place
            .and_then(|i| self.cells.get(i))
            .map(String::as_str)
            .ok_or_else(|| self.error(format!("column {column} is missing")))
    }

    /// The number in a column; `nan` and `inf` are numbers.
    pub fn f64(&self, column: &str) -> Result<f64, FileError> {
        let text = self.text(column)?;
        let value: f64 = text
            .parse()
            .map_err(|_| self.error(format!("{column} is {text:?}, not a number")))?;
        Ok(match self.nudge {
            Some((nudged, share)) if nudged == column => value * (1.0 + share),
            _ => value,
        })
    }

    /// The number in a column as the library gets it.
    pub fn f32(&self, column: &str) -> Result<f32, FileError> {
        Ok(self.f64(column)? as f32)
    }

    /// An error about this row.
    pub fn error(&self, what: String) -> FileError {
        FileError {
            file: self.table.name.clone(),
            line: self.line,
            what,
        }
    }
}
