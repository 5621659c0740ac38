//! What stands beside the likeliest hypothesis in a verdict.

use super::*;
use crate::scene::Tendon3;
use crate::sensing::NotLocated;

/// The verdict on hypotheses, each a phalanx, a place in its lengths and odds against the others.
fn verdict(hypotheses: &[(u8, f32, f32)]) -> LocatorResult {
    const LENGTH_M: f32 = 0.05;
    let mut locator = Locator::<<Tendon3 as Scene>::Finger, Cable> {
        number: 30,
        ..Locator::default()
    };
    for &(phalanx, place, odds) in hypotheses {
        // The prior of the radius takes a share of a hypothesis that has a place.
        let shares = if phalanx > 1 {
            RADII_M.len() as f32
        } else {
            1.0
        };
        let track = track(phalanx, LENGTH_M, [place, 0.02], (odds * shares).ln());
        locator.tracks.push(track).expect("room");
    }
    locator.verdict(&prior())
}

/// Phalanx 1 beside a place says with its probability what it has to; a third hypothesis may be another place.
#[test]
fn a_place_is_ambiguous_beside_another_one_though_phalanx_1_is_likelier() {
    let three = [(2, 0.3, 0.45), (1, 0.5, 0.30), (2, 0.7, 0.25)];
    let LocatorResult::Either([first, other]) = verdict(&three) else {
        panic!("{:?}", verdict(&three));
    };
    assert!((first.k_m - 0.015).abs() < 1e-4 && (other.k_m - 0.035).abs() < 1e-4);
    assert!((first.p_phalanx - 0.7).abs() < 0.01, "{first:?}");
    let phalanges = [(2, 0.3, 0.45), (1, 0.5, 0.30), (3, 0.7, 0.25)];
    assert!(matches!(
        verdict(&phalanges),
        LocatorResult::Either([Estimate { phalanx: 2, .. }, Estimate { phalanx: 3, .. }])
    ));
    let unlikely = [(2, 0.3, 0.69), (1, 0.5, 0.30), (3, 0.7, 0.01)];
    assert!(
        matches!(verdict(&unlikely), LocatorResult::At(Estimate { p_phalanx, .. }) if (p_phalanx - 0.69).abs() < 0.01)
    );
}

#[test]
fn a_contact_on_the_joint_is_proximal_unless_a_place_farther_out_may_be() {
    let nowhere = |why| LocatorResult::Nowhere(why);
    let joint = [(2, 0.01, 0.6), (1, 0.5, 0.4)];
    assert_eq!(verdict(&joint), nowhere(NotLocated::Proximal));
    let beyond = [(2, 0.01, 0.5), (1, 0.5, 0.3), (2, 0.6, 0.2)];
    assert_eq!(verdict(&beyond), nowhere(NotLocated::Unobservable));
    let proximal = [(1, 0.5, 0.8), (2, 0.6, 0.2)];
    assert_eq!(verdict(&proximal), nowhere(NotLocated::Unobservable));
}
