//! Fisher's information of a second contact's place, and what is known before.

use nalgebra::DMatrix;
use palpate::scene::Scene;
use palpate_plant::Parameters;
use palpate_simulation::places::PIN_SHARES;
use rand_pcg::Pcg64Mcg;

use super::grasp::{
    Asked, BEND, CABLE, CORNER, FACTOR, FRICTION, Grasp, JOINT, K, LEVERS, LOSS, ONSET, RADIUS,
    RADIUS_THERE, SECOND, Shown, UNKNOWNS, Values,
};
use crate::bound::Objects;
use crate::bound::chain::normals;
use crate::bound::drawn::REFERENCE_NOISE;
use crate::bound::each::DRAWS;
use crate::bound::information::{DIFFERENCE, PIN_SIGMA_M, forget, prior, told};
use crate::bound::known::{Known, UNIFORM, is_possible};
use crate::reference::{Curve, Noise};

/// Friction that free motion shows at the input link, newton metre (docs/SENSING.md#friction-wanders), of which a share wanders.
const FRICTION_NM: f64 = 0.055;
/// Wave of the efficiency over a turn of the worm, as a share of the ripple of a world's worm: 1.2 % for 2 %.
const WAVE_SHARE: f64 = 0.6;
/// Deviation of the corner's angle before any is seen, radian, and after a search, in turns of the motor.
const CORNER_RAD: f64 = 0.3;
const CORNER_TURNS: f64 = 0.7;
/// Deviation of two places' distances from the joint between them, and of the radii that follow, as a share: as the firmware has it.
pub(super) const ROUND: f64 = 0.15;
/// The same of a cylinder.
const CYLINDER: f64 = 0.01;
/// Unknowns that a finger has before any contact; they come first.
pub(super) const SHARED: usize = FRICTION + 1;

/// How much may be known, as [`SecondBound`](super::SecondBound) has it.
pub(super) const LEVELS: usize = 9;

/// Fisher's information of a grasp: on all unknowns in units of their deviations.
struct Information {
    whole: DMatrix<f64>,
    before: DMatrix<f64>,
    after: DMatrix<f64>,
    /// What the shape tells, were its deviation 1.
    shape: DMatrix<f64>,
}

/// Noise of a world's curve.
pub(super) fn noise(parameters: &Parameters) -> Noise {
    Noise {
        wander_nm: FRICTION_NM * parameters.friction.wander_share,
        wander_s: parameters.friction.wander_time_s,
        wave: WAVE_SHARE * parameters.worm.friction_ripple,
        ..REFERENCE_NOISE
    }
}

impl Asked {
    pub(super) fn of<S: Scene>(parameters: &Parameters) -> Self {
        // The figures of second contacts are of fingers without weight.
        let mut known = Known::of::<S>(parameters);
        known.opened.weight = None;
        let settings = &known.settings;
        let friction = (parameters.contact.stated()).map_or(settings.contact_friction, |mean| {
            settings.rubbed_with(mean as f32)
        });
        Self {
            friction: friction.map(f64::from),
            known,
        }
    }

    /// Deviations of all unknowns by the data sheets, with a first and a second contact on these phalanges.
    pub(super) fn deviations(&self, phalanges: [Option<usize>; 2]) -> Values {
        let (settings, sheet) = (&self.known.settings, &self.known.sheet);
        let length_m = |phalanx: Option<usize>| {
            phalanx.map_or(0.0, |phalanx| self.known.lengths_m[phalanx - 1])
        };
        let mut deviations = [0.0; UNKNOWNS];
        deviations[FACTOR] = f64::from(sheet.torque_factor * sheet.torque_factor_sigma);
        deviations[CABLE] = sheet.cable_sigma_rad_per_nm.into();
        deviations[BEND] = sheet.stiffening_sigma_per_nm.into();
        deviations[JOINT] = settings.joint_friction_nm[1].into();
        [_, deviations[LOSS]] = self.known.joint_loss;
        for lever in LEVERS {
            deviations[lever] = settings.leverage_sigma.into();
        }
        deviations[FRICTION] = self.friction[1];
        deviations[K] = UNIFORM * length_m(phalanges[0]);
        deviations[RADIUS] = Objects::Usual.sigma();
        deviations[ONSET] = 0.03;
        if phalanges[1].is_some() {
            deviations[SECOND] = UNIFORM * length_m(phalanges[1]);
            deviations[CORNER] = CORNER_RAD;
            deviations[RADIUS_THERE] = Objects::Usual.sigma();
        }
        deviations
    }

    /// Derivatives of the curve and of the shape by all unknowns in units of their deviations.
    pub(super) fn slopes(
        &self,
        grasp: &Grasp,
        shown: &Shown,
        deviations: &Values,
    ) -> Option<[DMatrix<f64>; 2]> {
        let mut slopes = DMatrix::zeros(shown.excess_nm.len(), UNKNOWNS);
        let mut shape = DMatrix::zeros(3, UNKNOWNS);
        for unknown in (0..UNKNOWNS).filter(|&i| deviations[i] > 0.0) {
            let beside = |steps: f64| {
                let mut values = grasp.values;
                values[unknown] += steps * DIFFERENCE * deviations[unknown];
                self.shown(grasp, &values)
            };
            let (more, less) = (beside(1.0)?, beside(-1.0)?);
            let pairs = more.excess_nm.iter().zip(&less.excess_nm);
            // The last points may lie beyond the end of one of them.
            for (index, (more, less)) in pairs.enumerate().take(shown.excess_nm.len()) {
                slopes[(index, unknown)] = (more - less) / (2.0 * DIFFERENCE);
            }
            if let (Some(more), Some(less)) = (more.shape, less.shape) {
                for index in 0..3 {
                    shape[(index, unknown)] = (more[index] - less[index]) / (2.0 * DIFFERENCE);
                }
            }
        }
        Some([slopes, shape])
    }

    /// Cholesky factor, lower triangle, of the noise's covariance at the points from one on to before another.
    pub(super) fn whitening(
        &self,
        grasp: &Grasp,
        shown: &Shown,
        noise: &Noise,
        [from, to]: [usize; 2],
    ) -> Option<DMatrix<f64>> {
        let known = &self.known;
        let torques = shown.excess_nm.get(from..to)?;
        let angles = grasp.angles.get(from..to)?;
        let samples = angles.iter().zip(torques).map(|(&angle_rad, &excess_nm)| {
            let turns = (angle_rad - grasp.angles[0]) / known.turn_rad;
            known.sample(angle_rad, turns, excess_nm)
        });
        let curve = Curve {
            samples: samples.collect(),
            creep: 0.0,
        };
        let covariance = noise.covariance(&curve);
        noise.whitening(&covariance, &curve, grasp.values[ONSET], torques)
    }

    fn information(
        &self,
        grasp: &Grasp,
        deviations: &Values,
        noise: &Noise,
    ) -> Option<Information> {
        let shown = self.shown(grasp, &grasp.values)?;
        let [slopes, shape] = self.slopes(grasp, &shown, deviations)?;
        let points = shown.excess_nm.len();
        let corner = grasp.before.min(points);
        let of = |range: [usize; 2]| {
            let lower = self.whitening(grasp, &shown, noise, range)?;
            let slopes = slopes.rows(range[0], range[1] - range[0]).clone_owned();
            let white = lower.solve_lower_triangular(&slopes)?;
            Some(white.tr_mul(&white))
        };
        Some(Information {
            whole: of([0, points])?,
            before: of([0, corner])?,
            after: if corner < points {
                of([corner, points])?
            } else {
                DMatrix::zeros(UNKNOWNS, UNKNOWNS)
            },
            shape: shape.tr_mul(&shape),
        })
    }

    /// Covariance of all unknowns after a press on the stop and two pins, as the firmware keeps it: at the pins losses and levers count
    /// as what is expected, and the torque factor as what makes up for them; elsewhere they are as unknown as before.
    pub(super) fn calibrated(&self, noise: &Noise) -> Option<DMatrix<f64>> {
        let pins = PIN_SHARES.map(|share| self.pin(share));
        let deviations = self.deviations([Some(self.known.lengths_m.len()), None]);
        let mut covariance = prior(&deviations);
        self.known.press_on_stop(&mut covariance, &deviations);
        for unknown in [LOSS, LEVERS[0], LEVERS[1]] {
            forget(&mut covariance, unknown, 0.0);
        }
        for pin in pins {
            for (unknown, variance) in [
                (K, (PIN_SIGMA_M / deviations[K]).powi(2)),
                (RADIUS, 0.0),
                (ONSET, 1.0),
            ] {
                forget(&mut covariance, unknown, variance);
            }
            let information = self.information(&pin?, &deviations, noise)?;
            covariance = told(&covariance, &information.whole)?;
        }
        for unknown in [FRICTION, K, RADIUS, ONSET, SECOND, CORNER, RADIUS_THERE] {
            forget(&mut covariance, unknown, 1.0);
        }
        let is_known = |unknown: usize| deviations[unknown] <= 0.0;
        for unknown in [LOSS, LEVERS[0], LEVERS[1]] {
            forget(
                &mut covariance,
                unknown,
                if is_known(unknown) { 0.0 } else { 1.0 },
            );
        }
        Some(covariance)
    }

    /// Values of a finger and of what it touches, drawn from what is known; those of a contact are 0.
    pub(super) fn finger(&self, known: &DMatrix<f64>, random: &mut Pcg64Mcg) -> Option<Values> {
        let (means, deviations) = (self.means(), self.deviations([None; 2]));
        let tiny = DMatrix::identity(SHARED, SHARED) * 1e-12;
        let lower = (known.view((0, 0), (SHARED, SHARED)) + tiny)
            .cholesky()?
            .unpack();
        (0..DRAWS).find_map(|_| {
            let off = &lower * normals(SHARED, random);
            let mut values = means;
            for unknown in 0..SHARED {
                values[unknown] += deviations[unknown] * off[unknown];
            }
            is_possible(&values, &[FRICTION]).then_some(values)
        })
    }

    /// Deviations of a second contact's place, shares of the phalanx, in the order of
    /// [`SecondBound`](super::SecondBound).
    pub(super) fn sigmas(
        &self,
        grasp: &Grasp,
        known: &DMatrix<f64>,
        noise: &Noise,
    ) -> Option<[f64; LEVELS]> {
        let deviations = self.deviations(grasp.phalanges);
        let Information {
            whole,
            before,
            after,
            shape,
        } = self.information(grasp, &deviations, noise)?;
        let round = &shape / (ROUND * ROUND);
        let sigma = |known: &DMatrix<f64>, information: &DMatrix<f64>| {
            let variance = told(known, information)?[(SECOND, SECOND)];
            Some(UNIFORM * variance.max(0.0).sqrt())
        };
        // What the curve before told of the first contact, each by itself.
        let first = told(known, &before)?;
        let mut later = known.clone();
        for unknown in [K, RADIUS, ONSET] {
            forget(&mut later, unknown, first[(unknown, unknown)]);
        }
        let corner = CORNER_TURNS * self.known.turn_rad / CORNER_RAD;
        forget(&mut later, CORNER, corner * corner);
        let exactly = |unknowns: &[usize]| {
            let mut known = known.clone();
            for &unknown in unknowns {
                forget(&mut known, unknown, 0.0);
            }
            known
        };
        let all = &whole + &round;
        let cylinder = &whole + &shape / (CYLINDER * CYLINDER);
        let finger: Vec<usize> = (0..SHARED).collect();
        Some([
            sigma(known, &whole)?,
            sigma(known, &all)?,
            sigma(&later, &after)?,
            sigma(&later, &(&after + &round))?,
            sigma(&exactly(&[FRICTION]), &all)?,
            sigma(&exactly(&[LOSS, LEVERS[0], LEVERS[1]]), &all)?,
            sigma(known, &cylinder)?,
            sigma(&exactly(&finger), &cylinder)?,
            sigma(&later, &round)?,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_plant::World;
    use palpate_scenes::Tendon3;
    use rand::SeedableRng;

    /// A finger, what is known of it, its noise, and a grasp.
    fn grasped() -> (Asked, DMatrix<f64>, Noise, Grasp) {
        let parameters = World::named("workshop").unwrap().of("tendon3").unwrap();
        let asked = Asked::of::<Tendon3>(&parameters);
        let noise = noise(&parameters);
        let known = asked.calibrated(&noise).unwrap();
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let grasp = (0..1000).find_map(|_| {
            let finger = asked.finger(&known, &mut random)?;
            let grasp = asked.drawn(finger, &mut random)?;
            (grasp.phalanges == [Some(2), Some(3)]).then_some(grasp)
        });
        (asked, known, noise, grasp.unwrap())
    }

    #[test]
    fn only_what_lies_after_the_second_contact_tells_its_place() {
        let (asked, _, noise, grasp) = grasped();
        let deviations = asked.deviations(grasp.phalanges);
        let Information {
            whole,
            before,
            after,
            ..
        } = asked.information(&grasp, &deviations, &noise).unwrap();
        for unknown in [SECOND, CORNER, RADIUS_THERE] {
            assert_eq!(before[(unknown, unknown)], 0.0, "{unknown}");
        }
        assert!(before[(K, K)] > 1.0, "{before}");
        assert!(after[(SECOND, SECOND)] > 1.0, "{after}");
        // Noise that is common to both parts shows in the part before.
        assert!(whole[(SECOND, SECOND)] >= after[(SECOND, SECOND)]);
    }

    #[test]
    fn a_known_place_is_told_exactly_and_pins_tell_the_torque() {
        let (asked, mut known, noise, grasp) = grasped();
        assert!(known[(FACTOR, FACTOR)] < 0.3, "{known}");
        let sigmas = asked.sigmas(&grasp, &known, &noise).unwrap();
        assert!(sigmas.iter().all(|sigma| *sigma > 0.0 && *sigma < UNIFORM));
        forget(&mut known, SECOND, 0.0);
        assert_eq!(asked.sigmas(&grasp, &known, &noise), Some([0.0; LEVELS]));
    }

    /// A curve of the values themselves is what the grasp was drawn as: the cylinder touches both phalanges.
    #[test]
    fn a_drawn_object_is_a_cylinder() {
        let (asked, _, _, grasp) = grasped();
        let shown = asked.shown(&grasp, &grasp.values).unwrap();
        assert_eq!(shown.excess_nm.len(), grasp.angles.len());
        assert!(shown.stays);
        let shape = shown.shape.unwrap();
        assert!(shape.iter().all(|x| x.abs() < 0.01), "{shape:?}");
    }
}
