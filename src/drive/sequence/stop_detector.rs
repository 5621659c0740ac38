//! Finds the opening stop from the motor current. Behind the stop the cable winds up, so the motor comes to rest further on
//! than the stop. The current rises in proportion to the windup; two points of the rise give its beginning.

/// The current is that of free motion until it exceeds the mean by this, ampere: three times the ripple of a worm's turn.
const STEP_A: f32 = 6e-3;
/// Weight of a new sample in the mean of free motion: a time constant of 0.25 s at 1 kHz, two turns of the worm.
const GAIN: f32 = 0.004;

/// Follows the current while homing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StopDetector {
    free_a: Option<f32>,
    first: Option<i32>,
    second: Option<i32>,
}

impl StopDetector {
    /// Takes the magnitude of the current at a position.
    pub(super) fn update(&mut self, current_a: f32, position_counts: i32) {
        let free_a = *self.free_a.get_or_insert(current_a);
        let excess_a = current_a - free_a;
        if excess_a < 0.5 * STEP_A {
            // With hysteresis: ripple on the rise must not restart it.
            self.first = None;
            self.second = None;
            self.free_a = Some(free_a + GAIN * excess_a);
        }
        if excess_a >= STEP_A {
            self.first.get_or_insert(position_counts);
        }
        if excess_a >= 3.0 * STEP_A {
            self.second.get_or_insert(position_counts);
        }
    }

    /// Where the rise began; `None` if the current did not rise.
    pub(super) fn position_counts(&self) -> Option<i32> {
        let first = self.first?;
        let second = self.second.unwrap_or(first);
        // One step above free motion at the first, three at the second: half their distance back.
        Some(first.wrapping_sub(second.wrapping_sub(first) / 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_begin_of_a_rise_in_ripple() {
        for begin in [-200_000i32, -30_000, i32::MIN + 100_000] {
            let mut onset = StopDetector::default();
            let mut position = begin.wrapping_add(150_000);
            while position.wrapping_sub(begin) > -90_000 {
                let windup = begin.wrapping_sub(position).max(0) as f32;
                let ripple_a = 1e-3 * (position as f32 * core::f32::consts::TAU / 65_536.0).sin();
                // 96 mA a second at 62 counts a millisecond: the prototype at 0.3 rad/s.
                onset.update(0.022 + ripple_a + windup * 1.55e-6, position);
                position = position.wrapping_sub(62);
            }
            let found = onset.position_counts().expect("a rise");
            let error_rad = (found.wrapping_sub(begin)) as f32 * 4.8e-6;
            assert!(error_rad.abs() < 0.01, "off by {error_rad} rad");
        }
    }

    #[test]
    fn sees_no_stop_in_free_motion() {
        let mut onset = StopDetector::default();
        for ms in 0..10_000i32 {
            let slow_a = 4e-3 * (ms as f32 * 1e-3).sin();
            onset.update(0.02 + slow_a, -62 * ms);
        }
        assert_eq!(onset.position_counts(), None);
    }
}
