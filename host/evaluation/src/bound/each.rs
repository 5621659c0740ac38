//! Contacts by number, each with random numbers of its own.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

/// Contacts that a finger cannot make are drawn again, so often.
pub(super) const DRAWS: usize = 50;

/// Makes something of each of so many drawn contacts, with at most so many draws for one; leaves out those of which nothing is made.
pub(super) fn each<T: Send>(
    contacts: u64,
    seed: u64,
    draws: usize,
    make: impl Fn(&mut Pcg64Mcg) -> Option<T> + Sync,
) -> Vec<T> {
    (0..contacts)
        .into_par_iter()
        .filter_map(|index| {
            let mut random = Pcg64Mcg::seed_from_u64((seed << 32) + index);
            (0..draws).find_map(|_| make(&mut random))
        })
        .collect()
}
