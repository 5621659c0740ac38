// SPDX-License-Identifier: GPL-2.0-only
//! When a run is over, and what was not done then.

use super::{Progress, Session};
use crate::sim::script::Step;

/// Resets after which the firmware will not come up any more.
const RESET_LOOP: usize = 10;

impl Session<'_> {
    /// Nothing more can come, or the firmware has reported a fault that the script does not clear.
    #[must_use]
    pub fn over(&self) -> bool {
        self.ended() || self.faulted() && !self.not_entered().iter().any(Step::clears)
    }

    /// Nothing more can come: the script is done, the time is up, or the firmware starts again and again.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.completed() || self.timed_out() || self.resets.len() >= RESET_LOOP
    }

    /// Every step of the script was carried out and its motion ended.
    #[must_use]
    pub fn completed(&self) -> bool {
        self.progress == Progress::Done
    }

    /// The time allowed is up.
    #[must_use]
    pub fn timed_out(&self) -> bool {
        self.machine.time_s() >= self.settings.max_s
    }

    /// A fault was reported since the user last typed `clear`.
    #[must_use]
    pub fn faulted(&self) -> bool {
        self.faults.len() > self.cleared
    }

    /// How many steps of the script the user has come to.
    #[must_use]
    pub fn entered(&self) -> usize {
        self.next
    }

    /// Steps of the script that the user has not come to.
    #[must_use]
    pub fn not_entered(&self) -> &[Step] {
        self.settings.script.0.get(self.next..).unwrap_or_default()
    }
}
