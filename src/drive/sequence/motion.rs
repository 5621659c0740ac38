//! Speeds, currents and angles of the motion sequence.

use crate::drive::config::{Limits, OutOfRange, check};

/// The cable winds up by at most this against either stop, radian at the input link: 0.35 N m on 1.2 N m/rad, rounded up.
pub const WINDUP_RAD: f32 = 0.3;

/// Configuration of the sequence. Angles and speeds are those of the input link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Speed while homing, recording friction, closing and probing, radian per second. One speed for all of them: the
    /// worm's friction depends on it.
    pub closing_rad_per_s: f32,
    /// Speed while opening, radian per second.
    pub opening_rad_per_s: f32,
    /// Largest current while moving free, ampere.
    pub free_current_a: f32,
    /// Largest current against the opening stop, ampere.
    pub homing_current_a: f32,
    /// Current that ends probing, ampere.
    pub probing_current_a: f32,
    /// How far probing may close on after the contact, radian.
    pub probing_rad: f32,
    /// Current while holding, ampere.
    pub holding_current_a: f32,
    /// How long to hold, second. Afterwards the self-locking worm holds.
    pub holding_s: f32,
    /// Where opening ends, radian from the opening stop.
    pub rest_rad: f32,
    /// Where closing ends without a contact, radian from the opening stop: short of the closing stop.
    pub travel_rad: f32,
}

/// Longest travel, radian: at the lowest speed no state may then last longer than the clock's 32 bits can distinguish, 71 minutes.
const TRAVEL_MAX_RAD: f32 = 50.0;

impl Motion {
    /// Checks the values against each other and against the drive's limits.
    ///
    /// # Errors
    /// The first value out of range.
    pub const fn validate(&self, limits: &Limits) -> Result<(), OutOfRange> {
        let (speed, current) = (limits.speed_rad_per_s, limits.current_a);
        check(&[
            ("closing_rad_per_s", self.closing_rad_per_s, 0.02, speed),
            ("opening_rad_per_s", self.opening_rad_per_s, 0.02, speed),
            ("free_current_a", self.free_current_a, 1e-3, current),
            ("homing_current_a", self.homing_current_a, 1e-3, current),
            ("probing_current_a", self.probing_current_a, 1e-3, current),
            ("probing_rad", self.probing_rad, 0.01, 3.0),
            ("holding_current_a", self.holding_current_a, 0.0, current),
            ("holding_s", self.holding_s, 0.0, 600.0),
            ("rest_rad", self.rest_rad, 0.0, 0.5),
            (
                "travel_rad",
                self.travel_rad,
                self.rest_rad + 0.05,
                if limits.position_max_rad < TRAVEL_MAX_RAD {
                    limits.position_max_rad
                } else {
                    TRAVEL_MAX_RAD
                },
            ),
        ])
    }
}
