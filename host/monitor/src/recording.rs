//! Samples into a file that `replay` reads, each with the lines that the firmware logged before it: states tell what a sample
//! was used for, so that the sensing can be run on it again exactly, and events tell what it said live.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::stream::{Event, Message, Sample};

/// Columns, as `replay` names them.
const HEADER: &str = "time_s,encoder_counts,current_a,duty,joint_rad,log";
/// Between two lines that were logged before the same sample.
const SEPARATOR: &str = " | ";

/// A file being written.
#[derive(Debug)]
pub struct Recording {
    file: BufWriter<File>,
    path: PathBuf,
    rows: u64,
    /// What was logged since the last sample.
    log: Vec<String>,
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
            log: Vec::new(),
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

    /// Takes what a source says: samples and log lines, nothing else.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn take(&mut self, message: &Message) -> std::io::Result<()> {
        match message {
            Message::Sample(sample) => return self.sample(sample),
            Message::Event(event) => self.event(event),
            Message::Truth { .. } | Message::Note(_) => {}
        }
        Ok(())
    }

    /// Takes a log line: it is written with the next sample.
    pub fn event(&mut self, event: &Event) {
        self.log.push(event.text());
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn sample(&mut self, sample: &Sample) -> std::io::Result<()> {
        self.rows += 1;
        let joint = sample.joint_rad.map(|rad| rad.to_string());
        write!(
            self.file,
            // Current and joint 2 with all their digits: what is replayed is what the firmware saw.
            "{:.6},{:.0},{},{},{},",
            sample.time_s,
            sample.counts,
            sample.current_a,
            sample.duty,
            joint.unwrap_or_default()
        )?;
        if !self.log.is_empty() {
            let log = self.log.join(SEPARATOR).replace('"', "\"\"");
            self.log.clear();
            write!(self.file, "\"{log}\"")?;
        }
        writeln!(self.file)
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
        let line = |name: &str, key: &str, value: &str| Event {
            name: name.to_owned(),
            fields: vec![(key.to_owned(), value.to_owned())],
            ..Event::default()
        };
        recording.event(&line("state", "name", "close"));
        recording.event(&line("answer \"ok\"", "n", "1, 2"));
        let sample = Sample {
            time_s: 0.001,
            counts: 12.0,
            current_a: 0.0151,
            duty: -1.0,
            ..Sample::default()
        };
        recording.sample(&sample).expect("a row");
        let joint_rad = Some(0.25);
        recording
            .sample(&Sample {
                joint_rad,
                ..sample
            })
            .expect("a row");
        assert_eq!(recording.finish().expect("written"), 2);
        let text = std::fs::read_to_string(&path).expect("the file");
        assert_eq!(
            text,
            "time_s,encoder_counts,current_a,duty,joint_rad,log\n\
             0.001000,12,0.0151,-1,,\"state name=close | answer \"\"ok\"\" n=1, 2\"\n\
             0.001000,12,0.0151,-1,0.25,\n"
        );
        std::fs::remove_file(path).expect("the file is there");
    }
}
