//! Log records that the firmware has dropped, and which of them a recording lacks.

use crate::stream::Event;

/// Counts them. The firmware tells the total since it started, a recording begins later.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Told last.
    total: u64,
    /// How many there were when the recording began, where something told.
    before: Option<u64>,
    recording: bool,
}

impl Losses {
    /// Takes a log line.
    pub fn event(&mut self, event: &Event) {
        let total = match event.name.as_str() {
            "boot" => 0,
            "log" => match event.number("dropped") {
                Some(total) => total.max(0.0) as u64,
                None => return,
            },
            _ => return,
        };
        if !self.recording {
            self.before = Some(total);
        }
        self.total = total;
    }

    /// Takes note of a sample: the recording has begun.
    pub fn sample(&mut self) {
        self.recording = true;
    }

    /// What a user has to know of them.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let lost = self.total.saturating_sub(self.before.unwrap_or_default());
        let since = match self.before {
            Some(_) => "",
            // A reader before this one has heard of earlier ones, if there were some.
            None => " since it started, those before the recording included",
        };
        (lost > 0).then(|| {
            format!(
                "the firmware dropped {lost} log records{since}, samples among them; `--commands 'trace on 2;run'` halves what the wire carries"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Message, parse};

    fn warning(lines: &[&str]) -> String {
        let mut losses = Losses::default();
        for line in lines {
            match parse(line) {
                Some(Message::Event(event)) => losses.event(&event),
                Some(Message::Sample(_)) => losses.sample(),
                _ => panic!("{line}"),
            }
        }
        losses.warning().unwrap_or_default()
    }

    const SAMPLE: &str = "sample time_us=1000 counts=0 current_a=0";

    /// A board that nobody read has dropped thousands before: they are none of the recording's.
    #[test]
    fn what_was_lost_before_the_recording_does_not_count() {
        assert_eq!(warning(&["log dropped=5000", SAMPLE, SAMPLE]), "");
        let told = warning(&["log dropped=5000", SAMPLE, "log dropped=5003"]);
        assert!(told.contains("dropped 3 log records,"), "{told}");
        let told = warning(&["boot version=1 scene=p70", SAMPLE, "log dropped=7"]);
        assert!(told.contains("dropped 7 log records,"), "{told}");
    }

    #[test]
    fn where_nothing_tells_how_many_there_were_that_is_said() {
        let told = warning(&[SAMPLE, "log dropped=7"]);
        assert!(told.contains("7 log records since it started"), "{told}");
    }
}
