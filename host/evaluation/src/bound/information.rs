//! What the data hold of a place on any finger, by Fisher's information: derivatives of an independent finger's torque curve
//! ([`Held`]) by everything that the locator does not know, the noise that it assumes, and its priors.
//!
//! It bounds the mean square error of an estimator that knows as little and whose lengths are exact; for a normal error the mean without
//! sign is [`MEAN_SHARE`] of the deviation. Where the torque hardly depends on the place the curve is not linear in it over that
//! deviation, and the bound is rough; there is a posterior by sampling for that ([`super::sampled`]). On the
//! prototype it is compared with the exact posterior (`tests/all/bound.rs`). Means over contacts are in [`super::mean`].

use nalgebra::{DMatrix, DVector};
use palpate_simulation::places::PIN_SHARES;

use super::known::{
    Chosen, FACTOR, FRICTION, GIVE, JOINT, K, Known, ONSET, PULLEYS, RADIUS, RETURN_PULLEYS, TURNS,
    UNIFORM, UNKNOWNS,
};
use crate::reference::{Curve, Held, State};

/// Mean of a normal variable without its sign, over its deviation.
pub const MEAN_SHARE: f64 = 0.798;
/// Steps of the differences, in deviations of an unknown.
pub(super) const DIFFERENCE: f64 = 5e-3;
/// What a pin leaves open: its place and its radius, metre.
pub(super) const PIN_SIGMA_M: f64 = 0.3e-3;
/// Steps of the differences by which a pin is taken for linear, in what is known of an unknown before it: where a curve bends over that, as
/// where a finger begins to fold round the pin, its derivative would tell more than the curve does. Of the onset, in its deviations.
const SECANT: f64 = 0.5;
const SECANT_ONSET: f64 = 0.1;
/// Points before the onset.
pub(super) const LEAD: usize = 4;
/// Points of a curve at least.
const LEAST_POINTS: usize = 8;
/// Share of the probing's torque up to which a curve is taken.
pub(super) const TOP_SHARE: f64 = 0.95;

/// What is known of the pulleys of a tendon and of a return cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pulleys {
    /// They are as the scene has them.
    Exact,
    /// Each is off by itself.
    Off,
}

impl Pulleys {
    /// Makes exact what is.
    fn know(self, known: &mut DMatrix<f64>) {
        if self == Self::Exact {
            for unknown in PULLEYS.into_iter().chain(RETURN_PULLEYS) {
                forget(known, unknown, 0.0);
            }
        }
    }
}

/// What ends a curve before its angles do, beside the end of phalanx and travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// Nothing.
    Open,
    /// The nominal torque above the free finger's is this, newton metre.
    Top(f64),
    /// The same, or another phalanx touches the object as well: what follows is of two contacts.
    Alone(f64),
}

impl End {
    fn is_above(self, excess_nm: f64) -> bool {
        match self {
            Self::Open => false,
            Self::Top(top_nm) | Self::Alone(top_nm) => excess_nm > top_nm,
        }
    }
}

/// The curve of a contact.
pub(super) struct Observed {
    pub(super) phalanx: usize,
    /// Values of all unknowns.
    pub(super) values: [f64; UNKNOWNS],
    /// Measured angles, radian, and nominal torque above the free finger's there, newton metre.
    pub(super) angles: Vec<f64>,
    pub(super) torques: DVector<f64>,
    /// Cholesky factor, lower triangle, of the noise's covariance.
    pub(super) lower: DMatrix<f64>,
}

impl Known {
    /// Nominal torque above the free finger's at measured angles, until it is to end, a joint has met its stop, the contact has left its
    /// phalanx or no posture is found.
    pub(super) fn excess_nm(
        &self,
        phalanx: usize,
        values: &[f64; UNKNOWNS],
        angles: &[f64],
        end: End,
    ) -> Option<Vec<f64>> {
        let (press, drive) = self.press(phalanx, values);
        let opened = self.with_pulleys(values);
        let held = Held::new(&opened, press, values[ONSET], &drive)?;
        let length_m = self.lengths_m[phalanx - 1];
        let mut near: State = held.start().clone();
        let mut found = Vec::new();
        let width_rad = TURNS * self.turn_rad;
        for &middle_rad in angles {
            let past_rad = middle_rad + 0.5 * width_rad - values[ONSET];
            if past_rad <= 0.0 {
                found.push(0.0);
                continue;
            }
            // The point in which the contact begins has the mean of a ramp over the part that is left.
            let (angle_rad, share) = if past_rad < width_rad {
                (middle_rad + 0.5 * width_rad, 0.5 * past_rad / width_rad)
            } else {
                (middle_rad, 1.0)
            };
            // Less is known then, and the bound is larger: of one pin of `tendon3` a third of its torque counts.
            let Some(next) = held.at(angle_rad, &drive, &near) else {
                break;
            };
            near = next;
            let free = opened.free(angle_rad, &drive)?;
            let excess_nm = share * (near.torque_nm - free.torque_nm) / drive.factor;
            if !held.stays(&near, length_m)
                || end.is_above(excess_nm)
                || matches!(end, End::Alone(_)) && held.touches_elsewhere(&near, self.first)
            {
                break;
            }
            found.push(excess_nm);
        }
        Some(found)
    }

    /// Torque at which a curve ends, newton metre.
    pub(super) fn top_nm(&self) -> f64 {
        TOP_SHARE * f64::from(self.settings.torque_limit_nm)
    }

    /// Measured angles of a curve's points until the probing ends, radian. They are whole turns of the motor: a contact begins anywhere
    /// within a point.
    fn angles(&self, onset_rad: f64) -> Vec<f64> {
        let width_rad = TURNS * self.turn_rad;
        let first = (onset_rad / width_rad).floor() - LEAD as f64;
        let way_rad = self.probing_rad.min(self.closed_rad - onset_rad);
        let points = (way_rad / width_rad).max(0.0) as usize;
        (0..LEAD + points)
            .map(|index| width_rad * (first + index as f64 + 0.5))
            .collect()
    }

    /// The curve of a contact with these values: `None` where the contact slides off too soon, or another phalanx touches before it.
    pub(super) fn observed(&self, phalanx: usize, values: [f64; UNKNOWNS]) -> Option<Observed> {
        let onset_rad = values[ONSET];
        let mut angles = self.angles(onset_rad);
        let shown = |end: End| self.excess_nm(phalanx, &values, &angles, end);
        let mut torques = shown(End::Top(self.top_nm()))?;
        let alone = shown(End::Alone(self.top_nm()))?.len();
        if torques.len() < LEAD + LEAST_POINTS || alone <= LEAD {
            return None;
        }
        torques.truncate(alone);
        angles.truncate(alone);
        let points = angles.iter().zip(&torques).enumerate();
        let samples = points.map(|(index, (&angle_rad, &excess_nm))| {
            self.sample(angle_rad, TURNS * index as f64, excess_nm)
        });
        let curve = Curve {
            samples: samples.collect(),
            creep: 0.0,
        };
        let noise = &self.noise;
        let lower = noise.whitening(&noise.covariance(&curve), &curve, onset_rad, &torques)?;
        Some(Observed {
            phalanx,
            values,
            angles,
            torques: DVector::from_vec(torques),
            lower,
        })
    }

    /// Derivatives of a curve by all unknowns in units of their deviations, whitened.
    pub(super) fn slopes(
        &self,
        observed: &Observed,
        deviations: &[f64; UNKNOWNS],
    ) -> Option<DMatrix<f64>> {
        let points = observed.torques.len();
        let mut slopes = DMatrix::zeros(points, UNKNOWNS);
        for unknown in (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0) {
            let beside = |steps: f64| {
                let mut values = observed.values;
                values[unknown] += steps * DIFFERENCE * deviations[unknown];
                let end = End::Top(self.top_nm());
                self.excess_nm(observed.phalanx, &values, &observed.angles, end)
            };
            let (more, less) = (beside(1.0)?, beside(-1.0)?);
            // Without a curve beside it the unknown would seem not to matter.
            if more.len().min(less.len()) < points.min(LEAD + LEAST_POINTS) {
                return None;
            }
            // The last points may lie beyond the end of one of them.
            let mut column = DVector::zeros(points);
            for (index, (more, less)) in more.iter().zip(&less).enumerate() {
                column[index] = (more - less) / (2.0 * DIFFERENCE);
            }
            slopes.set_column(unknown, &observed.lower.solve_lower_triangular(&column)?);
        }
        Some(slopes)
    }

    /// What a pin's curve shows of all unknowns in units of their deviations, whitened: differences over half of what is known of each, of
    /// the points that all these curves have.
    pub(super) fn secants(
        &self,
        observed: &Observed,
        deviations: &[f64; UNKNOWNS],
        known: &DMatrix<f64>,
    ) -> Option<DMatrix<f64>> {
        let mut points = observed.torques.len();
        let mut secants = DMatrix::zeros(points, UNKNOWNS);
        for unknown in (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0 && known[(i, i)] > 0.0) {
            let size = match unknown {
                ONSET => SECANT_ONSET,
                _ => SECANT * known[(unknown, unknown)].sqrt(),
            };
            let beside = |step: f64| {
                let mut values = observed.values;
                values[unknown] += step * size * deviations[unknown];
                self.excess_nm(observed.phalanx, &values, &observed.angles, End::Open)
            };
            let (more, less) = (beside(1.0)?, beside(-1.0)?);
            points = points.min(more.len()).min(less.len());
            for (index, (more, less)) in more.iter().zip(&less).enumerate() {
                secants[(index, unknown)] = (more - less) / (2.0 * size);
            }
        }
        let lower = observed.lower.view((0, 0), (points, points));
        lower.solve_lower_triangular(&secants.rows(0, points))
    }

    /// Fisher's information of a curve on all unknowns, in units of their deviations.
    fn information(&self, chosen: &Chosen, deviations: &[f64; UNKNOWNS]) -> Option<DMatrix<f64>> {
        let observed = self.observed(chosen.phalanx, self.means(chosen))?;
        let slopes = self.slopes(&observed, deviations)?;
        Some(slopes.tr_mul(&slopes))
    }

    /// Deviations of a contact's place, percent of the phalanx, for each level of [`Bound`](super::mean::Bound).
    pub(super) fn sigmas_pct(&self, chosen: &Chosen) -> Option<[f64; 8]> {
        let deviations = self.deviations(self.lengths_m[chosen.phalanx - 1]);
        let information = self.information(chosen, &deviations)?;
        let calibrated = self.calibrated(&deviations, Pulleys::Exact)?;
        let pulleys_off = self.calibrated(&deviations, Pulleys::Off)?;
        let mut forgotten = calibrated.clone();
        forget(&mut forgotten, JOINT, 1.0);
        let pressed = self.pressed(&deviations, Pulleys::Exact);
        let mut sheet = prior(&deviations);
        Pulleys::Exact.know(&mut sheet);
        let doubted = |known: &DMatrix<f64>, leverage: f64| {
            let mut doubted = known.clone();
            let share = leverage * f64::from(self.sheet.torque_factor) / deviations[FACTOR];
            doubted[(FACTOR, FACTOR)] += share * share;
            doubted
        };
        let [leverage, left] = self.leverage;
        let sigma_pct = |before: &DMatrix<f64>| {
            let variance = told(before, &information)?[(K, K)];
            Some(100.0 * UNIFORM * variance.max(0.0).sqrt())
        };
        Some([
            sigma_pct(&calibrated)?,
            sigma_pct(&forgotten)?,
            sigma_pct(&doubted(&calibrated, left))?,
            sigma_pct(&pulleys_off)?,
            sigma_pct(&pressed)?,
            sigma_pct(&doubted(&pressed, leverage))?,
            sigma_pct(&self.pressed(&deviations, Pulleys::Off))?,
            sigma_pct(&sheet)?,
        ])
    }

    /// Covariance of all unknowns after a free closing and a press on the stop.
    pub(super) fn pressed(&self, deviations: &[f64; UNKNOWNS], pulleys: Pulleys) -> DMatrix<f64> {
        let mut known = prior(deviations);
        pulleys.know(&mut known);
        self.press_on_stop(&mut known, deviations);
        self.close_freely(&mut known, deviations);
        known
    }

    /// The same after the guided calibration, which adds two pins.
    pub(super) fn calibrated(
        &self,
        deviations: &[f64; UNKNOWNS],
        pulleys: Pulleys,
    ) -> Option<DMatrix<f64>> {
        let mut known = self.pressed(deviations, pulleys);
        for share in PIN_SHARES {
            let pin = self.pin(share)?;
            for (unknown, variance) in [
                (K, (PIN_SIGMA_M / deviations[K]).powi(2)),
                (RADIUS, 0.0),
                (ONSET, 1.0),
                (GIVE, 0.0),
            ] {
                forget(&mut known, unknown, variance);
            }
            let observed = self.observed(pin.phalanx, self.means(&pin))?;
            let secants = self.secants(&observed, deviations, &known)?;
            known = told(&known, &secants.tr_mul(&secants))?;
        }
        // Another contact, another material.
        for unknown in [FRICTION, K, RADIUS, ONSET] {
            forget(&mut known, unknown, 1.0);
        }
        let gives = if deviations[GIVE] > 0.0 { 1.0 } else { 0.0 };
        forget(&mut known, GIVE, gives);
        Some(known)
    }
}

/// Covariance before any contact, in units of the deviations.
pub(super) fn prior(deviations: &[f64]) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_iterator(
        deviations.len(),
        deviations.iter().map(|d| if *d > 0.0 { 1.0 } else { 0.0 }),
    ))
}

/// Replaces what is known of one unknown.
pub(super) fn forget(known: &mut DMatrix<f64>, unknown: usize, variance: f64) {
    known.row_mut(unknown).fill(0.0);
    known.column_mut(unknown).fill(0.0);
    known[(unknown, unknown)] = variance;
}

/// Covariance after a curve: P (1 + I P)^-1, which bears with unknowns that are known.
pub(super) fn told(known: &DMatrix<f64>, information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let unknowns = known.nrows();
    let more = DMatrix::identity(unknowns, unknowns) + information * known;
    let told = known * more.try_inverse()?;
    Some((&told + told.transpose()) * 0.5)
}

#[cfg(test)]
mod tests {
    use palpate::scene::Scene;
    use palpate_plant::Parameters;
    use palpate_scenes::{P70, Tendon3};
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// How many curves of contacts end before they would without another phalanx.
    fn cut<S: Scene>(contacts: u64) -> usize {
        let known = Known::of::<S>(&Parameters::of(S::NAME).unwrap());
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let is_cut = |_: &u64| loop {
            let chosen = known.drawn(&mut random).unwrap();
            let values = known.means(&chosen);
            if let Some(observed) = known.observed(chosen.phalanx, values) {
                let angles = known.angles(values[ONSET]);
                let end = End::Top(known.top_nm());
                let whole = known.excess_nm(chosen.phalanx, &values, &angles, end);
                break observed.angles.len() < whole.unwrap().len();
            }
        };
        (0..contacts).filter(is_cut).count()
    }

    /// Two phalanges hold each other, three go on closing round the object.
    #[test]
    fn another_phalanx_ends_the_curves_of_a_finger_that_goes_on_closing() {
        let cut = [cut::<P70>(20), cut::<Tendon3>(20)];
        println!("{cut:?} of 20");
        assert_eq!(cut[0], 0);
        assert!((5..=15).contains(&cut[1]), "{cut:?}");
    }
}
