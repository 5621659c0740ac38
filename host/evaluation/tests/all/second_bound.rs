//! What the data hold of the place of a second contact (`--nocapture` shows the tables; `PALPATE_CONTACTS` says at how many grasps each,
//! a third of them by sampling).

use palpate_evaluation::bound::second::{
    SecondBound, markdown, posterior_markdown, second_bound, second_posterior,
};
use palpate_plant::{Parameters, World};
use palpate_scenes::for_scene;

/// Worlds and scenes.
const CASES: [(&str, &str); 4] = [
    ("workshop", "tendon3"),
    ("workshop", "linkage3"),
    ("harsh", "tendon3"),
    ("harsh", "linkage3"),
];

/// Cells of the document's row that begins so.
fn row(begins: &str) -> Vec<&'static str> {
    let document = include_str!("../../../../docs/SECOND_CONTACTS.md");
    let line = document.lines().find(|line| line.starts_with(begins));
    let line = line.unwrap_or_else(|| panic!("no row {begins}"));
    line.split('|').skip(1).map(str::trim).collect()
}

/// Error that the experiments measured, percent of the phalanx (docs/SECOND_CONTACTS.md#two-contacts), which stands beside the bound too.
fn measured_pct(world: &str, scene: &str) -> f64 {
    let measured = row(&format!("| `{world}`, plant | {scene} |"))[8];
    assert_eq!(row(&format!("| `{world}`, {scene} |"))[1], measured);
    measured.parse().expect("a number")
}

fn contacts(usual: u64) -> u64 {
    std::env::var("PALPATE_CONTACTS").map_or(usual, |number| {
        number.parse().expect("PALPATE_CONTACTS is a number")
    })
}

fn parameters(world: &str, scene: &str) -> Parameters {
    let world = World::named(world).expect("a world");
    world.of(scene).expect("a scene")
}

fn of(parameters: &Parameters, contacts: u64) -> SecondBound {
    let scene = parameters.scene.as_str();
    for_scene!(scene, |S| second_bound::<S>(parameters, contacts, 1))
        .flatten()
        .unwrap_or_else(|| panic!("{scene}: no grasps"))
}

#[test]
fn who_knows_more_is_off_by_less_and_no_experiment_is_below_the_bound() {
    let contacts = contacts(8);
    let rows = CASES.map(|(world, scene)| (world, of(&parameters(world, scene), contacts)));
    println!("{}", markdown(&rows));
    for ((_, bound), (world, scene)) in rows.iter().zip(CASES) {
        let measured_pct = measured_pct(world, scene);
        assert_eq!(bound.grasps as u64, contacts, "{bound:?}");
        assert!(2 * bound.told > bound.grasps, "{bound:?}");
        let below = |more_pct: f64, less_pct: f64| assert!(more_pct < 1.02 * less_pct, "{bound:?}");
        below(bound.round_pct, bound.whole_pct);
        below(bound.after_round_pct, bound.after_pct);
        below(bound.after_round_pct, bound.alone_pct);
        below(bound.smooth_pct, bound.round_pct);
        below(bound.even_pct, bound.round_pct);
        below(bound.cylinder_pct, bound.round_pct);
        below(bound.noise_pct, bound.cylinder_pct);
        // A uniform place has 29 % of the phalanx, of which the mean without sign is 23.
        assert!(
            bound.after_pct < 23.5 && bound.cylinder_pct > 0.3,
            "{bound:?}"
        );
        assert!(bound.round_pct < 1.2 * measured_pct, "{bound:?}");
    }
    for (workshop, harsh) in [(0, 2), (1, 3)] {
        assert!(rows[workshop].1.round_pct < rows[harsh].1.round_pct);
    }
}

#[test]
fn friction_that_wanders_more_hides_more() {
    let calm = parameters("workshop", "tendon3");
    let mut wild = calm.clone();
    wild.friction.wander_share *= 10.0;
    let (calm, wild) = (of(&calm, 8), of(&wild, 8));
    assert!(wild.whole_pct > 1.1 * calm.whole_pct, "{calm:?} {wild:?}");
}

#[test]
fn the_exact_posterior_is_about_as_sure_as_the_bound() {
    let contacts = (contacts(9) / 3).max(1);
    let rows = CASES.map(|(world, scene)| {
        let parameters = parameters(world, scene);
        let posterior = for_scene!(scene, |S| second_posterior::<S>(&parameters, contacts, 1));
        (world, posterior.flatten().expect("grasps"))
    });
    println!("{}", posterior_markdown(&rows));
    for ((world, posterior), (_, scene)) in rows.iter().zip(CASES) {
        let bound = of(&parameters(world, scene), contacts);
        let ratio = posterior.claimed_pct / bound.round_pct;
        assert!((0.6..1.6).contains(&ratio), "{bound:?} {posterior:?}");
        assert!(posterior.within2_pct > 70.0, "{posterior:?}");
    }
}
