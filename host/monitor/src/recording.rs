//! Samples into a file that `replay` reads, each with the lines that the firmware logged before it: states tell what a sample
//! was used for, so that the sensing can be run on it again exactly, and events tell what it said live.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use palpate::app::log::BETWEEN_LINES;

use crate::stream::{Event, Message, Sample, parse};

/// Columns, as `replay` names them.
pub const HEADER: &str = "time_s,encoder_counts,current_a,emf_v,duty,joint_rad,log";

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
        let text = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        write!(
            self.file,
            // Current, back-EMF and joint 2 with all their digits: what is replayed is what the firmware saw.
            "{:.6},{:.0},{},{},{},{},",
            sample.time_s,
            sample.counts,
            sample.current_a,
            text(sample.emf_v),
            sample.duty,
            text(sample.joint_rad)
        )?;
        if !self.log.is_empty() {
            let log = self.log.join(BETWEEN_LINES).replace('"', "\"\"");
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

/// Reads a recording, row by row: what [`Recording`] took comes out again.
#[derive(Debug)]
pub struct Rows {
    /// Places of time, counts and current.
    needed: [usize; 3],
    emf: Option<usize>,
    duty: Option<usize>,
    joint: Option<usize>,
    log: Option<usize>,
}

impl Rows {
    /// By a file's first line; `None` where that is not the head of a recording.
    #[must_use]
    pub fn of(head: &str) -> Option<Self> {
        let at = |name: &str| head.split(',').position(|column| column.trim() == name);
        Some(Self {
            needed: [at("time_s")?, at("encoder_counts")?, at("current_a")?],
            emf: at("emf_v"),
            duty: at("duty"),
            joint: at("joint_rad"),
            log: at("log"),
        })
    }

    /// The log lines before a sample, then the sample; nothing where a number is none.
    #[must_use]
    pub fn messages(&self, row: &str) -> Vec<Message> {
        // Only the last column, the log, may hold a comma.
        let cells: Vec<&str> = row
            .splitn(self.log.map_or(usize::MAX, |at| at + 1), ',')
            .collect();
        let number = |at: usize| cells.get(at)?.trim().parse::<f64>().ok();
        let [Some(time_s), Some(counts), Some(current_a)] = self.needed.map(number) else {
            return Vec::new();
        };
        let log = self
            .log
            .and_then(|at| cells.get(at))
            .copied()
            .unwrap_or_default();
        let log = log.trim();
        let quoted = log.strip_prefix('"').and_then(|log| log.strip_suffix('"'));
        let log = quoted.unwrap_or(log).replace("\"\"", "\"");
        let lines = log
            .split(BETWEEN_LINES)
            .filter_map(parse)
            .map(|message| match message {
                // The column has the text alone: what came with a sample was said at its time.
                Message::Event(event) => Message::Event(Event {
                    time_s: event.time_s.or(Some(time_s)),
                    ..event
                }),
                other => other,
            });
        let sample = Sample {
            time_s,
            counts,
            current_a,
            emf_v: self.emf.and_then(number),
            // The sign of the current tells the direction as well as a file without it allows.
            duty: self.duty.and_then(number).unwrap_or(current_a.signum()),
            joint_rad: self.joint.and_then(number),
            ..Sample::default()
        };
        lines.chain([Message::Sample(sample)]).collect()
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
            emf_v: Some(-3.4),
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
            "time_s,encoder_counts,current_a,emf_v,duty,joint_rad,log\n\
             0.001000,12,0.0151,-3.4,-1,,\"state name=close | answer \"\"ok\"\" n=1, 2\"\n\
             0.001000,12,0.0151,-3.4,-1,0.25,\n"
        );
        std::fs::remove_file(path).expect("the file is there");
    }
}
