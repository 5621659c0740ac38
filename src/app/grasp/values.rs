//! What the user has set, laid over the scene's own values.

use crate::app::console::settings::{Overrides, Setting};
use crate::app::identify;
use crate::drive::config::{CheckedConfig, OutOfRange};
use crate::drive::identify::Identified;
use crate::drive::sequence::Motion;
use crate::numeric::Bounded;
use crate::scene::Scene;

/// The drive with what the user has set and what was identified: what the controller is built from at start.
///
/// # Errors
/// The first value that no longer fits the scene.
pub fn drive<S: Scene>(
    overrides: &Overrides,
    identified: Option<&Identified>,
) -> Result<CheckedConfig, OutOfRange> {
    let value = |setting| value::<S>(overrides, setting);
    let drive = S::CHECKED.with_limits(
        value(Setting::CurrentLimit),
        value(Setting::SupplyMin),
        value(Setting::SupplyMax),
    )?;
    match identified {
        Some(identified) if S::IDENTIFIES => identify::drive::<S>(drive, identified),
        _ => Ok(drive),
    }
}

/// The sequence's speeds and currents with what the user has set.
pub(super) fn motion<S: Scene>(overrides: &Overrides) -> Motion {
    let mut motion = S::MOTION;
    motion.closing_rad_per_s = closing_rad_per_s::<S>(overrides);
    motion.holding_s = value::<S>(overrides, Setting::HoldTime);
    if let Some(limit_a) = overrides.get(Setting::CurrentLimit) {
        // What probing may ask for follows the limit; the rest must not exceed it.
        motion.probing_current_a = limit_a;
        for current_a in [
            &mut motion.free_current_a,
            &mut motion.homing_current_a,
            &mut motion.holding_current_a,
        ] {
            *current_a = current_a.at_most(limit_a);
        }
    }
    if let Some(torque_nm) = overrides.get(Setting::ProbeTorque) {
        // Cap the current until the last word: what this torque asks for, and what moves the free finger.
        let a_per_nm =
            const { 1.0 / (S::DRIVETRAIN.torque_per_ampere_nm * S::DRIVETRAIN.efficiency) };
        let most_a = motion.free_current_a + a_per_nm * torque_nm;
        motion.probing_current_a = motion.probing_current_a.at_most(most_a);
    }
    motion
}

/// Speed at which the finger closes, radian per second: no faster than the scene's limit, whatever is set.
// Not inlined: called from two places.
#[inline(never)]
pub fn closing_rad_per_s<S: Scene>(overrides: &Overrides) -> f32 {
    value::<S>(overrides, Setting::ClosingSpeed).at_most(S::DRIVE.limits.speed_rad_per_s)
}

/// A setting's value, SI units.
pub(super) fn value<S: Scene>(overrides: &Overrides, setting: Setting) -> f32 {
    overrides
        .get(setting)
        .unwrap_or_else(|| default_value::<S>(setting))
}

/// A setting's value where the user has set none, SI units.
fn default_value<S: Scene>(setting: Setting) -> f32 {
    match setting {
        Setting::ClosingSpeed => S::MOTION.closing_rad_per_s,
        Setting::CurrentLimit => S::DRIVE.limits.current_a,
        Setting::ProbeTorque => S::settings().torque_limit_nm,
        Setting::WantedDeviation => S::settings().wanted_sigma_m,
        Setting::Sensitivity => S::settings().false_contacts_per_thousand,
        Setting::HoldForce => S::HOLD_FORCE_N,
        Setting::HoldTime => S::MOTION.holding_s,
        Setting::Efficiency => S::EFFICIENCY,
        Setting::ContactFriction => {
            let [mean, _] = S::settings().contact_friction;
            mean
        }
        Setting::ForceScale => 1.0,
        Setting::SupplyMin => S::DRIVE.limits.supply_min_v,
        Setting::SupplyMax => S::DRIVE.limits.supply_max_v,
        #[cfg(not(weightless))]
        Setting::Mounting => S::MOUNTING_RAD,
        #[cfg(not(weightless))]
        Setting::Weight => 1.0,
    }
}
