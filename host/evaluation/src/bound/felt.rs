//! A finger that is drawn from what is known of it before any contact, curves of its pins and of a contact with their noise, and what
//! they tell where they are taken for linear in the unknowns: the exact posterior ([`super::sampled`]) and the library ([`super::ours`])
//! are given the same.

use nalgebra::{DMatrix, DVector};
use palpate_simulation::places::{PIN_RAD, PIN_SHARES};
use rand_pcg::Pcg64Mcg;

use super::chain::normals;
use super::information::{Observed, PIN_SIGMA_M, Pulleys, forget, told};
use super::known::{
    BEND, CABLE, Chosen, DETECTED_RAD, FACTOR, FRICTION, GIVE, JOINT, K, Known, LOSS, ONSET,
    PULLEYS, RADIUS, RETURN_PULLEYS, UNKNOWNS, is_possible,
};

/// Unknowns of a finger.
const OF_FINGER: [usize; 9] = [
    FACTOR,
    CABLE,
    BEND,
    JOINT,
    LOSS,
    PULLEYS[0],
    PULLEYS[1],
    RETURN_PULLEYS[0],
    RETURN_PULLEYS[1],
];
/// Unknowns of an object that cannot be negative.
pub(super) const OF_OBJECT: [usize; 2] = [FRICTION, GIVE];

/// A curve with its noise.
pub(super) struct Felt {
    pub(super) observed: Observed,
    /// Noise in units of its deviation, white.
    pub(super) white: DVector<f64>,
    /// Torques with noise, newton metre.
    pub(super) measured: DVector<f64>,
    /// Where the contact is felt to begin, radian.
    pub(super) detected_rad: f64,
}

/// A pin's curve, and the place that it is said to be at, metre.
pub(super) struct Pin {
    pub(super) k_m: f64,
    pub(super) felt: Felt,
}

/// What is known of a finger, in units of the deviations: covariance, and how far the means are from the truth.
#[derive(Clone)]
pub(super) struct Belief {
    pub(super) covariance: DMatrix<f64>,
    pub(super) off: DVector<f64>,
}

impl Belief {
    /// Replaces what is known of one unknown.
    fn forget(&mut self, unknown: usize, variance: f64, off: f64) {
        forget(&mut self.covariance, unknown, variance);
        self.off[unknown] = off;
    }
}

impl Known {
    /// A curve with noise.
    pub(super) fn felt(&self, observed: Observed, random: &mut Pcg64Mcg) -> Felt {
        let white = normals(observed.torques.len(), random);
        let late_rad = DETECTED_RAD * normals(1, random)[0];
        Felt {
            measured: &observed.torques + &observed.lower * &white,
            detected_rad: observed.values[ONSET] + late_rad,
            observed,
            white,
        }
    }

    /// Values of a finger, of a material and of an object, drawn from what is known after a press on the stop; those of a contact are the
    /// means'. None that cannot be.
    pub(super) fn values(&self, random: &mut Pcg64Mcg) -> Option<[f64; UNKNOWNS]> {
        let deviations = self.deviations(self.lengths_m[0]);
        let known = self.pressed(&deviations, Pulleys::Off);
        let mut values = self.means(&Chosen::SOME);
        // Pulleys of a return cable come last, so that fingers without one are drawn as if there were none.
        let number = if self.opened.back.is_some() {
            UNKNOWNS
        } else {
            RETURN_PULLEYS[0]
        };
        let off = normals(number, random);
        let unknowns = OF_FINGER.into_iter().chain(OF_OBJECT);
        for unknown in unknowns.filter(|&unknown| deviations[unknown] > 0.0) {
            let sigma = deviations[unknown] * known[(unknown, unknown)].sqrt();
            values[unknown] += sigma * off[unknown];
        }
        is_possible(&values, &OF_OBJECT).then_some(values)
    }

    /// A contact as in the experiments with drawn fingers, on this finger.
    pub(super) fn touched(&self, finger: &[f64; UNKNOWNS], random: &mut Pcg64Mcg) -> Option<Felt> {
        let chosen = self.drawn(random)?;
        let means = self.means(&chosen);
        let mut values = *finger;
        for unknown in [K, RADIUS, ONSET] {
            values[unknown] = means[unknown];
        }
        let observed = self.observed(chosen.phalanx, values)?;
        Some(self.felt(observed, random))
    }

    /// A pin of a guided calibration at this share of the last phalanx.
    pub(super) fn pin(&self, share: f64) -> Option<Chosen> {
        let phalanx = self.lengths_m.len();
        Some(Chosen {
            phalanx,
            k_m: share * self.lengths_m[phalanx - 1],
            object_m: self.settings.pin_radius_m.into(),
            onset_rad: self.onset_rad(PIN_RAD)?,
        })
    }

    /// The two pins of a guided calibration on this finger, of a material of their own.
    pub(super) fn pins(&self, finger: &[f64; UNKNOWNS], random: &mut Pcg64Mcg) -> Option<Vec<Pin>> {
        let friction = self.values(random)?[FRICTION];
        let pin = |share: f64| {
            let told = self.pin(share)?;
            let chosen = Chosen {
                k_m: told.k_m + PIN_SIGMA_M * normals(1, random)[0],
                ..told
            };
            let mut values = self.means(&chosen);
            for unknown in OF_FINGER {
                values[unknown] = finger[unknown];
            }
            values[FRICTION] = friction;
            let observed = self.observed(chosen.phalanx, values)?;
            let felt = self.felt(observed, random);
            Some(Pin {
                k_m: told.k_m,
                felt,
            })
        };
        PIN_SHARES.into_iter().map(pin).collect()
    }

    /// What is known of a finger after a press on the stop, for a contact or pin with these values.
    pub(super) fn believed(&self, values: &[f64; UNKNOWNS]) -> Belief {
        let deviations = self.deviations(self.lengths_m[0]);
        let means = self.means(&Chosen::SOME);
        let mut off = DVector::zeros(UNKNOWNS);
        for unknown in OF_FINGER.into_iter().chain(OF_OBJECT) {
            if deviations[unknown] > 0.0 {
                off[unknown] = (means[unknown] - values[unknown]) / deviations[unknown];
            }
        }
        Belief {
            covariance: self.pressed(&deviations, Pulleys::Off),
            off,
        }
    }

    /// The same with what the curves of its pins have told beside, where they are linear in the unknowns about the truth.
    pub(super) fn taught(&self, finger: &[f64; UNKNOWNS], pins: &[Pin]) -> Option<Belief> {
        let deviations = self.deviations(*self.lengths_m.last()?);
        let afresh = self.believed(finger);
        let mut belief = afresh.clone();
        // One material of both.
        let rubs = self.believed(&pins.first()?.felt.observed.values).off[FRICTION];
        belief.forget(FRICTION, 1.0, rubs);
        for Pin { k_m, felt } in pins {
            let values = &felt.observed.values;
            let place_off = (k_m - values[K]) / deviations[K];
            let late = (felt.detected_rad - values[ONSET]) / deviations[ONSET];
            belief.forget(K, (PIN_SIGMA_M / deviations[K]).powi(2), place_off);
            belief.forget(RADIUS, 0.0, 0.0);
            belief.forget(ONSET, 1.0, late);
            belief.forget(GIVE, 0.0, 0.0);
            let secants = self.secants(&felt.observed, &deviations, &belief.covariance)?;
            let surprise = felt.white.rows(0, secants.nrows()) - &secants * &belief.off;
            belief.covariance = told(&belief.covariance, &secants.tr_mul(&secants))?;
            belief.off += &belief.covariance * secants.tr_mul(&surprise);
        }
        // Another contact, another material.
        for unknown in [FRICTION, K, RADIUS, ONSET, GIVE] {
            let variance = afresh.covariance[(unknown, unknown)];
            belief.forget(unknown, variance, afresh.off[unknown]);
        }
        Some(belief)
    }
}
