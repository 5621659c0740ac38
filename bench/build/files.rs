//! Reading the reference files: comment lines, a line of column names, rows.

use std::collections::HashMap;
use std::path::Path;

/// A file.
pub struct Table {
    columns: HashMap<String, usize>,
    cells: Vec<Vec<String>>,
}

/// One of its rows.
pub struct Row<'a> {
    table: &'a Table,
    cells: &'a [String],
}

impl Table {
    /// Reads a file; the build fails where there is none.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut lines = text
            .lines()
            .filter(|line| !line.starts_with('#') && !line.is_empty());
        let names = lines.next().unwrap_or_default().split(',');
        let columns = names
            .enumerate()
            .map(|(at, name)| (name.to_owned(), at))
            .collect();
        let cells = lines
            .map(|line| line.split(',').map(str::to_owned).collect())
            .collect();
        Self { columns, cells }
    }

    /// Its rows in order.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.cells.iter().map(|cells| Row { table: self, cells })
    }
}

impl Row<'_> {
    /// The number in a column; the build fails where there is none.
    pub fn number(&self, column: &str) -> f64 {
        let at = *self
            .table
            .columns
            .get(column)
            .unwrap_or_else(|| panic!("no column {column}"));
        self.cells[at]
            .parse()
            .unwrap_or_else(|_| panic!("{column} is {}", self.cells[at]))
    }

    /// Several columns.
    pub fn numbers<const N: usize>(&self, columns: [&str; N]) -> [f64; N] {
        columns.map(|column| self.number(column))
    }
}
