//! Priors of a fit, and its unknowns.

use super::noise::Noise;
use crate::finger::Mechanics;
use crate::numeric::{Bounded, clamp, ln};
use crate::sensing::calibration::independence;
use crate::sensing::normal::Unknowns;
use crate::sensing::{Calibration, SeriesElement};
use core::fmt::{self, Debug, Formatter};
use core::marker::PhantomData;

/// Number of unknowns: those of cable, soft object and losses are the last ones, and may be [missing](Of).
pub(super) const UNKNOWNS: usize = 8;
/// Location, in lengths of the phalanx (at a known place: in deviations from it).
pub(super) const K: usize = 0;
/// Measured angle of the input link at the onset.
pub(super) const ONSET: usize = 1;
/// Coefficient of friction between phalanx and object.
pub(super) const FRICTION: usize = 2;
/// Torque factor.
pub(super) const FACTOR: usize = 3;
/// Friction or preload of each joint beyond the first.
pub(super) const JOINT: usize = 4;
/// Twist of the cable.
pub(super) const CABLE: usize = 5;
/// Growth of its stiffness with the torque.
pub(super) const BEND: usize = 6;
/// Compliance of the object, where it may be soft.
pub(super) const GIVE: usize = 7;
/// What is lost on the way to the joints ([`Mechanics::JOINT_LOSS`]), where [it is fitted](fits_loss). A number of its own would take
/// 120 bytes of RAM in the results of fits alone.
pub(super) const LOSS: usize = GIVE;

/// Whether the losses are fitted: only with transmissions that have any, and only on rigid objects, because a soft one needs the number
/// ([`LOSS`]).
pub(super) const fn fits_loss<F: Mechanics, X: SeriesElement>() -> bool {
    F::JOINT_LOSS[0] > 0.0 && !X::OBJECT_GIVES
}

/// Names the finger `F` and what is in series with it, `X`: they decide which unknowns a fit has.
pub(super) struct Of<F, X>(PhantomData<fn() -> (F, X)>);

impl<F, X> Clone for Of<F, X> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F, X> Copy for Of<F, X> {}

impl<F, X> Debug for Of<F, X> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("Of")
    }
}

impl<F: Mechanics, X: SeriesElement> Unknowns for Of<F, X> {
    const MISSING: usize = if X::OBJECT_GIVES || fits_loss::<F, X>() {
        0
    } else if X::FLEXIBLE {
        1
    } else {
        3
    };
}

/// Smallest location, as a share of the phalanx.
pub(super) const LEAST_SHARE: f32 = 0.007;
/// Bound of an unknown, in deviations from its mean.
const MOST_DEVIATIONS: f32 = 6.0;
/// Smallest torque factor, as a share of its mean.
const LEAST_FACTOR: f32 = 0.2;
/// Smallest twist of the cable, as a share of its mean.
const LEAST_CABLE: f32 = 0.1;

/// Where a contact may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Anywhere on the finger.
    Anywhere,
    /// At a known place: calibration.
    Known {
        /// Phalanx, from 2.
        phalanx: u8,
        /// Distance from the joint, metre.
        k_m: f32,
        /// Standard deviation, metre.
        sigma_m: f32,
        /// Effective contact radius, metre.
        radius_m: f32,
    },
    /// The input link stands at its closing stop, and the cable alone gives way: calibration.
    Stop,
}

/// Prior of the unknowns, the same for every hypothesis. `X` is what lies in series with the finger: with
/// [`Rigid`](crate::sensing::Rigid) there is no cable to fit, and the values of a cable are ignored.
#[derive(Clone, Copy, Debug)]
pub struct Prior<X: SeriesElement> {
    /// Location.
    pub place: Place,
    /// Half the thickness of a phalanx, metre.
    pub half_thickness_m: f32,
    /// Coefficient of friction between phalanx and object: mean and deviation.
    pub friction: [f32; 2],
    /// Friction or preload of each joint beyond the first, newton metre: mean and deviation.
    pub joint_nm: [f32; 2],
    /// Measured angle of the input link at the onset, radian: mean and deviation.
    pub onset_rad: [f32; 2],
    /// Deviation of the object's compliance, metre per newton; only of [`SoftObject`](crate::sensing::SoftObject).
    pub give_m_per_n: f32,
    /// Torque with which the input link holds the finger's weight, newton metre, and its derivative by the angle, newton metre
    /// per radian; 0 with a spring at joint 1.
    pub weight: [f32; 2],
    /// Torque with which that weight presses joint 2 on its stop, newton metre: the path has it, and `joint_nm` what is there besides.
    pub held_nm: f32,
    /// Forces over those that the scene's springs would have, where it is known.
    pub force_scale: Option<f32>,
    /// Torque with which springs hold the joints beyond the first at their stops without that weight, newton metre.
    pub preload_nm: f32,
    /// Torque factor and cable; what is known of the joints is in `joint_nm`, its correlation here.
    pub calibration: Calibration,
    /// Standard deviation of the finger's leverage along a curve, as a share.
    pub leverage_sigma: f32,
    /// Noise.
    pub noise: Noise,
    /// What lies in series.
    pub series: PhantomData<X>,
}

/// Exponent of the tails of Student's distribution with three degrees of freedom.
const TAIL: f32 = 4.0;

/// Range of a cable's compliance over the nominal one: 10 and 1.5 kN/m about 3 (docs/HARDWARE.md#drivetrain).
const CABLES: [f32; 2] = [0.3, 2.0];

impl<X: SeriesElement> Prior<X> {
    /// Prior of the joints' friction and preload at x deviations from its mean, compared with a normal one: the difference of their costs
    /// (minus twice the logarithm of the density), and the precision of the normal distribution with the same gradient at x.
    ///
    /// A scene only guesses this torque, and may be wrong by an order of magnitude. Before a pin calibrates it, the prior is therefore
    /// Student's distribution with three degrees of freedom, which costs as much as the normal one near the mean, but 9 instead of 36 at
    /// six deviations. It stays normal for transmissions whose leverage is uncertain (`UNEVEN`): that deviation covers the joints as well.
    #[inline(never)]
    pub(super) fn beside_normal<F: Mechanics>(&self, x: f32) -> [f32; 2] {
        if F::UNEVEN || self.calibration.contacts > 0 {
            return [0.0, 1.0];
        }
        let precision = TAIL / (TAIL + x * x);
        [-TAIL * ln(precision) - x * x, precision]
    }

    /// Logarithm of how much likelier the cable of a fit is than the fit takes it for. Nobody knows more of a cable than a range of
    /// its stiffness, and only what is even in the logarithm is the same for stiffness and compliance; a fit has a normal distribution
    /// as wide as that. Nothing once a press or a pin has told the cable.
    pub(super) fn ln_cable(&self, x: &[f32; UNKNOWNS]) -> f32 {
        let known = &self.calibration;
        if known.presses > 0 || known.contacts > 0 || known.cable_rad_per_nm <= 0.0 {
            return 0.0;
        }
        let [stiffest, softest] = CABLES;
        let sigma = (known.cable_sigma_rad_per_nm / known.cable_rad_per_nm).at_least(1e-3);
        // Beyond the range the normal distribution goes on.
        let over = clamp(1.0 + x[CABLE] * sigma, stiffest, softest);
        let x = (over - 1.0) / sigma;
        0.5 * x * x - ln(over)
    }
}

/// Physical values of the unknowns, each in its place.
pub(super) type Values = [f32; UNKNOWNS];

/// Converts unknowns in units of their prior into physical values: value = mean + deviation x; the means of cable and joints depend on
/// the factor, with which they are correlated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaling {
    pub(super) mean: Values,
    pub(super) deviation: Values,
    pub(super) cable_by_factor: f32,
    pub(super) joint_by_factor: f32,
    lowest: Values,
    highest: Values,
}

impl Scaling {
    /// Scaling by the prior, for a phalanx of a length.
    pub(super) fn of<F: Mechanics, X: SeriesElement>(prior: &Prior<X>, length_m: f32) -> Self {
        let (mut mean, mut deviation) = ([0.0; UNKNOWNS], [0.0; UNKNOWNS]);
        let mut lowest = [-MOST_DEVIATIONS; UNKNOWNS];
        let mut highest = [MOST_DEVIATIONS; UNKNOWNS];
        match prior.place {
            Place::Anywhere | Place::Stop => {
                deviation[K] = length_m;
                (lowest[K], highest[K]) = (LEAST_SHARE, 1.0);
            }
            Place::Known { k_m, sigma_m, .. } => (mean[K], deviation[K]) = (k_m, sigma_m),
        }
        let calibration = &prior.calibration;
        [mean[ONSET], deviation[ONSET]] = prior.onset_rad;
        [mean[FRICTION], deviation[FRICTION]] = prior.friction;
        let [joint_nm, joint_sigma_nm] = prior.joint_nm;
        mean[JOINT] = joint_nm;
        deviation[JOINT] = joint_sigma_nm * independence(calibration.joint_correlation);
        let joint_by_factor = joint_sigma_nm * calibration.joint_correlation;
        mean[FACTOR] = calibration.torque_factor;
        deviation[FACTOR] = calibration.torque_factor * calibration.torque_factor_sigma;
        let mut cable_by_factor = 0.0;
        if X::FLEXIBLE {
            mean[CABLE] = calibration.cable_rad_per_nm;
            deviation[CABLE] = calibration.cable_sigma_rad_per_nm * calibration.independence();
            cable_by_factor = calibration.cable_sigma_rad_per_nm * calibration.correlation;
            mean[BEND] = calibration.stiffening_per_nm;
            deviation[BEND] = calibration.stiffening_sigma_per_nm;
        }
        // What calibrates is rigid.
        if X::OBJECT_GIVES && matches!(prior.place, Place::Anywhere) {
            deviation[GIVE] = prior.give_m_per_n;
        }
        if fits_loss::<F, X>() {
            let sigma;
            [mean[LOSS], sigma] = F::JOINT_LOSS;
            // With pins, the torque factor takes what is lost at their places.
            if matches!(prior.place, Place::Anywhere) {
                deviation[LOSS] = sigma;
            }
        }
        // Least values, as shares of the means.
        let least = [
            (FRICTION, 0.0),
            (FACTOR, LEAST_FACTOR),
            (CABLE, LEAST_CABLE),
            (BEND, 0.0),
            (GIVE, 0.0),
        ];
        for (unknown, share) in least {
            let of = (mean.get(unknown), deviation.get(unknown));
            if let ((Some(mean), Some(deviation)), Some(lowest)) = (of, lowest.get_mut(unknown)) {
                let least = (share - 1.0) * mean / deviation.at_least(f32::MIN_POSITIVE);
                *lowest = lowest.at_least(least);
            }
        }
        Self {
            mean,
            deviation,
            cable_by_factor,
            joint_by_factor,
            lowest,
            highest,
        }
    }

    /// Physical values.
    pub(super) fn values(&self, x: &[f32; UNKNOWNS]) -> Values {
        let mut values = self.mean;
        for unknown in 0..UNKNOWNS {
            values[unknown] += self.deviation[unknown] * x[unknown];
        }
        values[CABLE] += self.cable_by_factor * x[FACTOR];
        values[JOINT] += self.joint_by_factor * x[FACTOR];
        values
    }

    /// Clamps an unknown to its physical range; true if it was outside.
    pub(super) fn hold(&self, x: &mut [f32; UNKNOWNS], unknown: usize) -> bool {
        let bounds = (self.lowest.get(unknown), self.highest.get(unknown));
        let (Some(x), (Some(lowest), Some(highest))) = (x.get_mut(unknown), bounds) else {
            return false;
        };
        let held = x.at_least(*lowest).at_most(*highest);
        core::mem::replace(x, held) != held
    }
}

/// How far a fit at a known place had to go from what is known, as a variance ratio of at least 1. What it is not to learn
/// (its place, contact friction, the joints, the cable that a press has measured, the factor once a pin has told it) should
/// move by as much as the curve determines it: 1 less its variance in units of the prior's. More says that the priors, or the
/// model, are not this finger's; one more value as large as expected keeps a few of them from saying so by chance.
/// `beside_normal` is what the prior of the joints costs beside a normal one.
pub(super) fn strain(
    x: &[f32; UNKNOWNS],
    beside_normal: f32,
    learns_factor: bool,
    variance: impl Fn(usize) -> f32,
) -> f32 {
    let (mut moved, mut expected) = (1.0 + beside_normal, 1.0);
    for (unknown, x) in x.iter().enumerate() {
        if !(learns_factor && unknown == FACTOR) {
            moved += x * x;
            expected += (1.0 - variance(unknown)).at_least(0.0);
        }
    }
    (moved / expected).at_least(1.0)
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::*;
    use crate::scene::{P70, Scene, Tendon2};
    use crate::sensing::Cable;
    use crate::sensing::tests::locator::{CALIBRATION, prior};

    #[test]
    fn a_cable_that_nobody_measured_is_even_in_the_logarithm_over_its_range() {
        let mut prior: Prior<Cable> = prior(0.8);
        prior.calibration = Calibration {
            cable_rad_per_nm: 0.8,
            cable_sigma_rad_per_nm: 0.4,
            contacts: 0,
            presses: 0,
            ..CALIBRATION
        };
        // With the density of the fit itself, of a compliance over the nominal one.
        let ln_density = |prior: &Prior<Cable>, over: f32| {
            let mut x = [0.0; UNKNOWNS];
            x[CABLE] = (over - 1.0) * 0.8 / 0.4;
            prior.ln_cable(&x) - 0.5 * x[CABLE] * x[CABLE]
        };
        let density = |over| ln_density(&prior, over);
        for over in [0.35, 0.5, 1.0, 1.9] {
            assert!((density(over) + ln(over)).abs() < 1e-5, "{over}");
        }
        // Beyond the range it falls as steeply as that of the fit.
        assert!(density(0.1) < density(0.3) - 0.5 && density(3.0) < density(2.0) - 4.0);
        prior.calibration.presses = 1;
        assert!((ln_density(&prior, 0.5) + 0.5).abs() < 1e-6);
    }

    #[test]
    fn what_holds_the_joints_has_the_tails_of_three_degrees_of_freedom_until_a_pin_tells_it() {
        type Long = <P70 as Scene>::Finger;
        type Pulleys = <Tendon2 as Scene>::Finger;
        let mut prior: Prior<Cable> = prior(0.8);
        prior.calibration.contacts = 0;
        let cost = |x: f32| x * x + prior.beside_normal::<Long>(x)[0];
        for x in [-6.0f32, -2.0, -0.3, 0.0, 0.5, 1.0, 3.0, 6.0] {
            // Student's t of variance 4/3 of the scale, so that its curvature at the mean is 1.
            let t = f64::from(x) / (4.0f64 / 3.0).sqrt();
            let exact = 4.0 * (1.0 + t * t / 3.0).ln();
            assert!((f64::from(cost(x)) - exact).abs() < 1e-3, "{x}");
            let slope = (cost(x + 0.01) - cost(x - 0.01)) / 0.02;
            let pull = 2.0 * x * prior.beside_normal::<Long>(x)[1];
            assert!((slope - pull).abs() < 2e-2, "{x}: {slope} {pull}");
        }
        assert_eq!(prior.beside_normal::<Pulleys>(3.0), [0.0, 1.0]);
        prior.calibration.contacts = 1;
        assert_eq!(prior.beside_normal::<Long>(3.0), [0.0, 1.0]);
    }
}
