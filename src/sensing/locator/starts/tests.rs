//! Whether the further start of a finger that something holds at its stop finds what the others miss.

use super::*;
use crate::finger::Mounting;
use crate::scene::{Return2, Scene};
use crate::sensing::locator::fit::Progress;
use crate::sensing::locator::prior::FACTOR;
use crate::sensing::locator::tests::{curve_of, data, judged, prior};

/// Number of starts along the phalanx with which a round is compared.
const PLACES: u8 = 20;

/// This curve ends before the contact's friction lets joint 2 break away. Fits that do not begin with as much of it come to the kink from
/// the other side, 20 % of the phalanx from the contact, and stay there.
#[test]
fn a_finger_that_is_held_all_along_is_not_fitted_as_one_that_breaks_away() {
    let finger = Return2::MECHANISM.mounted(Mounting::LEVEL);
    let drivetrain = Return2::drivetrain(&finger);
    let near = finger.rest();
    let length_m = finger.phalanx_length_m(2).expect("two phalanges");
    let mut prior = prior();
    prior.joint_nm = [0.0, 0.5e-3];
    let (k_m, radius_m) = (0.85 * length_m, 0.0105);
    let values_of = [
        (K, k_m),
        (JOINT, 0.5e-3),
        (FRICTION, 0.2),
        (FACTOR, 1.0),
        (LOSS, 0.03),
    ];
    let mut points = curve_of(&finger, &drivetrain, &prior, radius_m, &values_of);
    points.truncate(26);
    let data = data(&points, &drivetrain);
    let locator = judged(&finger, &data, &prior);
    let found = locator.best_fit().expect("a fit");

    let (smallest, _) = ORDER[0];
    let track = locator.tracks.iter().find(|track| track.phalanx == 2);
    let hypothesis = Hypothesis {
        hold: track.expect("phalanx 2").hold(smallest, &prior),
        length_m,
    };
    let mut best = f32::NEG_INFINITY;
    for place in 1..PLACES {
        let mut x = values(f32::from(place) / f32::from(PLACES), &prior);
        x[FRICTION] = STUCK;
        let mut fit = Fit::new(hypothesis, x, false);
        let mut progress = Progress::UnderWay;
        while progress == Progress::UnderWay {
            progress = fit.step(&finger, &data, &prior, &near, ());
        }
        if let (Progress::Converged, Some(fitted)) = (progress, fit.fitted(&prior)) {
            best = best.max(fitted.ln_evidence);
        }
    }
    assert!(best.is_finite());
    assert!(
        found.ln_evidence > best - 1.0,
        "{} at {}, elsewhere {best}",
        found.ln_evidence,
        found.x[K]
    );
}
