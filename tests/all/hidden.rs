//! `hidden3`: behind a phalanx within the palm every place of the others has a stiffness of its own.

use palpate::finger::{Class, Mechanics, Mounting};
use palpate::scene::Scene;
use palpate_scenes::Hidden3;

/// Torques of the free finger at contact, newton metre, and places, in lengths of the phalanx.
const TORQUES_NM: [f32; 3] = [0.02, 0.04, 0.06];
const SHARES: [f32; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

#[test]
fn no_two_places_are_equally_stiff() {
    let finger = Hidden3::MECHANISM.mounted(Mounting::LEVEL);
    for torque_nm in TORQUES_NM {
        let at = finger
            .free_at_torque(torque_nm, &finger.rest())
            .expect("a posture");
        let compliances: Vec<f32> = [2u8, 3]
            .into_iter()
            .flat_map(|phalanx| SHARES.map(|share| (phalanx, share)))
            .map(|(phalanx, share)| {
                let k_m = share * finger.phalanx_length_m(phalanx).expect("a phalanx");
                finger
                    .contact_compliance(&at, torque_nm, phalanx, k_m)
                    .expect("stable")
            })
            .collect();
        println!("{torque_nm} N m: {compliances:.2?} rad/(N m)");
        assert!(compliances.windows(2).all(|pair| pair[1] < 0.97 * pair[0]));
        assert!(compliances[0] > 15.0 * compliances[17]);
    }
}

#[test]
fn the_inverse_tells_no_place_on_the_hidden_phalanx() {
    let finger = Hidden3::MECHANISM.mounted(Mounting::LEVEL);
    let torque_nm = 0.04;
    let at = finger
        .free_at_torque(torque_nm, &finger.rest())
        .expect("a posture");
    for phalanx in [2u8, 3] {
        let length_m = finger.phalanx_length_m(phalanx).expect("a phalanx");
        for share in SHARES {
            let compliance = finger
                .contact_compliance(&at, torque_nm, phalanx, share * length_m)
                .expect("stable");
            let inverse = finger.locate(&at, torque_nm, compliance);
            assert_eq!(inverse.class(), Class::Unique, "{phalanx} {share}");
            let [place] = inverse.candidates() else {
                panic!("{inverse:?}");
            };
            assert_eq!(place.phalanx, phalanx);
            assert!((place.k_m / length_m - share).abs() < 1e-4, "{place:?}");
        }
    }
    // As soft as a contact on the hidden phalanx, and a little softer: no contact is.
    let hidden = finger
        .proximal_compliance(&at, torque_nm)
        .expect("a compliance");
    assert_eq!(
        finger.locate(&at, torque_nm, 1.01 * hidden).class(),
        Class::Gap
    );
}
