//! The states of the motion sequence, their legal transitions and their timeouts.

use crate::name_list::nth;

use super::motion::{Motion, WINDUP_RAD};

/// Longest wait for the last word on a contact after its hold, second (chosen). With two phalanges it takes some tenths of a second,
/// with three, where no single contact explains the curve, 4.5 and the round that is then the last, some 2 (simulated).
pub(super) const JUDGING_S: f32 = 8.0;

/// What the finger is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// At rest, bridge off.
    #[default]
    Idle,
    /// Measuring the offset of the current sense at standstill.
    CalibrateOffset,
    /// Opening against the stop to find the encoder's zero.
    Home,
    /// Closing free over the whole travel, recording friction.
    RecordClosing,
    /// Opening again, recording friction.
    RecordOpening,
    /// Closing until contact.
    Close,
    /// Closing on after contact, the torque rising.
    Probe,
    /// Holding the object with the commanded current.
    Hold,
    /// Opening to the rest position.
    Open,
    /// Bridge off until cleared.
    Fault,
}

impl State {
    /// Every state.
    pub const ALL: [State; 10] = [
        State::Idle,
        State::CalibrateOffset,
        State::Home,
        State::RecordClosing,
        State::RecordOpening,
        State::Close,
        State::Probe,
        State::Hold,
        State::Open,
        State::Fault,
    ];

    /// Name, as logged.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        const NAMES: &str = "idle\ncalibrate-offset\nhome\nrecord-closing\nrecord-opening\nclose\nprobe\nhold\nopen\nfault\n";
        nth(NAMES, self as u8)
    }

    /// The states that may follow this one. `Idle` (stop) and `Fault` may follow every moving state.
    pub const fn successors(self) -> &'static [State] {
        use State::*;
        match self {
            Idle => &[CalibrateOffset, Fault],
            CalibrateOffset => &[Home, RecordClosing, Close, Open, Idle, Fault],
            Home => &[RecordClosing, Close, Idle, Fault],
            RecordClosing => &[RecordOpening, Idle, Fault],
            RecordOpening => &[Close, Idle, Fault],
            Close => &[Probe, Open, Idle, Fault],
            Probe => &[Hold, Open, Idle, Fault],
            Hold => &[Open, Idle, Fault],
            Open => &[RecordClosing, Close, Idle, Fault],
            Fault => &[Idle],
        }
    }

    /// Whether `next` may follow.
    pub fn may_become(self, next: State) -> bool {
        /// The successors as bits.
        const FOLLOWING: [u16; State::ALL.len()] = {
            let mut following = [0; State::ALL.len()];
            let mut at = 0;
            while at < following.len() {
                let mut successors = State::ALL[at].successors();
                while let [first, rest @ ..] = successors {
                    following[at] |= 1 << *first as u16;
                    successors = rest;
                }
                at += 1;
            }
            following
        };
        FOLLOWING[self as usize] >> next as u16 & 1 != 0
    }

    /// Longest stay, second; `None` where the bridge is off and nothing can go wrong. What a motion should take, and half as
    /// much again for acceleration, backlash and a supply that is low, and a second for what does not scale.
    pub fn timeout_s(self, motion: &Motion) -> Option<f32> {
        // The finger's travel, and the cable wound up or unwound at both ends.
        let way_rad = motion.travel_rad + 2.0 * WINDUP_RAD;
        let should_s = match self {
            State::Idle | State::Fault => return None,
            // 1.5 ms to wake, 20 ms to settle, 205 ms to average; standstill before that.
            State::CalibrateOffset => 0.5,
            // From the closing stop to the opening stop in the worst case, or the run-up and twice the cable's windup.
            State::Home => (way_rad + 2.0 * WINDUP_RAD) / motion.closing_rad_per_s,
            // Friction depends on speed: the way back is recorded at the speed of closing.
            State::RecordClosing | State::RecordOpening | State::Close => {
                way_rad / motion.closing_rad_per_s
            }
            State::Open => way_rad / motion.opening_rad_per_s,
            State::Probe => motion.probing_rad / motion.closing_rad_per_s,
            State::Hold => motion.holding_s + JUDGING_S,
        };
        Some(1.5 * should_s + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_can_stop_and_every_driving_state_can_fault() {
        for state in State::ALL {
            assert!(
                state == State::Idle || state.may_become(State::Idle),
                "{state:?}"
            );
            assert!(
                state == State::Fault || state.may_become(State::Fault),
                "{state:?}"
            );
            assert!(!state.may_become(state), "{state:?}");
        }
    }

    #[test]
    fn a_state_lasts_as_long_as_its_way_takes_at_its_own_speed() {
        for (closing_rad_per_s, opening_rad_per_s) in [(0.05, 0.8), (0.3, 0.6), (0.8, 0.05)] {
            let motion = Motion {
                closing_rad_per_s,
                opening_rad_per_s,
                ..super::super::tests::motion()
            };
            for (state, speed_rad_per_s) in [
                (State::RecordClosing, closing_rad_per_s),
                (State::RecordOpening, closing_rad_per_s),
                (State::Close, closing_rad_per_s),
                (State::Home, closing_rad_per_s),
                (State::Open, opening_rad_per_s),
            ] {
                let way_s = motion.travel_rad / speed_rad_per_s;
                let stay_s = state.timeout_s(&motion).expect("a motion");
                assert!(stay_s > 1.5 * way_s, "{state:?}: {stay_s} s for {way_s} s");
                // Nor so long that a finger which does not move is reported much later.
                assert!(
                    stay_s < 4.0 * way_s + 3.0,
                    "{state:?}: {stay_s} s for {way_s} s"
                );
            }
        }
    }

    #[test]
    fn nothing_leaves_a_fault_but_clearing_it() {
        assert_eq!(State::Fault.successors(), [State::Idle]);
    }
}
