//! Waiting. The library's own ways check their sums for an overflow, which panics; microseconds in 64 bits last half a
//! million years.

use embassy_time::{Duration, Instant, Timer};

fn add(instant: Instant, duration: Duration) -> Instant {
    Instant::from_ticks(instant.as_ticks().wrapping_add(duration.as_ticks()))
}

/// Waits so long.
pub fn after(duration: Duration) -> Timer {
    Timer::at(add(Instant::now(), duration))
}

/// Waits again and again, so that no delay adds up: who was late once waits the less.
pub struct Pace {
    next: Instant,
    period: Duration,
}

impl Pace {
    /// Begins now.
    pub fn every(period: Duration) -> Self {
        Self {
            next: add(Instant::now(), period),
            period,
        }
    }

    /// Waits for the end of the period.
    pub fn next(&mut self) -> Timer {
        let next = self.next;
        self.next = add(next, self.period);
        Timer::at(next)
    }
}
