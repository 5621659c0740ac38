//! The order in which radii are fitted.

use super::*;
use crate::scene::Tendon3;
use crate::sensing::locator::fit::Fitted;
use crate::sensing::locator::radii::{BACK, ORDER};

type Pulleys = <Tendon3 as Scene>::Finger;

const LENGTH_M: f32 = 0.05;

/// A locator whose only hypothesis has fits with these logarithms of their evidence, one a radius; an infinite one stands for none.
fn fitted(evidence: [f32; 6]) -> Locator<Pulleys, Cable> {
    let mut one = track(3, LENGTH_M, [0.3, 0.02], 0.0);
    let fit = one.fits[0].expect("a fit");
    for (own, ln_evidence) in one.fits.iter_mut().zip(evidence) {
        let mut new = fit;
        new.ln_evidence = ln_evidence;
        *own = ln_evidence.is_finite().then_some(new);
    }
    let mut locator = Locator {
        number: 30,
        order: BACK - 1,
        ..Locator::default()
    };
    locator.tracks.push(one).expect("room");
    locator
}

/// The radii that are fitted again on the way back, each found as likely as `again` says.
fn led_back(locator: &mut Locator<Pulleys, Cable>, again: f32) -> Vec<usize> {
    let mut visited = Vec::new();
    locator.go_on(&prior(), ());
    while locator.track == 0 {
        let (radius, from) = ORDER[locator.order];
        visited.push(radius);
        let mut new = *locator.tracks[0].fit(from).expect("a neighbour");
        new.ln_evidence = again;
        locator.keep(Some(new));
        locator.go_on(&prior(), ());
    }
    visited
}

#[test]
fn a_radius_that_has_ended_elsewhere_is_fitted_again_from_the_best() {
    const NONE: f32 = f32::NEG_INFINITY;
    // The small radii have ended in another minimum: from the best on all of them are found again.
    let mut elsewhere = fitted([136.0, 136.5, 128.0, 130.0, 175.0, NONE]);
    assert_eq!(led_back(&mut elsewhere, 174.0), [3, 2, 1, 0]);
    let evidence = |locator: &Locator<_, _>, radius: usize| {
        let fit: Option<&Fitted> = locator.tracks[0].fit(radius);
        fit.map_or(NONE, |fit| fit.ln_evidence)
    };
    assert!((0..4).all(|radius| evidence(&elsewhere, radius) == 174.0));
    // What is found again is kept only where it is better, and what is hopeless then leads no farther.
    let mut worse = fitted([136.0, 136.5, 128.0, 130.0, 175.0, NONE]);
    assert_eq!(led_back(&mut worse, 120.0), [3]);
    assert_eq!(evidence(&worse, 3), 130.0);
    // Radii of one minimum are left as they are.
    let mut even = fitted([150.5, 153.0, 153.7, 154.2, 152.2, NONE]);
    assert_eq!(led_back(&mut even, 160.0), [0; 0]);
    // A radius that was hopeless and had no fit gets one where its neighbour is likely.
    let mut missing = fitted([NONE, 153.0, 153.7, NONE, 154.2, NONE]);
    assert_eq!(led_back(&mut missing, 154.0), [3, 0]);
}
