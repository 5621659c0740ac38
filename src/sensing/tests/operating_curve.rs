//! False contacts against delay for each choice of the setting `sensitivity`, with friction drawn from the model.

use super::detector::{SOFTEST_NM, close};
use super::free::{BLOCKS, Life, WORLDS};
use crate::sensing::detector::{Finding, threshold};

/// What each choice of `sensitivity` costs, over all worlds; printed for docs/MANUAL.md#sensitivity. `PALPATE_CLOSINGS` says how
/// many closings of each world, 8 without it.
#[test]
fn operating_curve() {
    let closings = std::env::var("PALPATE_CLOSINGS").map_or(8, |n| n.parse().expect("a number"));
    let choices = [100.0, 10.0, 1.0, 0.1, 0.01, 0.001];
    let lives = || {
        (0..closings).flat_map(|seed: u64| {
            WORLDS.iter().enumerate().map(move |(index, world)| {
                let mut life = Life::new(*world, 500_000 + 10_000 * index as u64 + seed);
                let record = life.record();
                (life, record)
            })
        })
    };
    let mut free = [0usize; 6];
    let mut soft = [0usize; 6];
    let mut delays: [[Vec<f64>; 2]; 6] = Default::default();
    let mut count = 0;
    for (life, record) in lives() {
        count += 1;
        for (choice, &per_thousand) in choices.iter().enumerate() {
            match close(&mut life.clone(), &record, per_thousand, |_| 0.0) {
                Some((_, Finding::Contact(_))) => free[choice] += 1,
                Some((_, Finding::Softer(_))) => soft[choice] += 1,
                _ => {}
            }
            for (kind, stiffness) in [1.0, 2.5].into_iter().enumerate() {
                let from = 150;
                let load = |i: i32| stiffness * SOFTEST_NM * f64::from((i - from).max(0));
                let found = close(&mut life.clone(), &record, per_thousand, load);
                if let Some((at, Finding::Contact(_))) = found
                    && at >= from
                {
                    // The contact begins half way through a block.
                    let delay_s = (f64::from(at - from) + 0.5) * life.block_s();
                    delays[choice][kind].push(1e3 * delay_s);
                }
            }
        }
    }
    println!("{count} closings, each with a record of its own from one closing and one opening\n");
    println!(
        "| `sensitivity` | ln ratio | false contacts / 1000 | false `unusual` / 1000 | softest contact, ms: median, 90 % | 2.5 times as stiff |"
    );
    println!("|---|---|---|---|---|---|");
    let mut medians = Vec::new();
    for (choice, per_thousand) in choices.into_iter().enumerate() {
        let per = |n: usize| 1e3 * n as f64 / f64::from(count);
        let quantiles = delays[choice].each_mut().map(|delays| {
            delays.sort_by(f64::total_cmp);
            let at = |share: f64| delays[(share * (delays.len() - 1) as f64) as usize];
            (at(0.5), at(0.9))
        });
        let [(soft_median, soft_most), (median, most)] = quantiles;
        medians.push(soft_median);
        println!(
            "| {per_thousand} | {:.1} | {:.1} | {:.1} | {soft_median:.0}, {soft_most:.0} | {median:.0}, {most:.0} |",
            threshold(per_thousand, BLOCKS as f32),
            per(free[choice]),
            per(soft[choice]),
        );
    }
    assert!(medians.is_sorted() && medians[5] < 250.0, "{medians:?}");
    assert!(free.is_sorted_by(|more, fewer| more >= fewer), "{free:?}");
    // The setting is about an upper bound: none of few closings, and less than one in a thousand of many.
    assert!(
        1000 * (free[5] + soft[5]) < count as usize,
        "{free:?} {soft:?}"
    );
}
