//! The contact is pressed: each block joins the curve, and the locator takes a step.

use super::known::Known;
use super::search::Past;
use super::touch::{Touch, Touching};
use crate::finger::Mechanics;
use crate::numeric::sqrt;
use crate::sensing::Directive;
use crate::sensing::fit::{Place, Prior};
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;
use core::marker::PhantomData;

/// Deviation of the onset as the detector sees it, radian: a tenth of a second of motion.
const ONSET_SIGMA_RAD: f32 = 0.03;
/// How well a pin is placed by hand or by a gauge, metre (R, chosen).
const PIN_SIGMA_M: f32 = 0.3e-3;
/// A point enters the fit when its torque stands this many deviations above zero.
const CLEAR_SIGMAS: f32 = 4.0;
/// A contact is lost when the torque falls by this share of itself and this many deviations of a block.
const LOST_SHARE: f32 = 0.03;
const LOST_SIGMAS: f32 = 8.0;

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    /// The contact goes on.
    pub(super) fn press(&mut self, touching: &mut Touching<H::Reading>, past: &Past<H::Reading>) {
        if self.is_lost(&touching.touch, past) {
            touching.end();
            return;
        }
        self.add(&mut touching.touch, past);
        if self.presses_stop() || touching.settled {
            return;
        }
        let judged = self.refine(touching);
        if judged && matches!(self.directive, Directive::Watch) {
            self.report(touching, false);
        }
    }

    /// Whether the torque has fallen: the finger slid off, or the object gave way. What comes after is another contact.
    fn is_lost(&self, touch: &Touch<H::Reading>, past: &Past<H::Reading>) -> bool {
        let efficiency = self.drivetrain.efficiency;
        let torque_nm = efficiency * (past.residual_nm - touch.level_nm);
        let block = efficiency * sqrt(touch.noise_nm2_counts / past.width_counts.max(1) as f32);
        touch.torque_nm - torque_nm > LOST_SHARE * touch.torque_nm + LOST_SIGMAS * block
    }

    pub(super) fn prior(&self, touching: &Touching<H::Reading>) -> Prior<X> {
        let settings = &self.settings;
        Prior {
            place: match self.directive {
                Directive::Calibrate { phalanx, k_m } => Place::Known {
                    phalanx,
                    k_m,
                    sigma_m: PIN_SIGMA_M,
                },
                _ => Place::Anywhere,
            },
            radius_m: (settings.radius_m, settings.radius_sigma_m),
            offset_sigma_nm: self.drivetrain.efficiency * touching.touch.level_sigma_nm,
            onset_rad: (touching.touch.onset_rad, ONSET_SIGMA_RAD),
            calibration: self.calibration,
            creep: self.drivetrain.creep,
            inertia_share: self.drivetrain.inertia_share,
            series: PhantomData,
        }
    }

    /// One step of the locator; true at the end of a round.
    // A symbol of its own, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub(super) fn refine(&self, touching: &mut Touching<H::Reading>) -> bool {
        let prior = self.prior(touching);
        let free_nm = self
            .free(touching.touch.onset_rad)
            .map_or(0.0, |free| free.torque_nm)
            / self.calibration.torque_factor;
        let offset_variance = prior.offset_sigma_nm * prior.offset_sigma_nm;
        let points = touching.touch.curve.points().filter(|p| {
            let clear = p.torque_nm - free_nm;
            let variance = p.variance_nm2 + offset_variance;
            clear > 0.0 && clear * clear > CLEAR_SIGMAS * CLEAR_SIGMAS * variance
        });
        let origin_rad = self
            .drivetrain
            .closing_rad(touching.touch.curve.origin_counts());
        touching.locator.refine(
            &self.finger,
            points,
            (origin_rad, &self.drivetrain),
            &prior,
            &self.posture,
        )
    }
}
