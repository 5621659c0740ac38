//! Reference files: comments, a line of names, rows.

use std::collections::HashMap;
use std::path::Path;

use crate::finger::{Finger, FourBar, Stage};
use crate::real::Real;

/// What is wrong with a file.
pub type Error = String;

/// A reference file.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name without folder and ending.
    pub name: String,
    /// Comment lines, as they are.
    pub comments: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Cells, a row each.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or a row has another number of cells than the line of names.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let (comments, data): (Vec<&str>, Vec<&str>) =
            text.lines().partition(|line| line.starts_with('#'));
        let cells = |line: &&str| -> Vec<String> { line.split(',').map(str::to_owned).collect() };
        let mut data = data.iter().map(cells);
        let columns = data
            .next()
            .ok_or_else(|| format!("{}: no columns", path.display()))?;
        let rows: Vec<Vec<String>> = data.collect();
        if let Some(row) = rows.iter().find(|row| row.len() != columns.len()) {
            return Err(format!("{}: a row of {} cells", path.display(), row.len()));
        }
        let name = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let comments = comments.into_iter().map(str::to_owned).collect();
        Ok(Self {
            name,
            comments,
            columns,
            rows,
        })
    }

    /// The file's text as it stands here.
    #[must_use]
    pub fn text(&self) -> String {
        let columns = [self.columns.join(",")];
        let rows = self.rows.iter().map(|row| row.join(","));
        let lines = self.comments.iter().chain(&columns).cloned().chain(rows);
        lines.map(|line| line + "\n").collect()
    }

    /// A row with names.
    #[must_use]
    pub fn row(&self, index: usize) -> Row<'_> {
        let cells = self
            .columns
            .iter()
            .map(String::as_str)
            .zip(self.rows[index].iter().map(String::as_str));
        Row(cells.collect())
    }
}

/// A row by the names of its columns.
#[derive(Clone, Debug)]
pub struct Row<'a>(HashMap<&'a str, &'a str>);

impl<'a> Row<'a> {
    /// A row of cells and the names of their columns.
    pub fn of(cells: impl Iterator<Item = (&'a str, &'a str)>) -> Self {
        Self(cells.collect())
    }

    /// The text of a cell.
    ///
    /// # Panics
    /// There is no such column.
    #[must_use]
    pub fn text(&self, name: &str) -> &'a str {
        self.0
            .get(name)
            .unwrap_or_else(|| panic!("a column {name}"))
    }

    /// The row has this column.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// The number in a cell.
    ///
    /// # Panics
    /// There is no such column, or it is not a number.
    #[must_use]
    pub fn f64(&self, name: &str) -> f64 {
        self.text(name)
            .parse()
            .unwrap_or_else(|_| panic!("a number in {name}"))
    }

    /// The number in a cell, exactly.
    #[must_use]
    pub fn real(&self, name: &str) -> Real {
        Real::from(self.f64(name))
    }

    /// The phalanx in a cell, counted from 0.
    #[must_use]
    pub fn phalanx(&self, name: &str) -> usize {
        self.f64(name) as usize - 1
    }

    /// `prefix1`, `prefix2` and so on, as far as there are columns.
    fn numbered(&self, prefix: &str, suffix: &str) -> Vec<Real> {
        let names = (1..).map(|index| format!("{prefix}{index}{suffix}"));
        names
            .take_while(|name| self.has(name))
            .map(|name| self.real(&name))
            .collect()
    }

    /// The finger that the row describes.
    #[must_use]
    pub fn finger(&self) -> Finger {
        let lengths = self.numbered("l", "");
        let stages = (1..lengths.len()).map(|stage| {
            if self.has("r1") {
                let [driving, driven] =
                    [2 * stage - 1, 2 * stage].map(|index| self.real(&format!("r{index}")));
                return Stage::Tendon(driven / driving);
            }
            let ground = lengths[stage - 1].clone();
            let bar = |name: &str| self.real(&format!("{name}{stage}"));
            Stage::linkage(FourBar::of(ground, bar))
        });
        let stages = stages.collect();
        Finger {
            springs: self.numbered("K", ""),
            rest: self.numbered("th", "0"),
            lengths,
            stages,
        }
    }
}
