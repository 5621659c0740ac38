//! Fits the compliance of an object only where the curve demands it: most objects are rigid, and on them one more unknown costs accuracy
//! (docs/MECHANICS.md#soft-objects).

use super::{Fit, Of, PLACE_AFTER};
use crate::finger::Mechanics;
use crate::numeric::{Bounded, ln, sqrt};
use crate::sensing::SeriesElement;
use crate::sensing::locator::prior::{GIVE, Scaling, UNKNOWNS};
use crate::sensing::normal::Normal;

/// Logarithm of the odds against an object that gives way: ln (8/2), because one of nine does (chosen), and its prior is half a normal
/// distribution, twice as dense. With even odds rigid objects are taken to be soft more often, and are told a little worse.
const LN_ODDS_AGAINST: f32 = 1.386;

impl<F: Mechanics, X: SeriesElement> Fit<F, X> {
    /// Releases the compliance of the object of a fit that has settled, if the curve demands it; false if not. Begins the passes again,
    /// because an object that gives way is far from the minimum of a rigid one.
    pub(super) fn release(&mut self, scaling: &Scaling) -> bool {
        if !self.is_soft() {
            return false;
        }
        self.gives = true;
        self.damping = 0.0;
        self.passes = PLACE_AFTER;
        self.advance(scaling)
    }

    /// Tells whether an object that gives way explains the curve better than the rigid one of this fit, by the evidence of both. Twice the
    /// logarithm of their ratio is `(a/sigma)^2 + 2 ln sigma`, less that of the odds: `a` is the compliance that the curve asks for,
    /// `sigma` its deviation, both in units of the prior.
    fn is_soft(&self) -> bool {
        if !X::OBJECT_GIVES || self.gives {
            return false;
        }
        self.asked().is_some_and(|[asked, sigma]| {
            let clear = asked / sigma;
            asked > 0.0 && clear * clear + 2.0 * ln(sigma) > 2.0 * LN_ODDS_AGAINST
        })
    }

    /// Logarithm of the odds against the kind of object that the fit has found.
    pub(super) fn ln_odds_against(&self) -> f32 {
        if X::OBJECT_GIVES && self.x[GIVE] > 0.0 {
            LN_ODDS_AGAINST
        } else {
            0.0
        }
    }

    /// Takes the object's compliance out of the normal equations where the fit has none, whether the curve demanded it or not: with the
    /// evidence of a fit that lacks the unknown.
    pub(super) fn rigid(&self) -> Normal<UNKNOWNS, Of<F, X>> {
        let mut normal = self.normal;
        if X::OBJECT_GIVES && self.x[GIVE] <= 0.0 {
            normal.hold(GIVE);
            normal.set_prior(GIVE, 0.0, 1.0);
        }
        normal
    }

    /// Tells the compliance that the curve asks for, in units of its prior, with its standard deviation. A fit of a rigid object has one
    /// too: a place that needs no compliance says how little there may be.
    pub(super) fn asked(&self) -> Option<[f32; 2]> {
        if !X::OBJECT_GIVES {
            return Some([0.0; 2]);
        }
        let mut normal = self.normal;
        let factor = normal.factor(0.0)?;
        let fitted = self.x[GIVE];
        let asked = if fitted > 0.0 {
            fitted
        } else {
            factor.step()[GIVE].at_least(0.0)
        };
        Some([asked, sqrt(factor.variance(GIVE))])
    }
}

#[cfg(all(test, feature = "firmware"))]
mod tests {
    use super::super::Fitted;
    use super::*;
    use crate::scene::{P70, Scene};
    use crate::sensing::curve::Point;
    use crate::sensing::locator::prior::{K, Place, Prior};
    use crate::sensing::locator::tests::{curve_of, prior_of};
    use crate::sensing::locator::{Data, Estimate, Locator, LocatorResult};
    use crate::sensing::{Cable, SoftObject};

    type Soft = SoftObject<Cable>;

    /// Deviation of the compliance in the prior, metre per newton.
    const GIVE_M_PER_N: f32 = 2e-3;
    const RADIUS_M: f32 = 0.011;
    /// Places on the last phalanx, metre.
    const PLACES_M: [f32; 5] = [0.012, 0.021, 0.035, 0.045, 0.055];

    fn expected<X: SeriesElement>() -> Prior<X> {
        Prior {
            give_m_per_n: GIVE_M_PER_N,
            ..prior_of()
        }
    }

    /// A curve of P70 on an object of a compliance.
    fn curve(k_m: f32, give_m_per_n: f32) -> Vec<Point> {
        let finger = P70::MECHANISM;
        let drivetrain = P70::drivetrain(&finger);
        let prior = expected::<Soft>();
        let values = [(K, k_m), (GIVE, give_m_per_n)];
        curve_of(&finger, &drivetrain, &prior, RADIUS_M, &values)
    }

    /// What a locator comes to on a curve, with objects that may be soft or not (`X`).
    fn located<X: SeriesElement>(
        points: &[Point],
        prior: &Prior<X>,
    ) -> Locator<<P70 as Scene>::Finger, X> {
        let finger = P70::MECHANISM;
        let drivetrain = P70::drivetrain(&finger);
        let near = finger.rest();
        let data = Data {
            points,
            origin_rad: 0.0,
            drivetrain: &drivetrain,
        };
        let mut locator = Locator::default();
        assert!(locator.begin(&finger, &data, prior, &near, true));
        while !locator.step(&finger, &data, prior, &near, ()) {}
        locator
    }

    /// The likeliest fit of a curve.
    fn fitted<X: SeriesElement>(points: &[Point], prior: &Prior<X>) -> Fitted {
        *located(points, prior).best_fit().expect("a fit")
    }

    /// What all fits of a curve tell.
    fn told<X: SeriesElement>(points: &[Point], prior: &Prior<X>) -> Estimate {
        match located(points, prior).verdict(prior) {
            LocatorResult::At(estimate) => estimate,
            other => panic!("{other:?}"),
        }
    }

    fn length_m() -> f32 {
        P70::MECHANISM.phalanx_length_m(2).expect("two phalanges")
    }

    #[test]
    fn a_rigid_object_is_fitted_as_without_the_unknown() {
        for k_m in PLACES_M {
            let points = curve(k_m, 0.0);
            let soft = fitted(&points, &expected::<Soft>());
            let rigid = fitted(&points, &expected::<Cable>());
            assert_eq!(soft.x[GIVE], 0.0, "{k_m}: {soft:?}");
            for (soft, rigid) in soft.x.iter().zip(&rigid.x) {
                assert!((soft - rigid).abs() < 1e-4, "{k_m}: {soft} {rigid}");
            }
            let off = soft.k_sigma_m / rigid.k_sigma_m - 1.0;
            assert!(off.abs() < 1e-3, "{k_m}: {off}");
            assert!((soft.ln_evidence - rigid.ln_evidence).abs() < 1e-2);
            // The compliance is told all the same: none, within its deviation.
            let [give, sigma] = soft.give;
            assert!(give < 2.0 * sigma && sigma < 0.5, "{k_m}: {give} {sigma}");
            assert_eq!(rigid.give, [0.0; 2]);
        }
    }

    #[test]
    fn an_object_that_gives_way_is_released_and_located() {
        for expected_m_per_n in [1e-3, 2e-3, 4e-3] {
            for k_m in PLACES_M {
                let points = curve(k_m, expected_m_per_n);
                let prior = expected::<Soft>();
                let best = fitted(&points, &prior);
                // At 1 N/mm some places are told as well by a rigid object.
                let released = best.x[GIVE] > 0.0;
                assert!(expected_m_per_n < 2e-3 || released, "{k_m}: {best:?}");
                let soft = told(&points, &prior);
                let [give, sigma] = soft.give_m_per_n;
                assert!(
                    (give - expected_m_per_n).abs() < 2.0 * sigma,
                    "{k_m}: {give} {sigma}"
                );
                let off_m = (soft.k_m - k_m).abs();
                assert!(off_m < 2.0 * soft.k_sigma_m, "{k_m}: {off_m} {soft:?}");
                // Who takes the softest to be rigid is misled.
                let rigid = fitted(&points, &expected::<Cable>());
                let misled_m = (length_m() * rigid.x[K] - k_m).abs();
                assert!(
                    expected_m_per_n < 4e-3 || misled_m > 2.0 * off_m,
                    "{k_m}: {misled_m} {off_m}"
                );
            }
        }
    }

    /// Pins are rigid by what the user is told, so one that gives way calibrates as a rigid one.
    #[test]
    fn a_pin_is_taken_to_be_rigid() {
        let k_m = 0.035;
        let points = curve(k_m, 2e-3);
        let prior = Prior {
            place: Place::Known {
                phalanx: 2,
                k_m,
                sigma_m: 3e-4,
                radius_m: RADIUS_M,
            },
            ..expected::<Soft>()
        };
        assert_eq!(fitted(&points, &prior).x[GIVE], 0.0);
    }
}
