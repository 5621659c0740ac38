//! Sections of a document that a program writes, between two markers.

use std::path::Path;

/// The markers: begin and end.
#[derive(Clone, Copy, Debug)]
pub struct Markers {
    /// How the line of the first begins.
    pub begin: &'static str,
    /// The last.
    pub end: &'static str,
}

/// Why a section cannot be read or written.
#[derive(Debug)]
pub enum SectionError {
    /// The file has no place for it.
    NoMarkers {
        /// The file.
        file: String,
        /// What it lacks.
        markers: Markers,
    },
    /// The file cannot be read or written.
    Io(std::io::Error),
}

impl std::fmt::Display for SectionError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoMarkers { file, markers } => {
                let Markers { begin, end } = markers;
                write!(out, "{file} has no markers '{begin} ... -->' and '{end}'")
            }
            Self::Io(error) => write!(out, "{error}"),
        }
    }
}

impl std::error::Error for SectionError {}

impl From<std::io::Error> for SectionError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

impl Markers {
    /// The text before, between (from the first marker on) and behind.
    #[must_use]
    pub fn split<'a>(&self, text: &'a str) -> Option<[&'a str; 3]> {
        let begin = text.find(self.begin)?;
        let end = begin + text[begin..].find(self.end)?;
        Some([
            &text[..begin],
            &text[begin..end],
            &text[end + self.end.len()..],
        ])
    }

    /// `text` with another section; `rest` ends the line of the first marker.
    #[must_use]
    pub fn replaced(&self, text: &str, rest: &str, body: &str) -> Option<String> {
        let Self { begin, end } = self;
        let [before, _, after] = self.split(text)?;
        let body = body.trim();
        Some(format!("{before}{begin}{rest}\n\n{body}\n\n{end}{after}"))
    }

    /// Writes another section into a file.
    ///
    /// # Errors
    /// [`SectionError`].
    pub fn write(&self, file: &Path, rest: &str, body: &str) -> Result<(), SectionError> {
        let text = std::fs::read_to_string(file)?;
        let text = self.replaced(&text, rest, body);
        Ok(std::fs::write(
            file,
            text.ok_or_else(|| self.missing(file))?,
        )?)
    }

    /// The section of a file, from the first marker on.
    ///
    /// # Errors
    /// [`SectionError`].
    pub fn read(&self, file: &Path) -> Result<String, SectionError> {
        let text = std::fs::read_to_string(file)?;
        let [_, section, _] = self.split(&text).ok_or_else(|| self.missing(file))?;
        Ok(section.to_owned())
    }

    fn missing(&self, file: &Path) -> SectionError {
        SectionError::NoMarkers {
            file: file.display().to_string(),
            markers: *self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Markers;

    #[test]
    fn what_stands_around_the_markers_stays() {
        let markers = Markers {
            begin: "<!-- x: begin",
            end: "<!-- x: end -->",
        };
        let text = "a\n<!-- x: begin, by hand -->\nold\n<!-- x: end -->\nb\n";
        let once = markers
            .replaced(text, ", written -->", "new\n")
            .expect("the markers are there");
        assert_eq!(
            once,
            "a\n<!-- x: begin, written -->\n\nnew\n\n<!-- x: end -->\nb\n"
        );
        assert_eq!(
            markers.replaced(&once, ", written -->", "new").as_ref(),
            Some(&once)
        );
        assert_eq!(markers.replaced("no markers", "", "new"), None);
    }
}
