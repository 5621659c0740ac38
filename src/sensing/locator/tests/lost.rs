//! Hypotheses that get one radius only.

use super::*;
use crate::scene::Tendon3;

/// A hypothesis that is lost is not fitted with other radii, so the last word comes earlier. The margin grows with the likeliest fit's chi
/// square, and nothing is lost against a contact that slides off its phalanx.
#[test]
fn a_hypothesis_that_is_lost_has_one_radius() {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    // Factor and friction that are known leave the other phalanx no way out.
    let mut prior = prior();
    prior.calibration.torque_factor_sigma = 2e-3;
    prior.noise.level_nm = 0.5e-3;
    prior.noise.wander_nm = 0.2e-3;
    let located = |points: &[Point]| judged(&finger, &data(points, &drivetrain), &prior);
    let radii = |locator: &Locator<_, Cable>| {
        let distal = locator.tracks.iter().find(|track| track.phalanx == 2);
        let fits = distal.expect("a hypothesis").fits;
        fits.iter().flatten().count()
    };
    let proximal = curve_held(&finger, &drivetrain, &prior, Hold::Proximal, &[]);
    let mut locator = located(&proximal);
    assert_eq!(radii(&locator), 1);
    assert!(radii(&located(&curve(0.035, 0.02, 0.2e-3, &drivetrain))) > 2);

    let lost = locator.lost();
    let best = locator.tracks[0].fits[1]
        .as_mut()
        .expect("the proximal fit");
    best.chi_square += 500.0;
    assert!((lost - locator.lost() - 500.0).abs() < 0.1);
    locator.tracks[0].fits[1].as_mut().expect("a fit").leaves = true;
    assert_eq!(locator.lost(), f32::NEG_INFINITY);
}

/// Large objects keep their hypothesis on three phalanges too, though it is tried with a small radius first: the likeliest fit is as likely
/// as one that starts with the object's radius at its place.
#[test]
fn large_objects_are_not_lost_on_three_phalanges() {
    let finger = Tendon3::MECHANISM;
    let drivetrain = Tendon3::drivetrain(&finger);
    let near = finger.rest();
    let prior = prior();
    let mut lost = 0;
    for (phalanx, share, object_m) in [2, 3].into_iter().flat_map(|phalanx| {
        [0.15, 0.4, 0.65, 0.85]
            .into_iter()
            .flat_map(move |share| [0.025, 0.05, 0.1].map(|object_m| (phalanx, share, object_m)))
    }) {
        let hold = Hold::Contact {
            phalanx,
            radius_m: object_m + prior.half_thickness_m,
        };
        let length_m = finger.phalanx_length_m(phalanx).expect("a phalanx");
        let points = curve_held(&finger, &drivetrain, &prior, hold, &[(K, share * length_m)]);
        let data = data(&points, &drivetrain);
        let locator = judged(&finger, &data, &prior);
        let found = locator.best_fit().expect("a fit");
        lost += (locator.tracks.iter())
            .filter(|track| track.phalanx > 1 && track.fits.iter().flatten().count() == 1)
            .count();
        let mut fit = Fit::new(
            Hypothesis { hold, length_m },
            starts::values(share, &prior),
            false,
        );
        let mut progress = Progress::UnderWay;
        while progress == Progress::UnderWay {
            progress = fit.step(&finger, &data, &prior, &near, ());
        }
        let own = fit.fitted(&prior).expect("its own fit");
        assert!(
            found.ln_evidence > own.ln_evidence - 0.5,
            "{phalanx} {share} {object_m}: {found:?} {own:?}"
        );
    }
    assert!(lost > 0, "all have several radii: nothing is tested");
}
