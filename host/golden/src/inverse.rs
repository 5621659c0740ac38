//! Files that look for every place of a contact that explains a compliance: `inverse`, `inverse_folded`, `hard`.

use crate::equilibrium::{Linear, arms};
use crate::finger::Finger;
use crate::forward::posture;
use crate::linear::Vector;
use crate::real::Real;
use crate::table::Row;
use crate::value::Values;

/// A discriminant this small, relative to the squared linear coefficient, is the rounding of zero.
const DOUBLE_ROOT: i32 = -170;
/// Nearer to the joint than this share of the phalanx a place is that of a contact on the phalanx before.
const AT_JOINT: f64 = 1e-3;
/// A compliance this near to that of phalanx 1 is that of phalanx 1, rounded to f32.
const PROXIMAL: f64 = 1e-6;

/// A place at which the finger would be as compliant as measured.
#[derive(Clone, Debug)]
pub struct Place {
    /// Which phalanx, from 0.
    pub phalanx: usize,
    /// Distance from its joint.
    pub k: Real,
    /// A closing finger presses on an object there.
    pub physical: bool,
}

/// All places on one phalanx, both signs of `k`, and the discriminant over the squared linear coefficient.
///
/// Determinant times (C(k) - C) is a polynomial in `k` of second degree, because the moment arms are linear in `k`: three
/// evaluations give its coefficients.
pub fn roots(
    linear: &Linear,
    arms_at: impl Fn(&Real) -> Vector,
    compliance: &Real,
    scale: &Real,
) -> (Vec<(Real, bool)>, Real) {
    let value = |k: &Real| {
        let held = linear.held(&arms_at(k)).expect("a contact");
        held.determinant * (held.compliance - compliance)
    };
    // At 1, 2 and 3 times the scale.
    let [at_1, at_2, at_3] = [1.0, 2.0, 3.0].map(|times| value(&(scale * Real::from(times))));
    let [half, two, three, four] = [0.5, 2.0, 3.0, 4.0].map(Real::from);
    let square = (&at_1 - &two * &at_2 + &at_3) * half;
    let line = &at_2 - &at_1 - &three * &square;
    let constant = at_1 - &line - &square;
    let mut discriminant = &line * &line - four * &square * &constant;
    let relative = &discriminant / (&line * &line);
    if relative.abs() < Real::power_of_two(DOUBLE_ROOT) {
        discriminant = Real::zero();
    }
    if discriminant.is_negative() {
        return (Vec::new(), relative);
    }
    let sum = if line.is_negative() {
        &line - discriminant.sqrt()
    } else {
        &line + discriminant.sqrt()
    };
    let far = &sum * Real::from(-0.5) / square;
    let near = &constant * Real::from(-2.0) / &sum;
    let mut found: Vec<Real> = [near, far].into_iter().map(|root| root * scale).collect();
    found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    let judged = found.into_iter().map(|k| {
        let physical = linear
            .held(&arms_at(&k))
            .is_some_and(|held| held.press.is_positive());
        (k, physical)
    });
    (judged.collect(), relative)
}

/// All places on phalanges from the second on, within their lengths.
fn places(finger: &Finger, linear: &Linear, theta: &[Real], compliance: &Real) -> Vec<Place> {
    let on = |phalanx: usize| {
        let length = &finger.lengths[phalanx];
        let (found, _) = roots(
            linear,
            |k| arms(finger, theta, phalanx, k),
            compliance,
            length,
        );
        let within = found
            .into_iter()
            .filter(|(k, _)| k.is_positive() && k <= length);
        within
            .map(move |(k, physical)| Place {
                phalanx,
                k,
                physical,
            })
            .collect::<Vec<_>>()
    };
    (1..finger.joints()).flat_map(on).collect()
}

fn write(values: &mut Values, prefix: &str, slots: &[&str], places: &[&Place]) {
    for (index, slot) in slots.iter().enumerate() {
        let (phalanx, k) = (format!("{prefix}phal_{slot}"), format!("{prefix}k_{slot}"));
        match places.get(index) {
            Some(place) => {
                values.text(&phalanx, place.phalanx + 1);
                values.number(&k, &place.k);
            }
            None => {
                values.text(&phalanx, 0);
                values.absent(&k);
            }
        }
    }
}

/// `inverse_*` and `inverse_folded_*`.
///
/// # Panics
/// The finger has no posture at this torque.
#[must_use]
pub fn inverse(row: &Row) -> Values {
    let finger = row.finger();
    let torque = row.real("T_c");
    let theta = posture(row, &finger, &torque);
    let compliance = row.real("C_meas");
    let linear = Linear::at(&finger, &torque, &theta);
    let on_first = linear
        .held(&arms(&finger, &theta, 0, &finger.lengths[0]))
        .expect("a contact");
    let proximal = on_first.compliance;
    let free =
        (!finger.springs[0].is_zero()).then(|| linear.free_compliance().expect("a stable finger"));
    let is_proximal = (&compliance / &proximal - Real::one()).abs() < Real::from(PROXIMAL);
    let places = places(&finger, &linear, &theta, &compliance);
    let folded = row.has("rej_k_a");
    let kept = |place: &&Place| {
        let at_joint = place.k < &finger.lengths[place.phalanx] * Real::from(AT_JOINT);
        place.physical && !(is_proximal && at_joint && !folded)
    };
    let physical: Vec<&Place> = places.iter().filter(kept).collect();
    let mut values = Values::new();
    values.joints("th", "", &theta);
    values.text("n_sol", physical.len());
    if folded {
        let rejected: Vec<&Place> = places.iter().filter(|place| !place.physical).collect();
        write(&mut values, "", &["a", "b", "c"], &physical);
        write(&mut values, "rej_", &["a", "b"], &rejected);
    } else {
        let class = match physical[..] {
            _ if is_proximal => "proximal",
            [] if free.as_ref().is_some_and(|free| compliance > *free) => "none_too_soft",
            [] if compliance > proximal => "none_gap",
            [] => "none_too_stiff",
            [_] => "unique",
            [first, .., last] if first.phalanx == last.phalanx => "ambig_same",
            _ => "ambig_cross",
        };
        values.text("class", class);
        let slots = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
        // Two places on each phalanx but the first.
        let count = if row.has("phal_e") { slots.len() } else { 4 };
        write(&mut values, "", &slots[..count], &physical);
    }
    values.number("C_proximal", &proximal);
    match free {
        Some(free) => values.number("C_free", &free),
        None => values.absent("C_free"),
    }
    values
}

/// A finger of which only the instant of contact is given.
fn reduced(row: &[Real], stiffness: &[Real]) -> Linear {
    let size = row.len();
    let entry = |i: usize, j: usize| {
        if i == j {
            stiffness[i].clone()
        } else {
            Real::zero()
        }
    };
    Linear {
        row: row.to_vec(),
        stiffness: (0..size)
            .map(|i| (0..size).map(|j| entry(i, j)).collect())
            .collect(),
    }
}

/// Moment arms in a posture, from positions: the finger needs no transmission for them.
fn posture_arms(lengths: Vec<Real>, theta: Vec<Real>, phalanx: usize) -> impl Fn(&Real) -> Vector {
    let finger = Finger {
        lengths,
        springs: Vec::new(),
        rest: Vec::new(),
        stages: Vec::new(),
    };
    move |k| arms(&finger, &theta, phalanx, k)
}

/// `hard_2p`.
#[must_use]
pub fn hard_two(row: &Row) -> Values {
    let linear = reduced(
        &[Real::one(), row.real("x2")],
        &[row.real("K1"), row.real("K2p")],
    );
    let (lengths, turned) = (vec![row.real("l1"), row.real("l2")], row.real("th2"));
    let cosine = turned.sin_cos().1;
    let arms_at = posture_arms(lengths, vec![Real::zero(), turned], 1);
    let x2 = row.real("x2");
    let stiffest = row.real("l1") * &cosine * &x2 / (Real::one() - x2);
    let (found, _) = roots(&linear, arms_at, &row.real("C"), &row.real("l2"));
    let usable = |k: &Real, physical: bool| k.is_positive() && (physical || row.f64("C") == 0.0);
    let mut values = Values::new();
    let folded = cosine.is_negative();
    let mut slot = |name: &str, wanted: &dyn Fn(&Real) -> bool| match found
        .iter()
        .find(|(k, physical)| usable(k, *physical) && wanted(k))
    {
        Some((k, _)) => values.number(name, k),
        None => values.absent(name),
    };
    // A double root is the stiffest place itself, to half the digits.
    let slack = stiffest.abs() * Real::power_of_two(-80);
    slot("k_minus", &|k| !folded && *k <= &stiffest + &slack);
    slot("k_plus", &|k| folded || *k >= &stiffest - &slack);
    values.number("e2", &stiffest);
    values
}

/// `hard_3p`.
#[must_use]
pub fn hard_three(row: &Row) -> Values {
    let names = |names: [&str; 3]| names.map(|name| row.real(name));
    let linear = reduced(
        &[Real::one(), row.real("x2"), row.real("x3")],
        &names(["K1", "K2", "K3"]),
    );
    let theta = vec![Real::zero(), row.real("th2"), row.real("th3")];
    let phalanx = row.phalanx("phal");
    let lengths = names(["l1", "l2", "l3"]).to_vec();
    let scale = lengths[phalanx].clone();
    let (found, relative) = roots(
        &linear,
        posture_arms(lengths, theta, phalanx),
        &row.real("C"),
        &scale,
    );
    let usable: Vec<Real> = found
        .into_iter()
        .filter(|(k, physical)| *physical && k.is_positive())
        .map(|(k, _)| k)
        .collect();
    let mut values = Values::new();
    values.text("n_sol", usable.len());
    for (name, index) in [("k_a", 0), ("k_b", 1)] {
        match usable.get(index) {
            Some(k) => values.number(name, k),
            None => values.absent(name),
        }
    }
    values.number("disc_rel", &relative);
    values
}
