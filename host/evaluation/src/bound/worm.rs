//! What the data tell of an error of the worm's angle, once a turn, that nobody states (docs/BOUNDS.md#an-error-of-the-worm).
//!
//! Its two waves are linear unknowns that all curves share, by their angles. With everything else linear about the truth, the evidence for
//! an amplitude over none, the error of whoever takes it for none, and that of whoever knows how large it is follow in closed form.

mod joined;

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use palpate::scene::Scene;
use palpate_document::table::head;
use palpate_plant::Parameters;
use palpate_simulation::places::PIN_SHARES;
use serde::Serialize;

use super::each::{DRAWS, each};
use super::information::{MEAN_SHARE, PIN_SIGMA_M, prior};
use super::known::{
    BEND, CABLE, Chosen, FRICTION, GIVE, K, Known, ONSET, RADIUS, TURNS, UNIFORM, UNKNOWNS,
};
use crate::reference::Curve;
use joined::{Joined, biased};

/// Amplitudes, radian of the wheel.
const AMPLITUDES_RAD: [f64; 5] = [0.5e-3, 1e-3, 1.5e-3, 2e-3, 3e-3];

/// What an error of the worm does to places, and how well it shows; means over contacts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Worm {
    /// Amplitude of the error, milliradian.
    pub amplitude_mrad: f64,
    /// Evidence for it over none that a press on the stop shows: expected logarithm of the ratio of the likelihoods.
    pub press_nats: f64,
    /// The same of two pins and a contact.
    pub contact_nats: f64,
    /// Mean error without sign of whoever takes it for none, percent of the phalanx.
    pub unstated_pct: f64,
    /// What that one claims.
    pub claimed_pct: f64,
    /// Share of its errors within two of its deviations, percent.
    pub within2_pct: f64,
    /// Mean error without sign of whoever doubts pins by 1.5 mrad and forgets what they have shown of the waves, and the share of
    /// its errors within two of its deviations, percent.
    pub doubted_pct: [f64; 2],
    /// The same of whoever takes what pins have shown of the waves off the contact, as the firmware does.
    pub kept_pct: [f64; 2],
    /// Mean error without sign of whoever knows how large it is, as the deviation of both waves, and finds them.
    pub stated_pct: f64,
}

/// A curve, whitened: derivatives by the unknowns in units of their deviations, and by the two waves of an error of 1 rad.
struct Part {
    slopes: DMatrix<f64>,
    waves: DMatrix<f64>,
}

impl Part {
    /// Information of the waves, of an error of 1 rad, with all else unknown.
    fn shown(&self) -> Option<DMatrix<f64>> {
        let Self { slopes, waves } = self;
        let unknowns = slopes.ncols();
        let precision = slopes.tr_mul(slopes) + DMatrix::identity(unknowns, unknowns);
        let across = slopes.tr_mul(waves);
        Some(waves.tr_mul(waves) - across.tr_mul(&(precision.try_inverse()? * &across)))
    }

    /// Expected logarithm of the likelihood with an error of this amplitude over that without, where it is there.
    fn nats(&self, amplitude_rad: f64) -> Option<f64> {
        // Half of the amplitude's square is the variance of a wave of unknown phase.
        let shown = self.shown()? * (0.5 * amplitude_rad * amplitude_rad);
        let ln_determinant = (&shown + DMatrix::identity(2, 2)).determinant().ln();
        Some(0.5 * (shown.trace() - ln_determinant))
    }
}

impl Known {
    /// Waves of an error of 1 rad at measured angles where the torque changes so much with the angle, newton metre per radian.
    fn waves(&self, angles: &[f64], nm_per_rad: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(angles.len(), 2, |point, wave| {
            let turns = self.worm_turns(angles[point]);
            let [cosine, sine] = [(TAU * turns).cos(), (TAU * turns).sin()];
            nm_per_rad[point] * if wave == 0 { cosine } else { sine }
        })
    }

    fn part(&self, chosen: &Chosen, deviations: &[f64; UNKNOWNS]) -> Option<Part> {
        let observed = self.observed(chosen.phalanx, self.means(chosen))?;
        let slopes = self.slopes(&observed, deviations)?;
        // An onset that is later takes off what an angle that is larger adds.
        let nm_per_rad = &observed.lower * slopes.column(ONSET) / -deviations[ONSET];
        let waves = self.waves(&observed.angles, &nm_per_rad);
        Some(Part {
            waves: observed.lower.solve_lower_triangular(&waves)?,
            slopes,
        })
    }

    /// A press on the closing stop, up to the torque of a curve: of the cable alone, whose stiffness and bend are not known, nor where it
    /// began.
    fn press_part(&self, deviations: &[f64; UNKNOWNS]) -> Option<Part> {
        let means = self.means(&Chosen::SOME);
        let (cable, bend) = (means[CABLE], means[BEND]);
        let middle_nm = 0.5 * self.top_nm();
        let bent = |nm: f64| nm * (0.5 * nm - middle_nm);
        let twist_rad = |nm: f64| cable * (nm - bend * bent(nm));
        // Torques whose twists lie as far apart as the points of a curve.
        let width_rad = TURNS * self.turn_rad;
        let mut torques = Vec::new();
        let mut nm = 0.0;
        while nm < self.top_nm() {
            nm += width_rad / cable * (1.0 - bend * (nm - middle_nm)).recip();
            torques.push(nm);
        }
        let angles: Vec<f64> = torques
            .iter()
            .map(|&nm| self.closed_rad + twist_rad(nm))
            .collect();
        let samples = angles.iter().zip(&torques).map(|(&angle_rad, &nm)| {
            let turns = (angle_rad - self.closed_rad) / self.turn_rad;
            self.sample(angle_rad, turns, nm)
        });
        let curve = Curve {
            samples: samples.collect(),
            creep: 0.0,
        };
        let noise = &self.noise;
        let lower =
            noise.whitening(&noise.covariance(&curve), &curve, self.closed_rad, &torques)?;
        let nm_per_rad = DVector::from_iterator(
            torques.len(),
            (torques.iter()).map(|nm| 1.0 / (cable * (1.0 - bend * (nm - middle_nm)))),
        );
        // Derivatives of the angle at a torque, by cable, bend and onset.
        let slopes = DMatrix::from_fn(torques.len(), 3, |point, unknown| {
            let nm = torques[point];
            let rad = match unknown {
                0 => twist_rad(nm) / cable * deviations[CABLE],
                1 => -cable * bent(nm) * deviations[BEND],
                _ => deviations[ONSET],
            };
            -nm_per_rad[point] * rad
        });
        let waves = self.waves(&angles, &nm_per_rad);
        Some(Part {
            slopes: lower.solve_lower_triangular(&slopes)?,
            waves: lower.solve_lower_triangular(&waves)?,
        })
    }

    /// Two pins and a contact of a finger that has been pressed on its stop.
    fn joined(&self, contact: &Chosen) -> Option<Joined> {
        let deviations = self.deviations(self.lengths_m[contact.phalanx - 1]);
        let mut pressed = prior(&deviations);
        self.press_on_stop(&mut pressed, &deviations);
        // The contact is the last curve.
        let pins = PIN_SHARES.len();
        let mut curves = Vec::new();
        for share in PIN_SHARES {
            curves.push(self.part(&self.pin(share)?, &deviations)?);
        }
        curves.push(self.part(contact, &deviations)?);
        // The first curve with the same value of an unknown: all share the finger's, and pins are of one material.
        let first = |unknown: usize, curve: usize| match unknown {
            K | RADIUS | ONSET | GIVE => curve,
            FRICTION if curve == pins => curve,
            _ => 0,
        };
        let sigma = |unknown: usize, curve: usize| match unknown {
            RADIUS | GIVE if curve < pins => 0.0,
            K if curve < pins => PIN_SIGMA_M / deviations[K],
            _ => pressed[(unknown, unknown)].sqrt(),
        };
        let columns: Vec<(usize, usize)> = (0..UNKNOWNS)
            .flat_map(|unknown| (0..=pins).map(move |curve| (unknown, curve)))
            .filter(|&(unknown, curve)| {
                first(unknown, curve) == curve && sigma(unknown, curve) > 0.0
            })
            .collect();
        let mut points = 0;
        let ends = curves.iter().map(|part| {
            points += part.slopes.nrows();
            points
        });
        let ends: Vec<usize> = ends.collect();
        let mut slopes = DMatrix::zeros(points, columns.len());
        let mut waves = DMatrix::zeros(points, 2);
        let mut from = 0;
        for (curve, part) in curves.iter().enumerate() {
            let rows = part.slopes.nrows();
            waves.rows_mut(from, rows).copy_from(&part.waves);
            for (column, &(unknown, of)) in columns.iter().enumerate() {
                if first(unknown, curve) == of {
                    let slope = part.slopes.column(unknown) * sigma(unknown, of);
                    slopes.view_mut((from, column), (rows, 1)).copy_from(&slope);
                }
            }
            from += rows;
        }
        Some(Joined {
            part: Part { slopes, waves },
            ends,
            shared: (columns
                .iter()
                .map(|&(unknown, of)| of == 0 && first(unknown, pins) == 0))
            .collect(),
            place: columns.iter().position(|&column| column == (K, pins))?,
        })
    }
}

/// What errors of the worm do to a scene's finger, whose weight is not stated. `None` where the finger cannot make the contacts.
#[must_use]
pub fn worms<S: Scene>(parameters: &Parameters, contacts: u64, seed: u64) -> Option<Vec<Worm>> {
    let known = Known::of::<S>(parameters);
    let all = each(contacts, seed, DRAWS, |random| {
        let joined = known.joined(&known.drawn(random)?)?;
        let judged = [joined.judged(false)?, joined.judged(true)?];
        Some((joined, judged))
    });
    if all.is_empty() {
        return None;
    }
    let press = known.press_part(&known.deviations(known.lengths_m[0]))?;
    let number = all.len() as f64;
    let of = |amplitude_rad: f64| {
        let mut worm = Worm {
            amplitude_mrad: 1e3 * amplitude_rad,
            press_nats: press.nats(amplitude_rad)?,
            contact_nats: 0.0,
            unstated_pct: 0.0,
            claimed_pct: 0.0,
            within2_pct: 0.0,
            doubted_pct: [0.0; 2],
            kept_pct: [0.0; 2],
            stated_pct: 0.0,
        };
        for (one, [doubted, kept]) in &all {
            let [claimed, moved, stated] = one.variances(amplitude_rad)?;
            // The variance of a wave is half of its amplitude's square.
            let [error, within2] = biased((2.0 * moved / claimed).sqrt(), 2.0);
            let sigma_pct = |variance: f64| 100.0 * UNIFORM * variance.sqrt() / number;
            worm.contact_nats += one.part.nats(amplitude_rad)? / number;
            worm.unstated_pct += error * sigma_pct(claimed);
            worm.claimed_pct += MEAN_SHARE * sigma_pct(claimed);
            worm.within2_pct += 100.0 * within2 / number;
            for (sum, judged) in [(&mut worm.doubted_pct, doubted), (&mut worm.kept_pct, kept)] {
                let [error, within2] = judged.errors(amplitude_rad);
                sum[0] += 100.0 * UNIFORM * error / number;
                sum[1] += 100.0 * within2 / number;
            }
            worm.stated_pct += MEAN_SHARE * sigma_pct(stated);
        }
        Some(worm)
    };
    AMPLITUDES_RAD.into_iter().map(of).collect()
}

/// A table for docs/BOUNDS.md.
#[must_use]
pub fn markdown(worms: &[Worm]) -> String {
    let mut out = head(
        "error, mrad | a press shows, nats | pins and a contact show, nats | taken for none: error, % | claimed, % | within 2σ, % \
         | pins doubted: error, %; within 2σ, % | and waves kept: error, %; within 2σ, % | amplitude known: error, %",
    );
    for worm in worms {
        out.push_str(&format!(
            "| {:.1} | {:.2} | {:.2} | {:.2} | {:.2} | {:.0} | {:.2}; {:.0} | {:.2}; {:.0} | {:.2} |\n",
            worm.amplitude_mrad,
            worm.press_nats,
            worm.contact_nats,
            worm.unstated_pct,
            worm.claimed_pct,
            worm.within2_pct,
            worm.doubted_pct[0],
            worm.doubted_pct[1],
            worm.kept_pct[0],
            worm.kept_pct[1],
            worm.stated_pct,
        ));
    }
    out
}
