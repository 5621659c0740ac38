// SPDX-License-Identifier: GPL-2.0-only
//! Log lines: decoded with the firmware's tables, printed as by a debug probe, parsed as events.

use defmt_decoder::{DecodeError, StreamDecoder};
use palpate::app::log::{Parsed, parse};

use crate::firmware::Firmware;

/// One decoded log line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Virtual time at which it was read, second.
    pub fetched_s: f64,
    /// Time stamp of the firmware as it prints it; empty if it has none.
    pub timestamp: String,
    /// Level, in lower case; empty for a plain print.
    pub level: String,
    /// The text.
    pub message: String,
    /// Source file and line.
    pub location: String,
}

impl Line {
    /// Seconds since boot by the firmware's clock, or the time at which it was read if it prints none.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.timestamp.parse().unwrap_or(self.fetched_s)
    }

    /// The line parsed as `name key=value ...`.
    #[must_use]
    pub fn event(&self) -> Event<'_> {
        Event::parse(&self.message)
    }
}

impl std::fmt::Display for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ", self.timestamp)?;
        if !self.level.is_empty() {
            write!(f, "[{:<5}] ", self.level.to_uppercase())?;
        }
        write!(f, "{}", self.message)?;
        if !self.location.is_empty() {
            write!(f, " ({})", self.location)?;
        }
        Ok(())
    }
}

/// A line parsed by the firmware's own grammar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event<'a> {
    /// Words before the first field.
    pub name: &'a str,
    parsed: Parsed<'a>,
}

impl<'a> Event<'a> {
    /// Parses a line.
    #[must_use]
    pub fn parse(line: &'a str) -> Self {
        let parsed = parse(line);
        Self {
            name: parsed.name,
            parsed,
        }
    }

    /// Fields in the order of the line.
    pub fn fields(&self) -> impl Iterator<Item = (&'a str, &'a str)> {
        self.parsed.fields()
    }

    /// A field's text.
    #[must_use]
    pub fn field(&self, key: &str) -> Option<&'a str> {
        self.parsed.field(key)
    }

    /// A field as a finite number.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.field(key)?
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
    }
}

/// Decodes a stream of frames.
pub(crate) struct Log<'f> {
    firmware: &'f Firmware,
    decoder: Option<Box<dyn StreamDecoder + Send + Sync + 'f>>,
    /// Frames that could not be decoded: the firmware dropped part of them.
    pub(crate) malformed: u64,
}

impl<'f> Log<'f> {
    pub(crate) fn new(firmware: &'f Firmware) -> Self {
        let decoder = firmware
            .table
            .as_ref()
            .map(|table| table.new_stream_decoder());
        Self {
            firmware,
            decoder,
            malformed: 0,
        }
    }

    /// After a reset the firmware begins a new stream.
    pub(crate) fn restart(&mut self) {
        *self = Self {
            malformed: self.malformed,
            ..Self::new(self.firmware)
        };
    }

    pub(crate) fn decode(&mut self, bytes: &[u8], fetched_s: f64) -> Vec<Line> {
        let mut lines = Vec::new();
        let (Some(decoder), Some(table)) = (&mut self.decoder, &self.firmware.table) else {
            return lines;
        };
        decoder.received(bytes);
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(Line {
                    fetched_s,
                    timestamp: frame
                        .display_timestamp()
                        .map(|t| t.to_string())
                        .unwrap_or_default(),
                    level: frame
                        .level()
                        .map(|l| l.as_str().to_owned())
                        .unwrap_or_default(),
                    message: frame.display_message().to_string(),
                    location: self
                        .firmware
                        .locations
                        .get(&frame.index())
                        .map(|l| format!("{}:{}", tail(&l.file.to_string_lossy()), l.line))
                        .unwrap_or_default(),
                }),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => {
                    self.malformed += 1;
                    if !table.encoding().can_recover() {
                        break;
                    }
                }
            }
        }
        lines
    }
}

/// The path from `src` on.
fn tail(path: &str) -> &str {
    path.rfind("src/").map_or(path, |at| &path[at..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_where_they_are_finite() {
        let event = Event::parse("located phalanx=2 k_mm=30.1 radius_mm=NaN settled=true");
        assert_eq!(event.name, "located");
        assert_eq!(event.number("k_mm"), Some(30.1));
        for key in ["radius_mm", "settled", "missing"] {
            assert_eq!(event.number(key), None);
        }
    }
}
