//! The exact posterior of a first contact's place on any finger: draws a finger from what is known of it, a contact and noise, and samples
//! values of all unknowns by how likely they make the curve (`chain.rs`). Unlike Fisher's information it means something where the torque
//! hardly depends on the place. The phalanx counts as known, and so do all lengths but for the pulleys of tendon and
//! return cable.
//!
//! Its priors of a contact are wider than the draw: contacts lie on 10 to 90 % of the phalanx, on objects of 4 to 40 mm, while it expects
//! any place and 2 to 112 mm. And it does not use where a curve ends. So it may claim more than its errors.

use nalgebra::{DMatrix, DVector};
use palpate::scene::Scene;
use palpate::sensing::Calibration;
use palpate_document::table::head;
use palpate_plant::Parameters;
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::chain::{Linear, Told, of_open};
use super::each::{DRAWS, each};
use super::felt::{Belief, Felt, OF_OBJECT};
use super::information::End;
use super::known::{K, Known, OFFSET_M, ONSET, RADII_M, RADIUS, UNIFORM, UNKNOWNS, is_possible};
use super::ours::Ours;

/// What the exact posterior makes of contacts on a scene's finger, with pins and without. Pulleys of tendon and return cable are
/// off one by one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FirstPosterior {
    /// The scene.
    pub scene: &'static str,
    /// After a press on the stop and two pins.
    pub pins: Both,
    /// After the press alone.
    pub press: Both,
    /// Contacts of each.
    pub contacts: usize,
}

/// What posterior and library make of the same curves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Both {
    /// The posterior.
    pub exact: Told,
    /// The library, of the contacts that it locates on their phalanx.
    pub ours: Told,
    /// Number of these.
    pub located: usize,
}

/// Error and deviation of one contact's place, shares of the phalanx.
#[derive(Clone, Copy, Debug)]
struct Judged {
    exact: [f64; 2],
    ours: Option<[f64; 2]>,
}

impl Both {
    fn of(all: impl Iterator<Item = Judged> + Clone) -> Self {
        let exact: Vec<_> = all.clone().map(|judged| judged.exact).collect();
        let ours: Vec<_> = all.filter_map(|judged| judged.ours).collect();
        Self {
            exact: Told::of(&exact),
            ours: Told::of(&ours),
            located: ours.len(),
        }
    }
}

/// A curve with noise, and what is known beside it.
struct Asking<'a> {
    known: &'a Known,
    felt: &'a Felt,
    means: [f64; UNKNOWNS],
    deviations: [f64; UNKNOWNS],
    /// Unknowns that are not exact.
    open: Vec<usize>,
    /// Inverse covariance of what is known beforehand, in units of the deviations, of the unknowns that are not exact.
    precision: DMatrix<f64>,
}

impl Asking<'_> {
    /// Logarithm of the posterior's density, but for a constant; none where the values cannot be.
    fn density(&self, off: &DVector<f64>) -> Option<f64> {
        let observed = &self.felt.observed;
        let mut values = observed.values;
        for (&unknown, off) in self.open.iter().zip(off) {
            values[unknown] += self.deviations[unknown] * off;
        }
        let phalanx = observed.phalanx;
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
                ONSET => self.felt.detected_rad,
                K | RADIUS => return 0.0,
                _ => self.means[unknown],
            };
            (values[unknown] - mean) / self.deviations[unknown]
        });
        let from_means = DVector::from_iterator(self.open.len(), from_means);
        let angles = &observed.angles;
        let shown = self.known.excess_nm(phalanx, &values, angles, End::Open)?;
        if shown.len() != angles.len() {
            return None;
        }
        let left = &self.felt.measured - DVector::from_vec(shown);
        let white = observed.lower.solve_lower_triangular(&left)?;
        Some(-0.5 * (white.norm_squared() + from_means.dot(&(&self.precision * &from_means))))
    }
}

impl Known {
    /// Error and deviation of the posterior's place, as shares of the phalanx.
    fn sampled(&self, felt: &Felt, belief: &Belief, random: &mut Pcg64Mcg) -> Option<[f64; 2]> {
        let observed = &felt.observed;
        let deviations = self.deviations(self.lengths_m[observed.phalanx - 1]);
        let open: Vec<usize> = (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0).collect();
        let slopes = self.slopes(observed, &deviations)?.select_columns(&open);
        let mut means = observed.values;
        for (unknown, mean) in means.iter_mut().enumerate() {
            *mean += deviations[unknown] * belief.off[unknown];
        }
        let precision = of_open(&belief.covariance, &open).try_inverse()?;
        let expected = DVector::from_iterator(
            open.len(),
            open.iter().map(|&unknown| match unknown {
                ONSET => (felt.detected_rad - observed.values[ONSET]) / deviations[ONSET],
                K | RADIUS => 0.0,
                _ => belief.off[unknown],
            }),
        );
        let beside = DMatrix::zeros(open.len(), open.len());
        let linear = Linear::of([&slopes, &beside], &felt.white, (&expected, &precision))?;
        let place = open.iter().position(|&unknown| unknown == K)?;
        let asking = Asking {
            known: self,
            felt,
            means,
            deviations,
            precision,
            open,
        };
        let sampled = linear.sampled_from_afar(place, |off| asking.density(off), random);
        Some(sampled.map(|off| UNIFORM * off))
    }

    /// A finger with a contact, drawn and judged by both with pins and without.
    fn judged<S: Scene>(&self, random: &mut Pcg64Mcg) -> Option<[Judged; 2]> {
        let finger = self.values(random)?;
        let felt = self.touched(&finger, random)?;
        let pins = self.pins(&finger, random)?;
        let ours = Ours::<S>::of(self);
        let pressed = ours.pressed();
        let mut judged = |belief: &Belief, calibration: &Calibration| {
            Some(Judged {
                exact: self.sampled(&felt, belief, random)?,
                ours: ours.located(&felt, calibration),
            })
        };
        Some([
            judged(&self.taught(&finger, &pins)?, &ours.taught(&pressed, &pins))?,
            judged(&self.believed(&finger), &pressed)?,
        ])
    }
}

/// What the exact posterior makes of first contacts on a scene's finger, and the library of the same curves. `None` where the finger
/// cannot make them.
#[must_use]
pub fn first_posterior<S: Scene>(
    parameters: &Parameters,
    contacts: u64,
    seed: u64,
) -> Option<FirstPosterior> {
    let known = Known::of::<S>(parameters);
    let all: Vec<[Judged; 2]> = each(contacts, seed, DRAWS, |random| known.judged::<S>(random));
    let [pins, press] = [0, 1].map(|row| Both::of(all.iter().map(|judged| judged[row])));
    (!all.is_empty()).then_some(FirstPosterior {
        scene: S::NAME,
        pins,
        press,
        contacts: all.len(),
    })
}

/// A table for docs/BOUNDS.md.
#[must_use]
pub fn markdown(posteriors: &[FirstPosterior]) -> String {
    let mut out = head(
        "scene | pins: error, % | claimed, % | within 2σ | ours: located | error, % | claimed, % | within 2σ \
         | a press: error, % | claimed, % | within 2σ | ours: located | error, % | claimed, % | within 2σ",
    );
    // A handful of contacts: of so few a share would say more than there is.
    let told = |told: &Told, number: usize| {
        format!(
            "| {:.1} | {:.1} | {:.0}/{number} ",
            told.error_pct,
            told.claimed_pct,
            told.within2_pct * number as f64 / 100.0
        )
    };
    for of in posteriors {
        out.push_str(&format!("| {} ", of.scene));
        for both in [of.pins, of.press] {
            let [exact, ours] = [(both.exact, of.contacts), (both.ours, both.located)]
                .map(|(of, number)| told(&of, number));
            out.push_str(&format!("{exact}| {}/{} {ours}", both.located, of.contacts));
        }
        out.push_str("|\n");
    }
    out
}
