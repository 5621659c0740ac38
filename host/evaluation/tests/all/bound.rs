//! What the data hold, by how much of the finger is known (`--nocapture` shows the table;
//! `PALPATE_CONTACTS` says at how many contacts each).

use palpate_evaluation::bound::{ideal, levels, markdown, study};

#[test]
fn knowing_more_never_costs_and_the_locator_is_near_the_bound() {
    let contacts = std::env::var("PALPATE_CONTACTS").map_or(24, |number| {
        number.parse().expect("PALPATE_CONTACTS is a number")
    });
    let rows = study(&levels(), contacts, 1);
    let smooth = study(&[ideal()], contacts, 1);
    println!("{}{}", markdown(&rows), markdown(&smooth));
    for row in rows.iter().chain(&smooth) {
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
