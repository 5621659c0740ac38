//! Files about parts of the finger: `static_forces` and `fourbar`.

use crate::equilibrium::arms;
use crate::finger::{Finger, FourBar, derivatives};
use crate::linear::solve;
use crate::real::Real;
use crate::table::Row;
use crate::value::Values;

/// `static_forces`: contacts on all phalanges.
///
/// # Panics
/// A contact lies on a joint.
#[must_use]
pub fn forces(row: &Row) -> Values {
    let joints = row.f64("n") as usize;
    let read = |prefix: &str, suffix: &str| -> Vec<Real> {
        (1..=joints)
            .map(|joint| row.real(&format!("{prefix}{joint}{suffix}")))
            .collect()
    };
    let theta = read("th", "");
    let springs = read("K", "")
        .into_iter()
        .zip(read("th", "0").into_iter().zip(&theta));
    let torques: Vec<Real> = springs
        .zip(read("x", ""))
        .map(|((spring, (rest, angle)), x)| x * row.real("T_a") - spring * (angle - rest))
        .collect();
    let finger = Finger {
        lengths: read("l", ""),
        springs: Vec::new(),
        rest: Vec::new(),
        stages: Vec::new(),
    };
    let arms: Vec<Vec<Real>> = read("k", "")
        .iter()
        .enumerate()
        .map(|(i, k)| arms(&finger, &theta, i, k))
        .collect();
    let transposed = (0..joints)
        .map(|m| arms.iter().map(|arms| arms[m].clone()).collect())
        .collect();
    let (forces, _) = solve(transposed, torques.clone()).expect("contacts off the joints");
    let mut values = Values::new();
    values.joints("tau", "", &torques);
    values.joints("f", "", &forces);
    for joint in joints + 1..=3 {
        values.absent(&format!("tau{joint}"));
        values.absent(&format!("f{joint}"));
    }
    values
}

/// `fourbar`.
#[must_use]
pub fn four_bar(row: &Row) -> Values {
    let bars = FourBar::of(row.real("g"), |name| row.real(name));
    let v = row.real("v");
    let lever = bars.lever(&v);
    let rotation = bars.rotation(&v);
    let mut values = Values::new();
    if lever.is_nan() || rotation.is_nan() {
        for name in ["gamma", "F", "h", "x", "dx", "d2x"] {
            values.absent(name);
        }
        values.text("status", "no_closure");
        return values;
    }
    let [first, second, third] = derivatives(&v, |v| bars.lever(v));
    values.number("gamma", &lever);
    values.number("F", &rotation);
    values.number("h", &bars.pole(&v));
    values.number("x", &first);
    values.number("dx", &second);
    values.number("d2x", &third);
    values.text("status", "ok");
    values
}
