//! Samples into a file that `replay` reads.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::stream::Sample;

/// Columns, as `replay` names them.
const HEADER: &str = "time_s,encoder_counts,current_a,duty";

/// A file being written.
#[derive(Debug)]
pub struct Recording {
    file: BufWriter<File>,
    path: PathBuf,
    rows: u64,
}

impl Recording {
    /// Creates the file and writes its header.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        let mut file = BufWriter::new(File::create(path)?);
        writeln!(file, "{HEADER}")?;
        Ok(Self {
            file,
            path: path.to_owned(),
            rows: 0,
        })
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Rows written.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn sample(&mut self, sample: &Sample) -> std::io::Result<()> {
        self.rows += 1;
        writeln!(
            self.file,
            // The current with all its digits: what is replayed is what the firmware saw.
            "{:.6},{:.0},{},{}",
            sample.time_s, sample.counts, sample.current_a, sample.duty
        )
    }

    /// Writes what is still buffered; the number of rows.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> std::io::Result<u64> {
        self.file.flush()?;
        Ok(self.rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_what_replay_reads() {
        let path = std::env::temp_dir().join(format!("palpate-record-{}.csv", std::process::id()));
        let mut recording = Recording::create(&path).expect("a temporary file");
        recording
            .sample(&Sample {
                time_s: 0.001,
                counts: 12.0,
                current_a: 0.0151,
                duty: -0.25,
                ..Sample::default()
            })
            .expect("a row");
        assert_eq!(recording.finish().expect("written"), 1);
        let text = std::fs::read_to_string(&path).expect("the file");
        assert_eq!(
            text,
            "time_s,encoder_counts,current_a,duty\n0.001000,12,0.0151,-0.25\n"
        );
        std::fs::remove_file(path).expect("the file is there");
    }
}
