//! Jumps of the torque while the finger closes on a contact, turn by turn of the motor, with every sample
//! (docs/SECOND_CONTACTS.md#while-the-motor-turns).
//!
//! The turn that ends now is compared with the one before it. Once they differ by more than an object that stands still allows, the
//! torque before is kept until the motor has made another turn: then all of the jump is in it, and what was a disturbance of a moment
//! has left it. Where most of the torque has gone, another turn shows whether any is left: a finger that is let go swings first.

use super::Change;
use crate::numeric::Bounded;

/// Time after which the jump is told even if the motor has not made another turn, in turns of the nominal speed.
const LONGEST: f32 = 1.25;
/// Where less than this share of the torque is left, there may be nothing soon.
const MOST_SHARE: f32 = 0.5;
/// Weight of a sample in the mean rise: some three turns.
const RISE_GAIN: f32 = 0.02;
/// A torque that should have risen has fallen if it is lower by this share of the noise.
const LEAST_FALL: f32 = 0.5;

/// A sample of a closing in contact. Torques at the input link, newton metre; friction is in those of turns, and cancels.
#[derive(Clone, Copy, Debug)]
pub(super) struct JumpSample {
    /// When, microseconds, wrapping.
    pub(super) time_us: u32,
    /// Angle of the input link, the cable's twist included, radian.
    pub(super) angle_rad: f32,
    /// Torque of the last turn and of the turn before it.
    pub(super) torque_nm: f32,
    pub(super) before_nm: f32,
    /// The least that the torque of the last turn may be where the motor is slow.
    pub(super) least_nm: f32,
    /// What is held, above friction, and what counts as nothing.
    pub(super) held_nm: f32,
    pub(super) nothing_nm: f32,
    /// What the noise of their difference may be at most.
    pub(super) noise_nm: f32,
    /// The motor turns at about its nominal speed.
    pub(super) is_turning: bool,
}

/// What the drivetrain is.
#[derive(Clone, Copy, Debug)]
pub(super) struct JumpBounds {
    /// The steepest rise that it allows, newton metre per radian; infinite without a cable.
    pub(super) steepest_nm_per_rad: f32,
    /// A turn of the motor, radian at the input link, and its time at the nominal speed, microseconds.
    pub(super) turn_rad: f32,
    pub(super) turn_us: u32,
}

/// A jump that is not sure yet.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    since_us: u32,
    since_rad: f32,
    before_nm: f32,
    held_nm: f32,
    rises: bool,
    /// It rose while the motor turned: that it slows down then does not make it less.
    is_sure: bool,
}

/// Looks for jumps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Jumps {
    suspect: Option<Suspect>,
    /// Mean rise of the torque from turn to turn, newton metre.
    rise_nm: f32,
    /// When a jump was told, or a disturbance of a moment left the last turn: until another turn is over, it is in the turn before.
    paused_us: Option<u32>,
}

impl Jumps {
    /// The torque has jumped, and that is known: what is left of it in the turn before says nothing.
    pub(super) fn pause(&mut self, now_us: u32) {
        self.suspect = None;
        self.paused_us = Some(now_us);
    }

    /// Takes a sample; a jump once it is sure: [`Change::Pushed`] or [`Change::Slipped`], and by how much.
    pub(super) fn push(&mut self, now: &JumpSample, bounds: &JumpBounds) -> Option<(Change, f32)> {
        let rise_nm = self.rise_nm;
        // It must fall itself: that the rise ends may have other reasons.
        let fallen = |before_nm: f32, turns: f32| {
            let fall_nm = before_nm - now.torque_nm;
            let is_jump = fall_nm + turns * rise_nm > now.noise_nm;
            is_jump && fall_nm > LEAST_FALL * now.noise_nm && now.is_turning
        };
        let risen = |torque_nm: f32, before_nm: f32, way_rad: f32| {
            torque_nm - before_nm > bounds.steepest_nm_per_rad * way_rad + now.noise_nm
        };
        let is_over = |turns: f32, since_us| {
            now.time_us.wrapping_sub(since_us) as f32 >= LONGEST * turns * bounds.turn_us as f32
        };
        if self
            .paused_us
            .is_some_and(|since_us| !is_over(1.0, since_us))
        {
            return None;
        }
        self.paused_us = None;
        let Some(suspect) = self.suspect else {
            let rises = risen(now.least_nm, now.before_nm, bounds.turn_rad);
            if rises || fallen(now.before_nm, 1.0) {
                self.suspect = Some(Suspect {
                    since_us: now.time_us,
                    since_rad: now.angle_rad,
                    before_nm: now.before_nm,
                    held_nm: now.held_nm,
                    rises,
                    is_sure: now.is_turning,
                });
            } else {
                let change_nm = now.torque_nm - now.before_nm;
                self.rise_nm += RISE_GAIN * (change_nm.at_least(0.0) - self.rise_nm);
            }
            return None;
        };
        let way_rad = now.angle_rad - suspect.since_rad;
        let holds = if suspect.rises {
            let torque_nm = if suspect.is_sure {
                now.torque_nm
            } else {
                now.least_nm
            };
            risen(
                torque_nm,
                suspect.before_nm,
                bounds.turn_rad + way_rad.at_least(0.0),
            )
        } else {
            fallen(suspect.before_nm, 1.0 + way_rad / bounds.turn_rad)
        };
        if !holds {
            self.pause(now.time_us);
            return None;
        }
        let by_nm = now.torque_nm - suspect.before_nm;
        let left_nm = suspect.held_nm + by_nm;
        let is_open = (now.nothing_nm..MOST_SHARE * suspect.held_nm).contains(&left_nm);
        let turns = if is_open && !suspect.rises { 2.0 } else { 1.0 };
        if way_rad < turns * bounds.turn_rad && !is_over(turns, suspect.since_us) {
            return None;
        }
        self.pause(now.time_us);
        Some(if suspect.rises {
            (Change::Pushed, by_nm)
        } else {
            (Change::Slipped, by_nm)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of a turn at 0.3 rad/s.
    const TURN: usize = 16;
    const BOUNDS: JumpBounds = JumpBounds {
        steepest_nm_per_rad: 1.5,
        turn_rad: 4.8e-3,
        turn_us: 16_000,
    };

    /// What is told of a torque over samples a millisecond apart, each the mean of a turn; the motor stands from a sample on.
    fn told(torque_nm: impl Fn(usize) -> f32, stands: usize) -> Vec<(usize, Change)> {
        let mut jumps = Jumps::default();
        let mean = |end: usize| (0..TURN).map(|i| torque_nm(end - i)).sum::<f32>() / TURN as f32;
        let samples = 2 * TURN..400;
        samples
            .filter_map(|ms| {
                let torque = mean(ms);
                let is_turning = ms < stands;
                let now = JumpSample {
                    time_us: 1000 * ms as u32,
                    angle_rad: 0.3e-3 * ms.min(stands) as f32,
                    torque_nm: torque,
                    before_nm: mean(ms - TURN),
                    least_nm: if is_turning { torque } else { 0.7 * torque },
                    held_nm: mean(ms - TURN),
                    nothing_nm: 0.01,
                    noise_nm: 5e-3,
                    is_turning,
                };
                Some((ms, jumps.push(&now, &BOUNDS)?.0))
            })
            .collect()
    }

    const NEVER: usize = usize::MAX;

    /// 0.3 N m/rad, then the cable's 1.2 alone.
    fn rise(ms: usize) -> f32 {
        let angle = 0.3e-3 * ms as f32;
        0.1 + 0.3 * angle + 0.9 * (angle - 0.06).max(0.0)
    }

    #[test]
    fn nothing_is_told_of_a_second_contact_or_of_a_disturbance_of_a_moment() {
        assert_eq!(told(rise, NEVER), []);
        for by_nm in [-0.3, 0.5] {
            let shaken = |ms: usize| rise(ms) + if (100..102).contains(&ms) { by_nm } else { 0.0 };
            assert_eq!(told(shaken, NEVER), [], "{by_nm}");
        }
    }

    #[test]
    fn a_jump_is_told_once_within_50_ms() {
        for (by_nm, change) in [
            (-0.015, Change::Slipped),
            (-0.1, Change::Slipped),
            (0.03, Change::Pushed),
        ] {
            let jumps = |ms: usize| rise(ms) + if ms < 100 { 0.0 } else { by_nm };
            let told = told(jumps, NEVER);
            assert!(
                matches!(told[..], [(101..150, what)] if what == change),
                "{by_nm}: {told:?}"
            );
        }
    }

    #[test]
    fn a_motor_that_stalls_by_itself_is_no_push_and_a_push_that_stalls_it_is() {
        // What it takes to start a worm again is more than what it took to turn it.
        let stalls = |ms: usize| rise(ms.min(100)) * if ms < 100 { 1.0 } else { 1.3 };
        assert_eq!(told(stalls, 100), []);
        let pushed = |ms: usize| if ms < 100 { rise(ms) } else { 0.35 };
        let told = told(pushed, 105);
        assert!(matches!(told[..], [(101..150, Change::Pushed)]), "{told:?}");
    }
}
