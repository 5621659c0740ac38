//! Work on drawn fingers, side by side, and what it comes to.

use palpate_cli::progress::bar;
use rayon::prelude::*;

/// Does the same with the finger of every seed, on all cores, with a progress bar of this label. What came of it in the order of the
/// seeds, and what could not be done: the seed, and why.
pub fn each<T: Send, E: Send>(
    label: &str,
    seeds: std::ops::Range<u64>,
    finger: impl Fn(u64) -> Result<T, E> + Sync,
) -> (Vec<T>, Vec<(u64, E)>) {
    let bar = bar(seeds.clone().count(), label);
    let done: Vec<_> = seeds
        .into_par_iter()
        .map(|seed| {
            let result = finger(seed);
            bar.inc(1);
            result.map_err(|error| (seed, error))
        })
        .collect();
    bar.finish_and_clear();
    let (mut good, mut failed) = (Vec::new(), Vec::new());
    for result in done {
        match result {
            Ok(result) => good.push(result),
            Err(failure) => failed.push(failure),
        }
    }
    (good, failed)
}

/// Puts the scores of all fingers together, one by one: each finger has `number` of them.
pub fn total<S: Default>(
    all: &[Vec<S>],
    number: usize,
    with: impl Fn(S, &S) -> S + Copy,
) -> Vec<S> {
    let one = |index: usize| {
        let scores = all.iter().filter_map(|scores| scores.get(index));
        scores.fold(S::default(), with)
    };
    (0..number).map(one).collect()
}
