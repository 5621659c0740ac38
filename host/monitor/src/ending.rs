//! When a recording has what it was asked for.

use std::time::Duration;

use crate::stream::Event;

/// How long a recording goes on after the motion, for what the sensing still has to say, and for a motion after a refusal, second.
const LAST_WORD_S: f64 = 0.5;
/// A source that is as long without a word when nothing more is expected has no more to say: nobody asked for samples.
const SILENCE: Duration = Duration::from_secs(2);
/// Lines whose time falls by more than this, second, come from a firmware that has restarted. Less is not taken for that (chosen).
const RESTARTED_S: f64 = 0.1;
/// What is told to have ended a motion then.
const RESTART: &str = "restart";
/// What is told where a fault has ended a motion and the line that names it has not come (a record may be dropped).
const UNNAMED: &str = "its line did not come";

/// Follows a recording to its end.
#[derive(Debug, Default)]
pub struct Ending {
    /// Length that the user asked for.
    seconds: Option<f64>,
    /// Somebody reads the commands: refusals are about this recording.
    asked: bool,
    first_s: Option<f64>,
    /// The last line that has a time.
    last_s: Option<f64>,
    /// The motion's end.
    done_s: Option<f64>,
    /// The fault that ended it.
    fault: Option<String>,
    moving: bool,
    /// The answer to a command that is not carried out, while nothing moves.
    refused: Option<String>,
    /// The first sample after it.
    refused_s: Option<f64>,
}

impl Ending {
    /// After so many seconds, or else after the motion; `asked` where commands were sent.
    #[must_use]
    pub fn new(seconds: Option<f64>, asked: bool) -> Self {
        Self {
            seconds,
            asked,
            ..Self::default()
        }
    }

    /// Takes a log line.
    pub fn event(&mut self, event: &Event) {
        let went_back = |last_s: f64| event.time_s.is_some_and(|now| now < last_s - RESTARTED_S);
        if self.moving && self.last_s.is_some_and(went_back) {
            // The lines that follow tell why.
            self.moving = false;
            self.done_s = event.time_s;
            self.fault = Some(RESTART.to_owned());
        }
        self.last_s = event.time_s.or(self.last_s);
        match event.name.as_str() {
            "sequence done" if self.seconds.is_none() => self.done_s = event.time_s.or(self.done_s),
            // Told right after the state that it leads to.
            "fault" if self.fault.as_deref() == Some(UNNAMED) => {
                self.fault = event.field("name").map(str::to_owned).or(self.fault.take());
            }
            "state" => {
                let name = event.field("name").unwrap_or_default();
                // A motion that a fault ends says no `sequence done`.
                if name == "fault" && self.moving {
                    if self.seconds.is_none() {
                        self.done_s = event.time_s.or(self.done_s);
                    }
                    self.fault = Some(UNNAMED.to_owned());
                }
                self.moving = !matches!(name, "" | "idle" | "fault");
                if self.moving {
                    (self.refused, self.refused_s) = (None, None);
                }
            }
            name if self.asked && !self.moving => {
                let answer = name.strip_prefix("answer ").unwrap_or_default();
                if answer.starts_with("refused:") || answer.starts_with("error:") {
                    self.refused = Some(answer.to_owned());
                }
            }
            _ => {}
        }
    }

    /// Takes the time of a sample; how long the recording is.
    pub fn sample(&mut self, time_s: f64) -> f64 {
        if self.refused.is_some() {
            self.refused_s.get_or_insert(time_s);
        }
        time_s - *self.first_s.get_or_insert(time_s)
    }

    /// A sample of this time is the last one.
    #[must_use]
    pub fn over(&self, time_s: f64) -> bool {
        let long =
            |from: Option<f64>, least_s: f64| from.is_some_and(|from| time_s - from >= least_s);
        match self.seconds {
            Some(seconds) => long(self.first_s, seconds),
            None => long(self.done_s, LAST_WORD_S) || long(self.refused_s, LAST_WORD_S),
        }
    }

    /// How long to wait for the next word; without an end while a motion may still come.
    #[must_use]
    pub fn patience(&self) -> Option<Duration> {
        (self.done_s.is_some() || self.refused.is_some()).then_some(SILENCE)
    }

    /// The fault that ended the motion.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// What the firmware answered instead of moving.
    #[must_use]
    pub fn refused(&self) -> Option<&str> {
        self.refused.as_deref().filter(|_| self.done_s.is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Message, parse};

    fn after(lines: &[&str]) -> Ending {
        let mut ending = Ending::new(None, true);
        for line in lines {
            if let Some(Message::Event(event)) = parse(line) {
                ending.event(&event);
            }
        }
        ending
    }

    #[test]
    fn a_refusal_ends_it_unless_a_motion_follows() {
        const REFUSED: &str =
            "1.0 INFO answer refused: no friction is recorded, run or record-friction first";
        let mut ending = after(&[REFUSED]);
        assert!(ending.patience().is_some());
        assert!(ending.refused().is_some_and(|why| why.contains("friction")));
        assert_eq!(ending.sample(9.0), 0.0);
        assert!(!ending.over(9.0) && ending.over(9.5));
        let mut ending = after(&[REFUSED, "1.1 INFO answer ok", "1.1 INFO state name=home"]);
        ending.sample(2.0);
        assert!(!ending.over(9.0) && ending.refused().is_none() && ending.patience().is_none());
        // What is refused under way changes nothing.
        let mut ending = after(&["1.0 INFO state name=close", REFUSED]);
        ending.sample(2.0);
        assert!(!ending.over(9.0) && ending.refused().is_none());
    }

    /// With a fault latched nothing moves, and a motion that it ends has no other end.
    #[test]
    fn a_fault_ends_it() {
        let mut ending = after(&[
            "0.1 INFO state name=fault from=idle",
            "1.0 INFO answer refused: supply-low is latched: clear first",
        ]);
        ending.sample(2.0);
        assert!(ending.over(2.5) && ending.refused().is_some() && ending.fault().is_none());
        let mut ending = after(&[
            "1.0 INFO state name=close from=home",
            "2.0 INFO state name=fault from=close",
            "2.0 ERROR fault number=12 name=stall",
            // What comes later is none of this motion's.
            "2.1 ERROR fault number=3 name=bridge",
        ]);
        ending.sample(2.0);
        assert!(!ending.over(2.4) && ending.over(2.5) && ending.patience().is_some());
        assert_eq!((ending.fault(), ending.refused()), (Some("stall"), None));
        // The line that names it may be dropped: that the motion has failed is known all the same.
        let ending = after(&[
            "1.0 INFO state name=close from=home",
            "2.0 INFO state name=fault from=close",
        ]);
        assert!(ending.fault().is_some() && ending.patience().is_some());
    }

    /// After a reset nothing goes on, and the samples have stopped.
    #[test]
    fn a_restart_ends_it() {
        let moving = ["5.0 INFO state name=close from=home", "4.99 INFO answer ok"];
        assert!(after(&moving).patience().is_none());
        let started = "0.001 INFO record state=none bad_words=0";
        let ending = after(&[moving[0], started, "0.002 INFO state name=idle"]);
        assert_eq!(ending.fault(), Some("restart"));
        assert!(ending.patience().is_some());
        // Where nothing moved it is none of the recording's business.
        let ending = after(&["5.0 INFO state name=idle", started]);
        assert!(ending.fault().is_none() && ending.patience().is_none());
    }

    #[test]
    fn the_end_of_the_motion_ends_it_unless_a_length_is_asked_for() {
        let done = [
            "3.0 INFO state name=idle",
            "3.0 INFO sequence done verdict=located",
        ];
        let mut ending = after(&done);
        ending.sample(3.0);
        assert!(!ending.over(3.4) && ending.over(3.5));
        let mut ending = Ending::new(Some(2.0), true);
        ending.sample(1.0);
        assert!(!ending.over(2.9) && ending.over(3.0));
    }
}
