//! What the data hold, by how much of the finger is known (`--nocapture` shows the table;
//! `PALPATE_CONTACTS` says at how many contacts each).

use palpate_evaluation::bound::information::MEAN_SHARE;
use palpate_evaluation::bound::mean::{self, bound};
use palpate_evaluation::bound::sampled::{self, first_posterior};
use palpate_evaluation::bound::{
    Told, effects, force, ideal, levels, markdown, on_large, study, worm,
};
use palpate_plant::Parameters;
use palpate_scenes::for_scene;

fn contacts(usual: u64) -> u64 {
    std::env::var("PALPATE_CONTACTS").map_or(usual, |number| {
        number.parse().expect("PALPATE_CONTACTS is a number")
    })
}

#[test]
fn knowing_more_never_costs_and_the_locator_is_near_the_bound() {
    let contacts = contacts(24);
    let rows = study(&levels(), contacts, 1);
    let smooth = study(&[ideal()], contacts, 1);
    let large = study(&on_large(), contacts, 1);
    println!(
        "{}{}{}",
        markdown(&rows),
        markdown(&smooth),
        markdown(&large)
    );
    for row in rows.iter().chain(&smooth).chain(&large) {
        let [ours, exact] =
            [&row.ours, &row.exact].map(|scores| scores.err_mean_pct.unwrap_or(f64::NAN));
        assert!(ours < 1.25 * exact, "{}: {ours} {exact}", row.known);
    }
    let claimed: Vec<f64> = rows.iter().map(|row| row.exact_sigma_pct).collect();
    assert!(
        claimed.windows(2).all(|pair| pair[1] < 1.05 * pair[0]),
        "{claimed:?}"
    );
}

/// Fingers that the bound is computed for: one of each kind, and the prototype first without the object's compliance, as the exact posterior
/// has it.
const FINGERS: [&str; 9] = [
    "p70-grasp",
    "p70",
    "p70-preloaded",
    "tendon2",
    "tendon3",
    "hidden3",
    "linkage3",
    "return2",
    "direct2",
];

/// The bound of any finger, by Fisher's information; on the prototype as the exact posterior has it.
#[test]
fn pins_tell_places_on_every_finger_and_fisher_agrees_with_the_posterior() {
    let contacts = contacts(12);
    let bounds: Vec<_> = FINGERS
        .iter()
        .map(|name| {
            let parameters = Parameters::of(name).expect("a scene");
            for_scene!(*name, |S| bound::<S>(&parameters, contacts, 1))
                .flatten()
                .unwrap_or_else(|| panic!("{name}: no contacts"))
        })
        .collect();
    println!("{}", mean::markdown(&bounds));
    for bound in &bounds {
        assert_eq!(bound.contacts as u64, contacts, "{bound:?}");
        assert!(
            bound.calibrated_pct < 0.8 * bound.sheet_pct,
            "pins tell little: {bound:?}"
        );
        assert!(
            bound.calibrated_pct < 1.02 * bound.pressed_pct
                && bound.pressed_pct < 1.02 * bound.sheet_pct,
            "{bound:?}"
        );
        assert!(
            bound.calibrated_pct < 1.02 * bound.joints_forgotten_pct,
            "{bound:?}"
        );
    }
    let exact = &study(&levels()[..1], contacts, 1)[0];
    let ratio = bounds[0].sheet_pct / (MEAN_SHARE * exact.exact_sigma_pct);
    assert!((0.7..1.3).contains(&ratio), "{ratio}: {exact:?}");
}

/// The bound of effects whose rows in the experiments are worse than without them.
#[test]
fn effects_that_are_stated_have_bounds_of_their_own() {
    let bounds = effects::effects(contacts(12), 1).expect("contacts");
    println!("{}", effects::markdown(&bounds));
    let of = |name: &str| {
        let found = bounds.iter().find(|bound| bound.scene == name);
        found.expect("a row").leverage_pct
    };
    for name in ["p70", "p70-grasp"] {
        let large = of(&format!("{name}, cylinder of 120 mm"));
        assert!(large > of(name), "{name}: {large}");
    }
}

/// An error of the worm that nobody states: it moves places before it shows.
#[test]
fn an_error_of_the_worm_moves_places_before_it_shows() {
    let parameters = Parameters::of("p70").expect("a scene");
    let worms = for_scene!("p70", |S| worm::worms::<S>(&parameters, contacts(12), 1))
        .flatten()
        .expect("contacts");
    println!("{}", worm::markdown(&worms));
    for pair in worms.windows(2) {
        let [less, more] = pair else { unreachable!() };
        assert!(less.contact_nats < more.contact_nats && less.press_nats < more.press_nats);
        assert!(less.unstated_pct < more.unstated_pct && less.stated_pct < more.stated_pct);
        assert!(less.within2_pct > more.within2_pct);
        // Whoever takes it for none claims the same whatever it is.
        assert!((less.claimed_pct - more.claimed_pct).abs() < 1e-9);
    }
    for worm in &worms {
        assert!(worm.claimed_pct < worm.stated_pct && worm.stated_pct < worm.unstated_pct);
        if worm.amplitude_mrad > 1.0 {
            // What pins have shown of the waves is worth more than the doubt alone.
            assert!(worm.kept_pct[0] < 0.95 * worm.doubted_pct[0]);
            assert!(worm.doubted_pct[0] < worm.unstated_pct);
            assert!(worm.kept_pct[1] > worm.doubted_pct[1]);
        }
    }
}

/// Forces: what the springs are off by, a pin does not tell.
#[test]
fn forces_are_as_sure_as_the_springs_are_known() {
    let parameters = Parameters::of("p70").expect("a scene");
    let bounds = for_scene!("p70", |S| force::forces::<S>(&parameters, contacts(12), 1))
        .flatten()
        .expect("contacts");
    println!("{}", force::markdown(&bounds));
    let [press, pins, rubbing, springs] = bounds[..] else {
        panic!("{bounds:?}")
    };
    assert!(press.median_pct > pins.median_pct);
    assert!(pins.median_pct > rubbing.median_pct.max(springs.median_pct));
    // Springs that are known leave the path and what rubs.
    assert!(springs.within_pct > pins.within_pct && springs.median_pct > 1.0);
}

/// Fingers whose stiffness hardly changes with the place on a part of a phalanx, where the bound means little.
const FLAT: [&str; 5] = ["tendon2", "tendon3", "hidden3", "linkage3", "return2"];

/// The exact posterior where Fisher's information is rough: a third of the contacts, because each takes 1,600 curves.
#[test]
fn the_posterior_of_a_first_contact_is_as_sure_as_its_errors_say() {
    let contacts = (contacts(6) / 3).max(1);
    let posteriors = FLAT.map(|name| {
        let parameters = Parameters::of(name).expect("a scene");
        for_scene!(name, |S| first_posterior::<S>(&parameters, contacts, 1))
            .flatten()
            .unwrap_or_else(|| panic!("{name}: no contacts"))
    });
    println!("{}", sampled::markdown(&posteriors));
    let told: Vec<_> = posteriors
        .iter()
        .flat_map(|of| [of.pins.exact, of.press.exact])
        .collect();
    let mean = |of: fn(&Told) -> f64| told.iter().map(of).sum::<f64>() / told.len() as f64;
    let claimed_pct = mean(|told| told.claimed_pct);
    let ratio = claimed_pct / mean(|told| told.error_pct);
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
    let within2_pct = mean(|told| told.within2_pct);
    assert!(within2_pct > 80.0, "{within2_pct}");
    for of in &posteriors {
        assert_eq!(of.contacts as u64, contacts, "{of:?}");
    }
    // The library is given the same curves, and most of them it locates.
    for both in posteriors.iter().flat_map(|of| [of.pins, of.press]) {
        assert!(both.located as u64 * 2 >= contacts, "{both:?}");
        assert!(
            both.ours.error_pct < 4.0 * both.ours.claimed_pct,
            "{both:?}"
        );
    }
    // A uniform place has 29 % of the phalanx, of which the mean without sign is 23.
    assert!(claimed_pct < 10.0, "{claimed_pct}");
}
