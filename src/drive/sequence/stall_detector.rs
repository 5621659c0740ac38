//! Detects a stall: the motor stands although its current is at the limit.

use crate::drive::demand::Status;

/// Slower than this share of the wanted speed is standing.
const STANDING: f32 = 0.2;
/// Standing for this long is a stall: several times what static friction and a backlash's blow take, microseconds.
const STALLED_US: u32 = 150_000;

/// Follows one motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StallDetector {
    since_us: Option<u32>,
}

impl StallDetector {
    /// `true` while stalled; the wanted speed is a magnitude.
    pub(super) fn update(
        &mut self,
        now_us: u32,
        status: &Status,
        wanted_counts_per_s: f32,
    ) -> bool {
        let stands = status.limited.current
            && status.speed_counts_per_s.abs() < STANDING * wanted_counts_per_s;
        if !stands {
            self.since_us = None;
            return false;
        }
        let since_us = *self.since_us.get_or_insert(now_us);
        now_us.wrapping_sub(since_us) >= STALLED_US
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::demand::LimitsReached;

    fn status(current: bool, speed_counts_per_s: f32) -> Status {
        Status {
            limited: LimitsReached {
                current,
                ..LimitsReached::default()
            },
            speed_counts_per_s,
            ..Status::default()
        }
    }

    #[test]
    fn needs_the_current_limit_the_standstill_and_the_time() {
        let mut stall = StallDetector::default();
        for ms in 0..1000 {
            assert!(
                !stall.update(ms * 1000, &status(false, 0.0), 60e3),
                "no current"
            );
        }
        for ms in 1000..2000 {
            assert!(
                !stall.update(ms * 1000, &status(true, 20e3), 60e3),
                "still moving"
            );
        }
        for ms in 2000..2150 {
            assert!(
                !stall.update(ms * 1000, &status(true, -100.0), 60e3),
                "not yet, {ms}"
            );
        }
        assert!(stall.update(2_150_000, &status(true, 0.0), 60e3));
        assert!(
            !stall.update(2_151_000, &status(true, 30e3), 60e3),
            "moves again"
        );
        assert!(
            !stall.update(2_152_000, &status(true, 0.0), 60e3),
            "from the start"
        );
    }
}
