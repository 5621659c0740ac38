//! Assembles command lines from the bytes that a user's terminal sends.

use super::command::{Command, CommandError, LINE_MAX};

/// What terminals send to take the last character back.
const BACKSPACE: u8 = 0x08;
/// See [`BACKSPACE`].
const DELETE: u8 = 0x7F;

/// Assembles lines from bytes, in whatever pieces they arrive.
///
/// A line that grows too long is dropped whole, up to its end, and answered once. A line that ends in `stop` is a stop,
/// whatever stands before it: noise on the wire or half a command must not keep the bridge on.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    line: heapless::Vec<u8, LINE_MAX>,
    overlong: bool,
    /// The last four bytes of the line, lower case, the latest lowest, also of what was dropped.
    tail: u32,
}

impl Lines {
    /// Takes a byte; at the end of a line, its command. `None` within a line and for empty ones.
    pub fn push(&mut self, byte: u8) -> Option<Result<Command, CommandError>> {
        if matches!(byte, BACKSPACE | DELETE) {
            // An overlong line stays one: it is dropped whole.
            let _ = self.line.pop();
            self.tail >>= 8;
            return None;
        }
        if !matches!(byte, b'\n' | b'\r') {
            self.tail = self.tail << 8 | u32::from(byte.to_ascii_lowercase());
            self.overlong |= self.line.push(byte).is_err();
            return None;
        }
        let parsed = if self.tail == u32::from_be_bytes(*b"stop") {
            Some(Ok(Command::Stop))
        } else if self.overlong {
            Some(Err(CommandError::NotALine))
        } else {
            Command::parse(&self.line).transpose()
        };
        self.line.clear();
        self.overlong = false;
        self.tail = 0;
        parsed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn feed(lines: &mut Lines, bytes: &[u8]) -> Vec<Result<Command, CommandError>> {
        bytes.iter().filter_map(|byte| lines.push(*byte)).collect()
    }

    #[test]
    fn lines_come_out_whole_however_the_bytes_are_cut() {
        let mut lines = Lines::default();
        assert_eq!(feed(&mut lines, b"sta"), vec![]);
        assert_eq!(
            feed(&mut lines, b"tus\r\n\nopen\rhal\n"),
            vec![
                Ok(Command::Status),
                Ok(Command::Open),
                Err(CommandError::Unknown)
            ]
        );
    }

    #[test]
    fn a_character_that_is_taken_back_does_not_count() {
        let mut lines = Lines::default();
        assert_eq!(
            feed(
                &mut lines,
                b"st0p\x7f\x7fop\nclx\x08ose\n\x08\x7f\nstop\x08\n"
            ),
            vec![
                Ok(Command::Stop),
                Ok(Command::Close),
                Err(CommandError::Unknown)
            ]
        );
    }

    #[test]
    fn an_overlong_line_is_answered_once_and_the_next_is_understood() {
        let mut lines = Lines::default();
        assert_eq!(feed(&mut lines, &[b'x'; 1000]), vec![]);
        assert_eq!(
            feed(&mut lines, b"\nopen\n"),
            vec![Err(CommandError::NotALine), Ok(Command::Open)]
        );
    }

    proptest! {
        /// Whatever came before, and whatever is on the line before it, a stop is a stop.
        #[test]
        fn no_stop_is_lost(noise in proptest::collection::vec(any::<u8>(), 0..300)) {
            let mut lines = Lines::default();
            feed(&mut lines, &noise);
            let parsed = feed(&mut lines, b"stop\n");
            prop_assert_eq!(parsed, vec![Ok(Command::Stop)]);
        }
    }

    /// Five million bytes, half noise, half pieces of real commands: nothing panics, every stop arrives.
    #[test]
    fn five_million_bytes_and_no_stop_is_lost() {
        let words: [&[u8]; 8] = [
            b"set ",
            b"closing-speed ",
            b"0.3",
            b"calibrate ",
            b" 40mm",
            b"run",
            b"\n",
            b"stop\n",
        ];
        let mut state: u32 = 0x9e37_79b9;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state
        };
        let mut lines = Lines::default();
        let (mut bytes, mut sent, mut received) = (0u32, 0u32, 0u32);
        let mut push = |byte: u8, received: &mut u32| {
            if lines.push(byte) == Some(Ok(Command::Stop)) {
                *received += 1;
            }
        };
        while bytes < 5_000_000 {
            let pick = random();
            if pick & 8 == 0 {
                // Noise without a letter p: it cannot complete a stop of its own.
                let byte = (pick >> 8) as u8;
                push(
                    if byte.eq_ignore_ascii_case(&b'p') {
                        b'?'
                    } else {
                        byte
                    },
                    &mut received,
                );
                bytes += 1;
            } else {
                let word = words[(pick & 7) as usize];
                sent += u32::from(word == b"stop\n");
                for byte in word {
                    push(*byte, &mut received);
                    bytes += 1;
                }
            }
        }
        assert!(sent > 50_000);
        assert_eq!(received, sent);
    }
}
