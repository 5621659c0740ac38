//! Where to start from: the finger's inverse is asked for places as stiff as the curve.

use super::Locator;
use crate::finger::{Candidate, Class, Free, Inverse, Mechanics};
use crate::numeric::{Bounded, clamp};
use crate::sensing::Drivetrain;
use crate::sensing::curve;
use crate::sensing::fit::{Hypothesis, LEAST_POINTS, Place, Prior, free_behind_cable};
use crate::sensing::location::Series;

/// Torque at which hypotheses are first made, in standard deviations of the offset and of a point.
const FIRST_SIGMAS: f32 = 8.0;
/// Growth of the torque after which the slope is asked again for places not thought of.
const ASK_AGAIN: f32 = 1.8;
/// Least distance of two fits that start on either side of the stiffest place, as a share of the phalanx (chosen).
const APART: f32 = 0.4;
/// Share of a slope's compliance that may be all there is (chosen).
const STIFFER: f32 = 0.5;
/// Nearer to the joint than this share of the phalanx no fit is pushed.
const LEAST_START: f32 = 0.05;
/// Two places closer than this share of the phalanx are one.
const SAME_PLACE: f32 = 0.12;

impl Locator {
    /// Whether the torque has grown enough for places not thought of.
    pub(super) fn is_time_to_ask<X: Series>(&mut self, prior: &Prior<X>) -> bool {
        let Some(last) = self.points.last() else {
            return false;
        };
        let rise = last.torque_nm;
        let variance = last.variance_nm2 + prior.offset_sigma_nm * prior.offset_sigma_nm;
        let due = self.points.len() >= LEAST_POINTS
            && rise > ASK_AGAIN * self.asked_at_nm
            && rise * rise > FIRST_SIGMAS * FIRST_SIGMAS * variance;
        if due {
            self.asked_at_nm = rise;
        }
        due
    }

    /// Asks the finger's inverse where a contact of the measured slope may be.
    pub(super) fn ask<F: Mechanics, X: Series>(
        &mut self,
        finger: &F,
        (origin_rad, drivetrain): (f32, &Drivetrain),
        prior: &Prior<X>,
        near: &F::Configuration,
    ) {
        let Some(slope) = curve::slope(&self.points, f32::NEG_INFINITY, drivetrain.creep[0]) else {
            return;
        };
        if let Place::Known { phalanx, k_m, .. } = prior.place {
            // Calibration: the place is told, and only that.
            if self.hypotheses.is_empty() {
                self.add(finger, phalanx, k_m, prior);
            }
            return;
        }
        let rad_per_nm = slope.counts_per_nm * drivetrain.rad_per_count;
        let calibration = &prior.calibration;
        let cable_rad_per_nm = if X::FLEXIBLE {
            calibration.cable_rad_per_nm
        } else {
            0.0
        };
        let compliance = (rad_per_nm - cable_rad_per_nm) / calibration.torque_factor;
        let free_at = |onset_rad| {
            free_behind_cable::<F, X>(finger, onset_rad, calibration, prior.creep[0], near)
        };
        // The curve begins at the torque that holds the free finger there, not at none.
        let held_nm = free_at(prior.onset_rad.0)
            .map_or(0.0, |free| free.torque_nm / calibration.torque_factor);
        let onset_rad =
            origin_rad + slope.onset_counts * drivetrain.rad_per_count + rad_per_nm * held_nm;
        let Some(free) = free_at(onset_rad) else {
            return;
        };
        let inverse = places(finger, &free, compliance);
        self.class = if compliance > 0.0 {
            inverse.class()
        } else {
            Class::TooStiff
        };
        if self.hypotheses.is_empty() {
            self.add(finger, 1, 0.0, prior);
        }
        // A slope that is not sure may put one of two places just off the tip: a stiffer one brings it back.
        let stiffer = places(finger, &free, STIFFER * compliance);
        for candidate in inverse.candidates().iter().filter(|c| c.phalanx > 1) {
            let &Candidate { phalanx, k_m, .. } = candidate;
            let beside = |c: &&Candidate| {
                c.phalanx == phalanx && c.beyond_stiffest != candidate.beyond_stiffest
            };
            let twin = inverse.candidates().iter().find(beside);
            let off_the_tip = || stiffer.candidates().iter().find(beside);
            let length = finger.phalanx_length_m(phalanx).unwrap_or(0.0);
            match (twin, off_the_tip()) {
                (Some(twin), _) => {
                    self.add(finger, phalanx, apart(k_m, twin.k_m, length), prior);
                }
                (None, Some(other)) => {
                    self.add(finger, phalanx, apart(k_m, other.k_m, length), prior);
                    self.add(finger, phalanx, apart(other.k_m, k_m, length), prior);
                }
                (None, None) => self.add(finger, phalanx, k_m, prior),
            }
        }
        // No place is as soft or as stiff as the slope: the nearest one there is, on each phalanx that has none.
        let share = match self.class {
            Class::TooStiff => 0.85,
            Class::Proximal | Class::Gap | Class::TooSoft => 0.1,
            _ => return,
        };
        for phalanx in 2..=F::PHALANGES as u8 {
            if !self.hypotheses.iter().any(|h| h.phalanx() == phalanx) {
                let length = finger.phalanx_length_m(phalanx).unwrap_or(0.0);
                self.add(finger, phalanx, share * length, prior);
            }
        }
    }

    /// Adds a hypothesis unless there is one like it; the worst one makes room.
    fn add<F: Mechanics, X: Series>(
        &mut self,
        finger: &F,
        phalanx: u8,
        k_m: f32,
        prior: &Prior<X>,
    ) {
        let Some(length) = finger.phalanx_length_m(phalanx) else {
            return;
        };
        let known = self.hypotheses.iter().any(|h| {
            h.phalanx() == phalanx
                && (phalanx == 1 || (h.stands_at() - k_m / length).abs() < SAME_PLACE)
        });
        if known {
            return;
        }
        let new = Hypothesis::new(phalanx, k_m, length, prior);
        if !self.hypotheses.is_full() {
            let _ = self.hypotheses.push(new);
            return;
        }
        let mut worst = None;
        let mut least = f32::INFINITY;
        for hypothesis in &mut self.hypotheses {
            let evidence = hypothesis.ln_evidence(1.0);
            if !hypothesis.is_proximal() && evidence < least {
                least = evidence;
                worst = Some(hypothesis);
            }
        }
        if let Some(worst) = worst {
            *worst = new;
        }
    }
}

/// Places as compliant as this; where nothing is left of a compliance, the stiffest.
// Once in flash, though asked twice.
#[inline(never)]
fn places<F: Mechanics>(
    finger: &F,
    free: &Free<F::Configuration>,
    compliance_rad_per_nm: f32,
) -> Inverse {
    let compliance_rad_per_nm = compliance_rad_per_nm.at_least(1e-6);
    finger.locate(&free.configuration, free.torque_nm, compliance_rad_per_nm)
}

/// A start beside one of two places of a phalanx that explain a slope. A steep curve puts both at the stiffest place, which
/// says nothing about the side: fits that start there may both take the same.
fn apart(k_m: f32, twin_m: f32, length_m: f32) -> f32 {
    let middle = 0.5 * (k_m + twin_m);
    let half = (0.5 * (k_m - twin_m))
        .abs()
        .at_least(0.5 * APART * length_m);
    let start = if k_m < twin_m {
        middle - half
    } else {
        middle + half
    };
    clamp(start, LEAST_START * length_m, length_m)
}
