//! Which limits are worth a line in the log.
//!
//! The current is at its limit in every good grasp: against the opening stop, while probing and holding, and for a moment
//! whenever a motion starts. It is reported where it should not be, for longer than a start takes.

use crate::drive::LimitsReached;
use crate::drive::sequence::State;

/// Steps of a millisecond that a limit must be in force: several times what a start takes.
const PATIENCE: u16 = 500;

/// Follows the limits in force, and says what to report.
#[derive(Clone, Debug, Default)]
pub struct LimitReport {
    reported: LimitsReached,
    current: u16,
    duty: u16,
    speed: u16,
    position: u16,
}

impl LimitReport {
    /// Call once a millisecond. The limits to report, when that changes.
    pub fn update(&mut self, state: State, limited: LimitsReached) -> Option<LimitsReached> {
        let expected = matches!(
            state,
            State::Home | State::Probe | State::Hold | State::Idle | State::Fault
        );
        let persists = |count: &mut u16, limited: bool| {
            *count = if limited && !expected {
                count.saturating_add(1)
            } else {
                0
            };
            *count >= PATIENCE
        };
        let now = LimitsReached {
            current: persists(&mut self.current, limited.current),
            duty: persists(&mut self.duty, limited.duty),
            speed: persists(&mut self.speed, limited.speed),
            position: persists(&mut self.position, limited.position),
        };
        let changed = now != self.reported;
        self.reported = now;
        changed.then_some(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURRENT: LimitsReached = LimitsReached {
        current: true,
        duty: false,
        speed: false,
        position: false,
    };

    #[test]
    fn a_start_a_stop_and_a_press_are_no_news() {
        let mut report = LimitReport::default();
        for _ in 0..400 {
            assert_eq!(report.update(State::Close, CURRENT), None);
        }
        assert_eq!(report.update(State::Close, LimitsReached::default()), None);
        for _ in 0..5000 {
            assert_eq!(report.update(State::Home, CURRENT), None);
            assert_eq!(report.update(State::Hold, CURRENT), None);
        }
    }

    #[test]
    fn a_free_motion_at_the_current_limit_is_reported_once_and_its_end_too() {
        let mut report = LimitReport::default();
        let reports: Vec<_> = (0..2000)
            .filter_map(|_| report.update(State::RecordClosing, CURRENT))
            .collect();
        assert_eq!(reports, [CURRENT]);
        assert_eq!(
            report.update(State::Idle, CURRENT),
            Some(LimitsReached::default())
        );
    }
}
