//! The search for a second contact, where what came before the first one must not count.

use crate::sensing::second::{BlockNoise, SecondContact, SlopeChange};

const NOISE: BlockNoise = BlockNoise {
    white_nm2: 1e-8,
    walk_nm2: 0.0,
    worm_turn_rad: 0.3,
    worm_error_rad: 0.0,
};
const BLOCK_RAD: f32 = 0.005;

/// A curve that bends, with a corner of a quarter of its slope at 0.5 rad: pairs of blocks show it, single ones do not.
fn corner_nm(theta: f32) -> f32 {
    0.4 * theta + 0.35 * theta * theta + 0.2 * (theta - 0.5).max(0.0)
}

/// What is told of a contact at 0 after blocks before it, with what is called before every block.
fn told(
    before: &[[f32; 2]],
    level_nm: f32,
    each: impl Fn(&mut SecondContact),
) -> Option<SlopeChange> {
    let mut search = SecondContact::default();
    for [theta, torque] in before {
        search.note(*theta, *torque);
    }
    search.begin(0.0, level_nm, 0.01);
    (0..180).find_map(|block| {
        each(&mut search);
        let theta = BLOCK_RAD * block as f32;
        search.push(theta, corner_nm(theta), &NOISE, false)
    })
}

/// An odd number of blocks before the contact leaves half a pair: the first block in contact is none of it.
#[test]
fn a_pair_of_blocks_has_no_block_before_the_contact() {
    let alone = told(&[], 0.0, |_| {});
    assert!(
        alone.is_some_and(|change| (change.theta_a_rad - 0.5).abs() < 0.016),
        "{alone:?}"
    );
    for blocks in 1..8 {
        let before: Vec<[f32; 2]> = (0..blocks)
            .map(|i| [BLOCK_RAD * (i - blocks) as f32, 0.05])
            .collect();
        assert_eq!(told(&before, 0.0, |_| {}), alone, "{blocks}");
    }
}

/// A contact begins once, though it is said with every block: what the level was off by is taken off once, and what a
/// second contact's torque must be at least stays.
#[test]
fn a_contact_begins_once() {
    for level_nm in [-0.01, 0.0, 0.01] {
        let once = told(&[], level_nm, |_| {});
        assert!(once.is_some());
        let again = told(&[], level_nm, |search| search.begin(0.3, level_nm, 10.0));
        assert_eq!(again, once, "{level_nm}");
    }
}

/// A finger that moves on after a second contact shows a smaller corner: of blocks as they are six deviations count there, and eight
/// elsewhere, where the same corner is one of pairs.
#[test]
fn three_phalanges_tell_a_smaller_corner_of_blocks() {
    let noise = BlockNoise {
        white_nm2: 1e-6,
        ..NOISE
    };
    let spacing = |rise: f32, moves_on| {
        let mut search = SecondContact::default();
        search.begin(0.0, 0.0, 0.01);
        for block in 0..44 {
            let theta = BLOCK_RAD * block as f32;
            let torque = 0.2 * theta + rise * (theta - 0.199).max(0.0);
            let found = search.push(theta, torque, &noise, moves_on);
            assert_eq!(found, None, "not while it is still getting better");
        }
        let change = search.finish();
        change.map(|change| (change.spacing_rad / BLOCK_RAD).round())
    };
    for (rise, two, three) in [
        (0.3, None, None),
        (0.5, Some(2.0), Some(2.0)),
        (0.6, Some(2.0), Some(1.0)),
        (0.9, Some(1.0), Some(1.0)),
    ] {
        assert_eq!(
            [false, true].map(|on| spacing(rise, on)),
            [two, three],
            "{rise}"
        );
    }
}
