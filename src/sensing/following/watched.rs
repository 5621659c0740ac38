//! A contact that is watched: what its torque may be, and what a turn of the motor says of it (docs/SECOND_CONTACTS.md#held-contacts).

use super::Change;
use super::fade::{Fade, RIPPLE_SHARE};
use super::jump::{JumpBounds, JumpSample, Jumps};
use super::level::Above;
use super::rolled::Placed;
use super::stand::Stand;
use super::turn::Turn;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::Bounded;
use crate::sensing::Sensor;
use crate::sensing::block::Block;
use crate::sensing::location::SeriesElement;

/// Deviations of a block that count as noise.
const SIGMAS: f32 = 8.0;
/// Share of the torque limit below which nothing is held (chosen): twice as far as friction wanders.
const NOTHING_SHARE: f32 = 0.03;
/// Of the torque before, or of what the holding current holds, the share below which a turn of the motor has no load.
const FREE_SHARE: f32 = 0.3;
/// And that share of the torque that was held: the finger still swings when it is told.
const NOTHING_LEFT: f32 = 0.1;
/// Slower than this share of the nominal speed, the worm's friction is no longer that of the record.
const SLOW_SHARE: f32 = 0.5;
/// Efficiency of a worm that starts, as a share of its efficiency at the nominal speed: 0.33 of 0.45
/// (docs/HARDWARE.md#plant-parameters).
const STARTING_SHARE: f32 = 0.7;
/// Deviations of the inertia within which it is: uniform (scenes/common/defaults.toml).
const INERTIA_SIGMAS: f32 = 2.0;
/// How much stiffer than its mean compliance says a cable may be that stiffens with its load.
const STIFFENED: f32 = 1.25;
/// A cable may be so much stiffer than its nominal value at most, whatever its deviation.
const LEAST_CABLE_SHARE: f32 = 0.2;

/// A closing in contact.
#[derive(Clone, Debug)]
pub(super) struct Watched {
    /// Angle of the input link at the onset, radian.
    pub(super) onset_rad: f32,
    /// What the record's level was off by at the onset, newton metre at the input link.
    pub(super) level_nm: f32,
    /// Angle of the input link, the cable's twist included, and torque above friction at the last block.
    pub(super) last: [f32; 2],
    /// What its noise may be at most, newton metre.
    pub(super) noise_nm: f32,
    /// Time before which the finger still swings after the last change, microseconds.
    pub(super) since_us: u64,
    pub(super) fade: Fade,
    pub(super) jumps: Jumps,
    pub(super) stand: Stand,
    pub(super) placed: Option<Placed>,
    /// The closing is over: the place is told once the motor stands.
    pub(super) is_over: bool,
    /// The contact has changed: its place is not known any more.
    pub(super) has_changed: bool,
    /// The same at a second contact.
    pub(super) second: Option<[f32; 2]>,
}

impl Watched {
    /// The noise of the last block, newton metre.
    pub(super) fn note_noise(&mut self, sigma_nm: f32) {
        self.noise_nm = SIGMAS * sigma_nm;
    }

    /// Torque below which nothing is held, newton metre.
    pub(super) fn nothing_nm<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
    ) -> f32 {
        (self.noise_nm).at_least(NOTHING_SHARE * sensor.settings().torque_limit_nm)
    }

    /// Torque above friction of a block, newton metre.
    pub(super) fn excess<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        block: &Block,
    ) -> Option<f32> {
        Above::of(sensor, block).map(|above| above.torque_nm - self.level_nm)
    }

    /// A motor that stood turns without load.
    pub(super) fn freed<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &self,
        sensor: &Sensor<F, H, X>,
        held: &Block,
        turn: &Turn,
    ) -> Option<Seen> {
        let held_nm = self.excess(sensor, held)?;
        let left_nm = self.excess(sensor, &turn.block)?;
        let is_free = !turn.is_short
            && held_nm > 2.0 * NOTHING_SHARE * sensor.settings().torque_limit_nm
            && left_nm < FREE_SHARE * held_nm;
        is_free.then_some((Change::Lost, held_nm, left_nm))
    }

    /// The torque of the last turn has jumped.
    pub(super) fn jumped<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        turn: &Turn,
    ) -> Option<Seen> {
        let top_nm = self.fade.top_nm();
        let Turn {
            block, before_nm, ..
        } = turn;
        // After a change the turn before this one must have begun when the finger swings no more.
        let turns_us = if self.has_changed {
            (2e6 * block.duration_s) as u64
        } else {
            0
        };
        let swings = block.time_us < self.since_us + turns_us;
        // The noise is known from the first block on, and the torque from where there is some.
        if swings || top_nm <= 0.0 || self.noise_nm <= 0.0 || before_nm.is_nan() {
            return None;
        }
        let (drivetrain, settings) = (sensor.drivetrain(), sensor.settings());
        let efficiency = drivetrain.efficiency;
        let inertia_nm = (block.inertia_nm - turn.before_inertia_nm).abs();
        let inertia_nm = INERTIA_SIGMAS * drivetrain.inertia_sigma * efficiency * inertia_nm;
        let ripple_share = RIPPLE_SHARE + drivetrain.efficiency_per_speed * block.overspeed.abs();
        let is_turning =
            !turn.is_short && turn.speed_rad_per_s > SLOW_SHARE * settings.speed_rad_per_s;
        let torque_nm = efficiency * block.drive_torque_nm;
        let nothing_nm = self.nothing_nm(sensor).at_least(inertia_nm);
        let nothing_nm = nothing_nm.at_least(NOTHING_LEFT * top_nm);
        let turn_rad = drivetrain.rotation_rad(0, drivetrain.counts_per_turn as i32);
        let (change, by_nm) = self.jumps.push(
            &JumpSample {
                time_us: block.time_us as u32,
                angle_rad: drivetrain.closing_rad(block.counts),
                torque_nm,
                before_nm: efficiency * before_nm,
                least_nm: if is_turning {
                    torque_nm
                } else {
                    STARTING_SHARE * torque_nm
                },
                held_nm: self.last[1],
                nothing_nm,
                noise_nm: self.noise_nm + inertia_nm + ripple_share * top_nm,
                is_turning,
            },
            &JumpBounds {
                steepest_nm_per_rad: steepest(sensor),
                turn_rad,
                turn_us: (1e6 * turn_rad / settings.speed_rad_per_s) as u32,
            },
        )?;
        let to_nm = self.excess(sensor, block)?;
        let change = match change {
            Change::Slipped => fallen_to(to_nm, nothing_nm),
            other => other,
        };
        Some((change, to_nm - by_nm, to_nm))
    }
}

/// A change, and the torques above friction before and after, newton metre.
pub(super) type Seen = (Change, f32, f32);

/// What a contact has come to whose torque has fallen.
pub(super) fn fallen_to(torque_nm: f32, nothing_nm: f32) -> Change {
    if torque_nm < nothing_nm {
        Change::Lost
    } else {
        Change::Slipped
    }
}

/// The steepest rise of nominal torque over angle that the cable allows, newton metre per radian; infinite without one.
fn steepest<F: Mechanics, H: JointSensor, X: SeriesElement>(sensor: &Sensor<F, H, X>) -> f32 {
    if !X::FLEXIBLE {
        return f32::INFINITY;
    }
    let calibration = sensor.calibration();
    let cable = calibration.cable_rad_per_nm;
    let least = cable - 2.0 * calibration.cable_sigma_rad_per_nm;
    STIFFENED / least.at_least(LEAST_CABLE_SHARE * cable)
}
