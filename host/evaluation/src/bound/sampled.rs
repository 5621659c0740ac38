//! The exact posterior of a first contact's place on any finger: draws a finger from what is known of it, a contact and noise, and samples
//! values of all unknowns by how likely they make the curve (`chain.rs`). Unlike Fisher's information it means something where the torque
//! hardly depends on the place. The phalanx counts as known, and so do all lengths but for a tendon's pulleys.
//!
//! Its priors of a contact are wider than the draw: contacts lie on 10 to 90 % of the phalanx, on objects of 4 to 40 mm, while it expects
//! any place and 2 to 112 mm. And it does not use where a curve ends. So it may claim more than its errors.

use nalgebra::{DMatrix, DVector};
use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_plant::Parameters;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::Serialize;

use super::chain::{Linear, Told, normals, of_open};
use super::information::{DRAWS, Observed, Pulleys};
use super::known::{
    Chosen, DETECTED_RAD, FRICTION, GIVE, K, Known, OFFSET_M, ONSET, RADII_M, RADIUS, UNIFORM,
    UNKNOWNS, is_possible,
};

/// Unknowns of a contact alone, whose priors are no normal ones.
const OF_CONTACT: [usize; 3] = [K, RADIUS, ONSET];
/// Unknowns of the object that cannot be negative.
const OF_OBJECT: [usize; 2] = [FRICTION, GIVE];

/// What the exact posterior makes of contacts on a scene's finger, with pins and without. A tendon's pulleys are off one by one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FirstPosterior {
    /// The scene.
    pub scene: &'static str,
    /// After a press on the stop and two pins.
    pub pins: Told,
    /// After the press alone.
    pub press: Told,
    /// Contacts of each.
    pub contacts: usize,
}

/// A curve with noise, and what is known beside it.
struct Asking<'a> {
    known: &'a Known,
    observed: &'a Observed,
    means: [f64; UNKNOWNS],
    deviations: [f64; UNKNOWNS],
    /// Unknowns that are not exact.
    open: Vec<usize>,
    measured: DVector<f64>,
    /// Inverse covariance of what is known beforehand, in units of the deviations, of the unknowns that are not exact.
    precision: DMatrix<f64>,
    detected_rad: f64,
}

impl Asking<'_> {
    /// Logarithm of the posterior's density, but for a constant; none where the values cannot be.
    fn density(&self, off: &DVector<f64>) -> Option<f64> {
        let mut values = self.observed.values;
        for (&unknown, off) in self.open.iter().zip(off) {
            values[unknown] += self.deviations[unknown] * off;
        }
        let phalanx = self.observed.phalanx;
        let [least, most] = RADII_M.map(|radius_m| (radius_m + OFFSET_M).ln());
        let is_within = values[K] > 0.0
            && values[K] < self.known.lengths_m[phalanx - 1]
            && values[RADIUS] > least
            && values[RADIUS] < most;
        if !is_within || !is_possible(&values, &OF_OBJECT) {
            return None;
        }
        let from_means = self.open.iter().map(|&unknown| {
            let mean = match unknown {
                ONSET => self.detected_rad,
                K | RADIUS => return 0.0,
                _ => self.means[unknown],
            };
            (values[unknown] - mean) / self.deviations[unknown]
        });
        let from_means = DVector::from_iterator(self.open.len(), from_means);
        let angles = &self.observed.angles;
        let shown = self
            .known
            .excess_nm(phalanx, &values, angles, f64::INFINITY)?;
        if shown.len() != angles.len() {
            return None;
        }
        let left = &self.measured - DVector::from_vec(shown);
        let white = self.observed.lower.solve_lower_triangular(&left)?;
        Some(-0.5 * (white.norm_squared() + from_means.dot(&(&self.precision * &from_means))))
    }
}

impl Known {
    /// Values of a finger and of a contact on it, drawn.
    fn contact(&self, known: &DMatrix<f64>, random: &mut Pcg64Mcg) -> Option<Observed> {
        let chosen = self.drawn(random)?;
        let deviations = self.deviations(self.lengths_m[chosen.phalanx - 1]);
        let mut values = self.means(&chosen);
        let tiny = DMatrix::identity(UNKNOWNS, UNKNOWNS) * 1e-12;
        let off = (known + tiny).cholesky()?.unpack() * normals(UNKNOWNS, random);
        for unknown in (0..UNKNOWNS).filter(|unknown| !OF_CONTACT.contains(unknown)) {
            values[unknown] += deviations[unknown] * off[unknown];
        }
        is_possible(&values, &OF_OBJECT).then(|| self.observed(chosen.phalanx, values))?
    }

    /// Error and deviation of the posterior's place, as shares of the phalanx.
    fn sampled(
        &self,
        observed: &Observed,
        known: &DMatrix<f64>,
        random: &mut Pcg64Mcg,
    ) -> Option<[f64; 2]> {
        let deviations = self.deviations(self.lengths_m[observed.phalanx - 1]);
        let open: Vec<usize> = (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0).collect();
        let slopes = self.slopes(observed, &deviations)?.select_columns(&open);
        let noise_white = normals(observed.torques.len(), random);
        let late_rad = DETECTED_RAD * normals(1, random)[0];
        let means = self.means(&Chosen::SOME);
        let precision = of_open(known, &open).try_inverse()?;
        let expected = DVector::from_iterator(
            open.len(),
            open.iter().map(|&unknown| {
                let off = match unknown {
                    ONSET => late_rad,
                    K | RADIUS => 0.0,
                    _ => means[unknown] - observed.values[unknown],
                };
                off / deviations[unknown]
            }),
        );
        let beside = DMatrix::zeros(open.len(), open.len());
        let linear = Linear::of([&slopes, &beside], &noise_white, (&expected, &precision))?;
        let place = open.iter().position(|&unknown| unknown == K)?;
        let asking = Asking {
            known: self,
            observed,
            means,
            deviations,
            measured: &observed.torques + &observed.lower * noise_white,
            precision,
            detected_rad: observed.values[ONSET] + late_rad,
            open,
        };
        let sampled = linear.sampled(place, |off| asking.density(off), random);
        Some(sampled.map(|off| UNIFORM * off))
    }

    /// Contacts drawn with so much known, given to the posterior.
    fn told(&self, known: &DMatrix<f64>, contacts: u64, seed: u64) -> (Told, usize) {
        let all: Vec<[f64; 2]> = (0..contacts)
            .into_par_iter()
            .filter_map(|index| {
                let mut random = Pcg64Mcg::seed_from_u64((seed << 32) + index);
                (0..DRAWS).find_map(|_| {
                    let observed = self.contact(known, &mut random)?;
                    self.sampled(&observed, known, &mut random)
                })
            })
            .collect();
        (Told::of(&all), all.len())
    }
}

/// What the exact posterior makes of first contacts on a scene's finger. `None` where the finger cannot make them.
#[must_use]
pub fn first_posterior<S: Scene>(
    parameters: &Parameters,
    contacts: u64,
    seed: u64,
) -> Option<FirstPosterior> {
    let known = Known::of::<S>(parameters);
    let deviations = known.deviations(*known.lengths_m.last()?);
    let (pins, number) = known.told(
        &known.calibrated(&deviations, Pulleys::Off)?,
        contacts,
        seed,
    );
    let (press, same) = known.told(&known.pressed(&deviations, Pulleys::Off), contacts, seed);
    (number > 0 && same > 0).then_some(FirstPosterior {
        scene: S::NAME,
        pins,
        press,
        contacts: number.min(same),
    })
}

/// A table for the manual.
#[must_use]
pub fn markdown(posteriors: &[FirstPosterior]) -> String {
    let mut out = head(
        "scene | pins: error, % | claimed, % | within 2σ, % | a press: error, % | claimed, % | within 2σ, %",
    );
    for of in posteriors {
        out.push_str(&format!("| {} ", of.scene));
        for told in [of.pins, of.press] {
            out.push_str(&format!(
                "| {:.2} | {:.2} | {:.0} ",
                told.error_pct, told.claimed_pct, told.within2_pct
            ));
        }
        out.push_str("|\n");
    }
    out
}
