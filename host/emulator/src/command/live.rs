// SPDX-License-Identifier: GPL-2.0-only
//! A run that someone follows as it goes: its pace, and the command lines typed meanwhile.

use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

use palpate_emulator::sim::{Session, Step};

/// Keeps simulated time to a multiple of real time.
pub struct Pace {
    speed: f64,
    from: Instant,
    from_s: f64,
}

impl Pace {
    /// Starts at simulated time 0, at `speed` times real time.
    pub fn new(speed: f64) -> Self {
        Self {
            speed,
            from: Instant::now(),
            from_s: 0.0,
        }
    }

    /// Restarts the pace, so that time in which the core was halted is not caught up.
    pub fn restart(&mut self, time_s: f64) {
        (self.from, self.from_s) = (Instant::now(), time_s);
    }

    /// Waits until the time is due.
    pub fn keep(&self, time_s: f64) {
        let due = Duration::from_secs_f64((time_s - self.from_s).max(0.0) / self.speed);
        std::thread::sleep(due.saturating_sub(self.from.elapsed()));
    }
}

/// Command lines typed while the emulation runs.
pub struct Typed {
    lines: Receiver<String>,
    open: bool,
}

impl Typed {
    /// Reads standard input in a thread of its own.
    pub fn listen() -> Self {
        let (sender, lines) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            for line in std::io::stdin().lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self { lines, open: true }
    }

    /// Whether standard input is still open.
    pub fn open(&self) -> bool {
        self.open
    }

    /// Passes on what has been typed since: `stop` at once, other lines when the motion before them has ended.
    pub fn pass_on(&mut self, session: &mut Session<'_>) {
        loop {
            match self.lines.try_recv() {
                Ok(line) => match Step::Command(line.trim().to_owned()) {
                    step if step.stops() => session.stop(),
                    step => session.enter(step),
                },
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.open = false;
                    return;
                }
            }
        }
    }
}
