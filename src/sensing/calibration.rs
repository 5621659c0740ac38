//! Learns torque factor, cable and what the joints take from contacts at known places and from the closing stop.
//!
//! A motor torque determines the load at the input link only up to the gears' efficiency eta, and the finger's compliance is in
//! proportion to 1/K_2: only the ratio eta/K_2 matters for a location (docs/MECHANICS.md#beyond-the-paper). It is kept as a
//! factor f on the nominal ratio. The cable in series adds a twist in proportion to the torque; it is kept per newton metre *as
//! computed with the nominal efficiency*, so that pressing against the closing stop measures it whatever the efficiency is. Friction and
//! preload of the joints look much like a smaller factor: a pin tells both together, and the next contact is on the same joints.

use zerocopy::{FromBytes, Immutable, IntoBytes};

use super::torque_constant::ConstantShift;
use crate::numeric::{Bounded, sqrt};

/// Nominal torque at which the cable's twist is given: the middle of a probing, newton metre.
pub(super) const MIDDLE_NM: f32 = 0.17;

/// Torque factor, cable and torque of the joints with their uncertainty. Plain data, stored unchanged.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Calibration {
    /// f: eta/K_2 divided by its nominal value, > 0.
    pub torque_factor: f32,
    /// Standard deviation of ln f.
    pub torque_factor_sigma: f32,
    /// Twist of the cable per nominal torque, radian per newton metre, >= 0; 0 for a rigid one.
    pub cable_rad_per_nm: f32,
    /// Its standard deviation, radian per newton metre.
    pub cable_sigma_rad_per_nm: f32,
    /// Correlation of ln f and the cable's twist, -1 to 1.
    pub correlation: f32,
    /// Growth of the cable's stiffness with the nominal torque, as a share of it per newton metre, >= 0: the twist is that
    /// at the middle of a probing.
    pub stiffening_per_nm: f32,
    /// Its standard deviation.
    pub stiffening_sigma_per_nm: f32,
    /// Friction or preload of the joints beyond the first over what is assumed without pins, newton metre; of use once a pin has told it.
    pub joint_nm: f32,
    /// Its standard deviation, newton metre.
    pub joint_sigma_nm: f32,
    /// Correlation of ln f and that torque, -1 to 1.
    pub joint_correlation: f32,
    /// Error of the measured angle over a turn of the worm by pins, radian: amplitudes of the cosine and the sine of the worm's angle,
    /// which is 0 where the input link's is; 0 before a pin.
    pub worm_rad: [f32; 2],
    /// Contacts at known places used.
    pub contacts: u16,
    /// Presses against the closing stop used.
    pub presses: u16,
}

impl Calibration {
    /// Whether every value is finite and in its range; to be checked after reading it from flash.
    pub fn is_valid(&self) -> bool {
        let sizes = [
            self.cable_rad_per_nm,
            self.stiffening_per_nm,
            self.torque_factor_sigma,
            self.cable_sigma_rad_per_nm,
            self.stiffening_sigma_per_nm,
            self.joint_sigma_nm,
        ];
        let [cosine_rad, sine_rad] = self.worm_rad;
        let signed = [
            self.correlation,
            self.joint_correlation,
            self.joint_nm,
            cosine_rad,
            sine_rad,
        ];
        (0.05..=20.0).contains(&self.torque_factor)
            && sizes.iter().all(|size| (0.0..=100.0).contains(size))
            && signed.iter().all(|value| (-1.0..=1.0).contains(value))
    }

    /// The cable's twist by a rise of the nominal torque up to `nominal_nm`, and its standard deviation, radian.
    pub fn twist_rad(&self, rise_nm: f32, nominal_nm: f32) -> [f32; 2] {
        let bent_nm2 = rise_nm * (nominal_nm - 0.5 * rise_nm - MIDDLE_NM);
        let bent_by = self.cable_rad_per_nm * bent_nm2;
        let stiff_sigma_rad = bent_by * self.stiffening_sigma_per_nm;
        let cable_sigma_rad = self.cable_sigma_rad_per_nm * rise_nm;
        [
            self.cable_rad_per_nm * rise_nm - bent_by * self.stiffening_per_nm,
            sqrt(cable_sigma_rad * cable_sigma_rad + stiff_sigma_rad * stiff_sigma_rad),
        ]
    }

    /// Adopts the result of a fit at a known place if it is credible and adds information. `misfit` is the mean square
    /// residual in variances, `strain` how far it contradicts what else is known ([`Learned`](super::locator::Learned)).
    ///
    /// # Errors
    /// The reason why it is refused; nothing is changed then.
    pub fn with_contact(&self, found: &Self, misfit: f32, strain: f32) -> Result<Self, Refusal> {
        // In this form a NaN is refused too.
        if !(found.is_valid() && misfit <= MISFIT) {
            return Err(Refusal::Misfit);
        }
        let factor_shift = (found.torque_factor / self.torque_factor - 1.0).abs();
        let cable_shift = (found.cable_rad_per_nm - self.cable_rad_per_nm).abs();
        // A later pin may not move the factor as far as the first one.
        let most = if self.contacts > 0 {
            CONTRADICTORY
        } else {
            IMPLAUSIBLE
        };
        let is_plausible = factor_shift <= most * self.torque_factor_sigma
            && cable_shift <= IMPLAUSIBLE * self.cable_sigma_rad_per_nm
            && strain <= IMPLAUSIBLE * IMPLAUSIBLE;
        if !is_plausible {
            return Err(Refusal::Implausible);
        }
        // Residuals larger than expected increase the deviations in proportion.
        let mut learned = Self {
            contacts: self.contacts.saturating_add(1),
            // A pin determines both at the same time.
            stiffening_per_nm: self.stiffening_per_nm,
            stiffening_sigma_per_nm: self.stiffening_sigma_per_nm,
            presses: self.presses,
            ..*found
        };
        learned.swell(misfit, self);
        if self.ignorance() < INFORMATIVE * learned.ignorance() {
            return Err(Refusal::Uninformative);
        }
        // A contradiction is news, but the compromise is as much less sure.
        if self.contacts > 0 {
            learned.torque_factor_sigma =
                sqrt(misfit.at_least(1.0)) * self.factor_sigma_alone(found);
        }
        learned.swell(strain, self);
        // Where it moves the factor by more than the earlier pins were unsure, nobody knows which of them is wrong.
        if self.contacts > 0 {
            let before = self.torque_factor_sigma;
            let unexplained = factor_shift * factor_shift - before * before;
            learned.widen(sqrt(unexplained.at_least(0.0)));
        }
        Ok(learned)
    }

    /// Makes a calibration less sure by a ratio of variances, at least 1; factor and cable no less sure than before.
    #[inline(never)]
    fn swell(&mut self, ratio: f32, before: &Self) {
        let swell = sqrt(ratio.at_least(1.0));
        self.torque_factor_sigma =
            (swell * self.torque_factor_sigma).at_most(before.torque_factor_sigma);
        self.cable_sigma_rad_per_nm =
            (swell * self.cable_sigma_rad_per_nm).at_most(before.cable_sigma_rad_per_nm);
        self.joint_sigma_nm *= swell;
    }

    /// Adopts the result of a press against the closing stop, where the finger is rigid, as [`Calibration::with_contact`].
    ///
    /// # Errors
    /// Why not; nothing is changed then.
    pub fn with_press(&self, found: &Self, misfit: f32) -> Result<Self, Refusal> {
        let learned = self.with_contact(found, misfit, 1.0)?;
        Ok(Self {
            presses: self.presses.saturating_add(1),
            torque_factor: learned.torque_factor,
            torque_factor_sigma: learned.torque_factor_sigma,
            cable_rad_per_nm: learned.cable_rad_per_nm,
            cable_sigma_rad_per_nm: learned.cable_sigma_rad_per_nm,
            correlation: learned.correlation,
            stiffening_per_nm: found.stiffening_per_nm,
            stiffening_sigma_per_nm: (sqrt(misfit.at_least(1.0)) * found.stiffening_sigma_per_nm)
                .at_most(self.stiffening_sigma_per_nm),
            // The joints stand meanwhile, and what pins have told of them stays: the factor moves little once they have.
            ..*self
        })
    }

    /// Deviation of ln f by the new contact alone, of a fit that began with this calibration. Most of it (friction in the contact and in
    /// the joints, lengths of the links) is the same at every pin and does not average out: several are as sure as the best of them
    /// (docs/SENSING.md#pins).
    fn factor_sigma_alone(&self, found: &Self) -> f32 {
        // Both as shares of the new value.
        let before = self.torque_factor_sigma * self.torque_factor / found.torque_factor;
        let [before, now] = [before, found.torque_factor_sigma].map(|sigma| 1.0 / (sigma * sigma));
        1.0 / sqrt((now - before).at_least(f32::MIN_POSITIVE))
    }

    /// Widens the torque factor's deviation by another one that has nothing to do with it, as a share: that of the leverage between two
    /// places of the finger, or what pins contradict each other by. The cable and its covariance with the factor stay as they are.
    pub fn widen(&mut self, share: f32) {
        let before = self.torque_factor_sigma;
        self.widen_to(sqrt(before * before + share * share));
    }

    /// Sets the torque factor's deviation to a larger one, for a reason that has nothing to do with cable and joints: their covariance
    /// with the factor stays, and the correlations shrink.
    // Not inlined: called from several places.
    #[inline(never)]
    fn widen_to(&mut self, sigma: f32) {
        let before = core::mem::replace(&mut self.torque_factor_sigma, sigma);
        let narrower = before / sigma.at_least(f32::MIN_POSITIVE);
        self.correlation *= narrower;
        self.joint_correlation *= narrower;
    }

    /// Moves what was measured to another closing speed. The worm's efficiency, which is part of the torque factor and of the cable's twist
    /// per nominal torque, is expected to differ by `share` there. A factor that no pin has told is expected of every speed, and so is a
    /// cable that nothing has. Returning to the old speed does not narrow the deviations.
    pub(super) fn change_speed(&mut self, share: f32) {
        if self.contacts == 0 && self.presses == 0 {
            return;
        }
        // A change back to the old speed undoes this one.
        let other = (1.0 + 0.5 * share) / (1.0 - 0.5 * share);
        let doubt = SPEED_DOUBT * share.abs();
        self.cable_rad_per_nm *= other;
        self.cable_sigma_rad_per_nm += doubt * self.cable_rad_per_nm;
        if self.contacts > 0 {
            self.torque_factor *= other;
            self.widen_to(self.torque_factor_sigma + doubt);
        }
    }

    /// Takes what the motor's back-EMF tells of its torque constant, as long as no pin has told the torque factor.
    pub(super) fn correct_constant(&mut self, constant: &ConstantShift) {
        if self.contacts == 0 {
            let before = self.torque_factor_sigma;
            self.torque_factor *= 1.0 + constant.share;
            self.torque_factor_sigma =
                sqrt((before * before - constant.variance).at_least(LEAST_SIGMA * LEAST_SIGMA))
                    .at_most(before);
        }
    }

    /// Takes what free closings tell of the torque factor, value and deviation as a share of it, as long as no pin has told it. A value
    /// that nobody would expect is ignored: friction has changed along the travel, or a spring is not the scene's.
    #[cfg(not(weightless))]
    pub(super) fn correct_factor(&mut self, [factor, sigma]: [f32; 2]) {
        let before = self.torque_factor_sigma * self.torque_factor_sigma;
        let all = before + sigma * sigma;
        let news = factor / self.torque_factor - 1.0;
        if self.contacts == 0 && news * news < IMPLAUSIBLE * IMPLAUSIBLE * all {
            self.torque_factor *= 1.0 + before / all * news;
            self.torque_factor_sigma *= sigma / sqrt(all);
        }
    }

    /// What is known of friction or preload of the joints, mean and deviation, newton metre, from that without pins. The correlation with
    /// ln f becomes that of this deviation.
    pub fn joint(&mut self, [mean_nm, sigma_nm]: [f32; 2]) -> [f32; 2] {
        if self.contacts == 0 {
            return [mean_nm, sigma_nm];
        }
        let told_nm = self.joint_sigma_nm;
        let now_nm = sqrt(told_nm * told_nm + CHANGE_NM * CHANGE_NM);
        self.joint_correlation *= told_nm / now_nm;
        [mean_nm + self.joint_nm, now_nm]
    }

    /// Remaining uncertainty: area of the one-sigma ellipse. Each axis has a floor, below which more certainty is of no use.
    fn ignorance(&self) -> f32 {
        let cable_floor = 1e-3 * self.cable_rad_per_nm + 1e-6;
        self.torque_factor_sigma.at_least(1e-3)
            * self.cable_sigma_rad_per_nm.at_least(cable_floor)
            * self.independence().at_least(0.02)
    }

    /// Share of the cable's deviation that is not correlated with the factor.
    pub(super) fn independence(&self) -> f32 {
        independence(self.correlation)
    }
}

/// Share of a deviation that such a correlation with another value leaves.
// Not inlined: rarely called, from several places.
#[inline(never)]
pub(super) fn independence(correlation: f32) -> f32 {
    sqrt((1.0 - correlation * correlation).at_least(0.0))
}

/// Standard deviation of the joints' friction from one contact to the next, newton metre: as much as is assumed of a joint in plain
/// bearings, because its friction grows with the load (R, chosen).
const CHANGE_NM: f32 = 0.4e-3;
/// Deviation of what another speed makes of the torque factor, as a share of what is expected of it.
const SPEED_DOUBT: f32 = 0.7;
/// Least deviation of ln f that a torque constant leaves: gears and springs are never known from it.
const LEAST_SIGMA: f32 = 0.03;
/// Mean square residual, in variances, above which the curve is not that of the stated contact.
const MISFIT: f32 = 4.0;
/// A larger change, in standard deviations, is taken as a mistake of the user.
const IMPLAUSIBLE: f32 = 4.0;
/// The same of the torque factor once a pin has told it. A pin that is where it is said to be moves it by a third to a half of its
/// deviation (docs/SENSING.md#pins).
const CONTRADICTORY: f32 = 2.5;
/// Factor by which a calibration must reduce the uncertainty.
const INFORMATIVE: f32 = 1.02;

/// Why a calibration is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// No contact was felt.
    NoContact,
    /// Too little torque or too few samples: press longer.
    TooFewSamples,
    /// No such place on the finger.
    NoSuchPlace,
    /// The curve does not fit a contact there or at the stop: check the place, and whether anything else touches the finger.
    Misfit,
    /// The result is so far from the expected values that a wrong place is more likely.
    Implausible,
    /// It improves neither factor nor cable: choose another place.
    Uninformative,
}
