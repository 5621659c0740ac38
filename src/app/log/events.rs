//! Events and states as lines of the log: units of the log, names instead of variants.

use super::Log;
use crate::drive::Status;
use crate::drive::fault::Fault;
use crate::drive::sequence::State;
use crate::name_list::nth;
use crate::sensing::{
    Calibration, Change, Event, Followed, Grip, NotLocated, Object, Refusal, Relative,
};

/// Metre to millimetre, newton metre to millinewton metre, radian to milliradian, ampere to milliampere.
pub(super) const MILLI: f32 = 1e3;

impl NotLocated {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        const NAMES: &str =
            "proximal\ntoo-soft\ngap\ntoo-stiff\nunexplained\nunobservable\ntoo-few-samples\n";
        nth(NAMES, self as u8)
    }
}

impl Refusal {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        const NAMES: &str =
            "no-contact\ntoo-few-samples\nno-such-place\nmisfit\nimplausible\nuninformative\n";
        nth(NAMES, self as u8)
    }
}

impl Grip {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        nth("lost\nsingle\ntwo-contacts\nenveloped\n", self as u8)
    }
}

impl Relative {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stiffer => "stiffer",
            Self::Softer => "softer",
            Self::Unclear => "unclear",
        }
    }
}

impl Change {
    /// Name in the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slipped => "slipped",
            Self::Lost => "lost",
            Self::Pushed => "pushed",
        }
    }
}

/// Logs an event of the sensing.
pub fn event(log: &mut impl Log, event: &Event) {
    match *event {
        Event::FrictionRecorded {
            closing_nm,
            opening_nm,
            residual_nm,
            coverage,
            wander_nm,
            wander_s,
        } => log.friction_recorded(
            closing_nm * MILLI,
            opening_nm * MILLI,
            residual_nm * MILLI,
            coverage,
            wander_nm * MILLI,
            wander_s,
        ),
        Event::FrictionNotRecorded { coverage } => log.friction_not_recorded(coverage),
        Event::FrictionStale { misfit_nm } => log.friction_stale(misfit_nm * MILLI),
        Event::Unusual {
            k_a_nm_per_rad,
            k_a_sigma_nm_per_rad,
            k_a_free_nm_per_rad,
        } => log.unusual(k_a_nm_per_rad, k_a_sigma_nm_per_rad, k_a_free_nm_per_rad),
        Event::Stiffness {
            k_a_nm_per_rad,
            k_a_sigma_nm_per_rad,
            k_a_free_nm_per_rad,
        } => log.stiffness(k_a_nm_per_rad, k_a_sigma_nm_per_rad, k_a_free_nm_per_rad),
        Event::Touch {
            time_us,
            theta_a_rad,
            torque_nm,
        } => log.touch(time_us, theta_a_rad * MILLI, torque_nm * MILLI),
        Event::Located {
            phalanx,
            k_m,
            sigma_m,
            k_c_nm_per_rad,
            force_n,
            radius_m,
            radius_sigma_m,
            settled,
            p_phalanx,
            force_sigma_n,
        } => log.located(
            phalanx,
            k_m * MILLI,
            sigma_m * MILLI,
            k_c_nm_per_rad,
            force_n,
            radius_m * MILLI,
            radius_sigma_m * MILLI,
            settled,
            p_phalanx,
            force_sigma_n,
        ),
        Event::Ambiguous {
            phalanx,
            k_m,
            sigma_m,
            settled,
            p_phalanx,
        } => log.ambiguous(
            phalanx[0],
            k_m[0] * MILLI,
            sigma_m[0] * MILLI,
            phalanx[1],
            k_m[1] * MILLI,
            sigma_m[1] * MILLI,
            settled,
            p_phalanx[0],
            p_phalanx[1],
        ),
        Event::NotLocated { why, torque_nm } => log.not_located(why.name(), torque_nm * MILLI),
        Event::Calibrated { calibration } => calibrated(log, &calibration),
        Event::CalibrationRefused { why } => log.calibration_refused(why.name()),
    }
}

/// How stiff the object of a place is, where it is told with this event: after the last word on the place. `last` is what the sensing
/// knows of it, if it does.
pub fn object_with(event: &Event, last: Option<Object>) -> Option<Object> {
    last.filter(|_| matches!(event, Event::Located { settled: true, .. }))
}

/// Logs how stiff an object is.
// A symbol of its own: its absence shows that a scene without the option does not carry this.
#[inline(never)]
pub fn object(log: &mut impl Log, told: &Object) {
    let [compliance, sigma] = told.compliance_m_per_n;
    let [share, share_sigma] = told.share;
    log.object(
        told.relative().name(),
        told.stiffness_n_per_m().unwrap_or(f32::NAN) / MILLI,
        told.least_n_per_m() / MILLI,
        compliance * MILLI,
        sigma * MILLI,
        share,
        share_sigma,
    );
}

/// Logs what follows the first contact.
pub fn followed(log: &mut impl Log, event: &Followed) {
    match *event {
        Followed::SecondContact {
            phalanx,
            k_m,
            sigma_m,
            theta_a_rad,
            torque_nm,
            stiffness_nm_per_rad,
            stiffness_sigma_nm_per_rad,
        } => log.second_contact(
            phalanx,
            k_m * MILLI,
            sigma_m * MILLI,
            theta_a_rad * MILLI,
            torque_nm * MILLI,
            stiffness_nm_per_rad,
            stiffness_sigma_nm_per_rad,
        ),
        Followed::Grasp {
            grip,
            torque_nm,
            forces,
        } => log.grasp(
            grip.name(),
            torque_nm * MILLI,
            forces.distal_moment_nm * MILLI,
            forces.distal_force_n,
            forces.proximal_moment_nm * MILLI,
        ),
        Followed::Moved {
            phalanx,
            k_m,
            sigma_m,
            torque_nm,
        } => log.moved(phalanx, k_m * MILLI, sigma_m * MILLI, torque_nm * MILLI),
        Followed::Changed {
            change,
            from_nm,
            to_nm,
        } => log.contact_change(change.name(), from_nm * MILLI, to_nm * MILLI),
    }
}

/// Logs what is known of efficiency over spring stiffness, and of the cable.
pub fn calibrated(log: &mut impl Log, calibration: &Calibration) {
    log.calibrated(
        calibration.torque_factor,
        calibration.torque_factor_sigma,
        calibration.cable_rad_per_nm * MILLI,
        calibration.cable_sigma_rad_per_nm * MILLI,
        calibration.correlation,
        calibration.stiffening_per_nm,
        calibration.stiffening_sigma_per_nm,
        calibration.contacts,
        calibration.presses,
    );
}

/// Logs the state of motor and sequence.
pub fn status(log: &mut impl Log, state: State, fault: Option<Fault>, status: &Status) {
    log.status(
        state.name(),
        status.position_counts,
        status.homed,
        status.current_a * MILLI,
        status.supply_v,
        status.winding_c,
        fault.map_or(0, Fault::number),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::selftest::SelfTestStep;
    use crate::drive::sequence::MotionResult;

    /// `TooSoft` as `too-soft`.
    fn kebab(variant: &str) -> String {
        let mut name = String::new();
        for letter in variant.chars() {
            if letter.is_ascii_uppercase() && !name.is_empty() {
                name.push('-');
            }
            name.push(letter.to_ascii_lowercase());
        }
        name
    }

    #[test]
    fn every_name_is_its_variant_s() {
        macro_rules! names {
            ($($kind:ident: $($variant:ident)*;)*) => {
                $($(assert_eq!($kind::$variant.name(), kebab(stringify!($variant)));)*)*
            };
        }
        names! {
            NotLocated: Proximal TooSoft Gap TooStiff Unexplained Unobservable TooFewSamples;
            Refusal: NoContact TooFewSamples NoSuchPlace Misfit Implausible Uninformative;
            Grip: Lost Single TwoContacts Enveloped;
            MotionResult: Contact NoContact NotRecorded Complete Stopped;
        }
        for step in SelfTestStep::ALL {
            assert_eq!(step.name(), kebab(&format!("{step:?}")));
        }
    }
}
