//! The locator against the exact posterior of random curves (`PALPATE_CURVES` says how
//! many, 150 without): brute force in f64 with mechanics of its own.
//!
//! Curves are drawn from what the locator assumes, so both must be right about the truth, and agree about each curve.

use palpate::sensing::locator::LocatorResult;
use palpate_evaluation::bound::{Judged, judged, levels};
use palpate_evaluation::score::{Scores, quantile};

fn curves() -> u64 {
    std::env::var("PALPATE_CURVES").map_or(150, |number| {
        number.parse().expect("PALPATE_CURVES is a number")
    })
}

/// Both about the same curve: the difference of their places in deviations, and the ratio of the deviations.
fn compared(one: &Judged) -> Option<(f64, f64)> {
    let (LocatorResult::At(ours) | LocatorResult::Either([ours, _])) = one.located else {
        return None;
    };
    let exact = one.exact?;
    (ours.phalanx == 2).then(|| {
        (
            (f64::from(ours.k_m) - exact.k_m).abs() / exact.sigma_m,
            f64::from(ours.k_sigma_m) / exact.sigma_m,
        )
    })
}

#[test]
fn an_uncalibrated_finger_locates_as_the_exact_posterior_does() {
    let known = &levels()[0];
    let all = judged(known, curves(), 1);
    let ours = Scores::of(&all.iter().map(Judged::ours).collect::<Vec<_>>());
    let exact = Scores::of(&all.iter().map(Judged::theirs).collect::<Vec<_>>());
    let both: Vec<_> = all.iter().filter_map(compared).collect();
    let apart: Vec<f64> = both.iter().map(|(apart, _)| *apart).collect();
    let ratio: Vec<f64> = both.iter().map(|(_, ratio)| *ratio).collect();
    let of = |values: &[f64], share| quantile(values, share).unwrap_or(f64::NAN);
    println!(
        "{}: compared {}, apart 50/90/99 % {:.2} {:.2} {:.2}, deviations 1/50/99 % {:.2} {:.2} {:.2}\n  ours {:.2?} % within 2 {:.1?}, exact {:.2?} % within 2 {:.1?}, located {}",
        known.name,
        both.len(),
        of(&apart, 0.5),
        of(&apart, 0.9),
        of(&apart, 0.99),
        of(&ratio, 0.01),
        of(&ratio, 0.5),
        of(&ratio, 0.99),
        ours.err_mean_pct,
        ours.within2_pct,
        exact.err_mean_pct,
        exact.within2_pct,
        ours.located,
    );
    // Both are right about the truth, but for what Laplace's approximation at a bound leaves out.
    assert_eq!(exact.located, all.len());
    for scores in [&exact, &ours] {
        assert!(scores.within2_pct.unwrap_or(0.0) >= 85.0);
    }
    // And agree about each curve.
    assert!(both.len() as f64 >= 0.97 * all.len() as f64);
    assert!(of(&apart, 0.9) < 1.0 && of(&apart, 0.98) < 2.5);
    assert!(of(&ratio, 0.02) > 0.6 && of(&ratio, 0.98) < 3.0);
    let [ours, exact] = [&ours, &exact].map(|scores| scores.err_mean_pct.expect("a place"));
    assert!(ours < 1.2 * exact, "{ours} {exact}");
}
