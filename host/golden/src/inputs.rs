//! Random inputs of new reference files: fingers of any number of phalanges with their contacts.

use crate::equilibrium::{Contact, free, pressed};
use crate::family;
use crate::table::{Row, Table};
use crate::value::{Value, joint_names};

/// Inputs are drawn from here: the same file each time (splitmix64).
struct Draw(u64);

impl Draw {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Within a range, exact in f32.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        let share = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        f64::from((low + (high - low) * share) as f32)
    }
}

/// Cells of a row by name, inputs first.
type Cells = Vec<(String, String)>;

fn number(value: f64) -> String {
    Value::Number(value).written()
}

/// Lengths, springs, rest angles and transmission; every fourth finger has no spring at joint 1.
fn finger(draw: &mut Draw, joints: usize, has_linkage: bool, index: usize) -> Cells {
    let mut cells = Cells::new();
    let mut lengths = Vec::new();
    for (name, _) in joint_names("l", "").zip(0..joints) {
        lengths.push(draw.within(0.4, 1.2));
        cells.push((name, number(lengths[lengths.len() - 1])));
    }
    for (joint, name) in joint_names("K", "").take(joints).enumerate() {
        let spring = draw.within(0.4, 2.0);
        let is_springless = joint == 0 && index % 4 == 3;
        cells.push((name, number(if is_springless { 0.0 } else { spring })));
    }
    for name in joint_names("th", "0").take(joints) {
        cells.push((name, number(draw.within(0.05, 0.4))));
    }
    for stage in 1..joints {
        if has_linkage {
            let ground = lengths[stage - 1];
            for (name, low, high) in [("a", 0.55, 0.75), ("b", 1.08, 1.2), ("c", 0.28, 0.36)] {
                let share = draw.within(low, high);
                cells.push((
                    format!("{name}{stage}"),
                    number(f64::from((share * ground) as f32)),
                ));
            }
            cells.push((format!("psi{stage}"), number(draw.within(1.95, 2.2))));
            cells.push((format!("mode{stage}"), "-1".to_owned()));
        } else {
            let ratio = draw.within(0.55, 0.95);
            cells.push((format!("r{}", 2 * stage - 1), number(f64::from(0.1f32))));
            cells.push((
                format!("r{}", 2 * stage),
                number(f64::from(0.1 * ratio as f32)),
            ));
        }
    }
    cells
}

/// Adds the torque and the joint angles; those of a finger without a spring at joint 1 are inputs.
fn posture(draw: &mut Draw, cells: &mut Cells, joints: usize, torque: &str) {
    let is_springless = cells
        .iter()
        .any(|(name, cell)| name == "K1" && cell == "0.0");
    let value = if is_springless {
        0.0
    } else {
        draw.within(0.0, 0.5)
    };
    cells.push((torque.to_owned(), number(value)));
    for joint in 1..=joints {
        cells.push((format!("th{joint}"), number(draw.within(0.1, 0.8))));
    }
}

fn row(cells: &Cells) -> Row<'_> {
    Row::of(
        cells
            .iter()
            .map(|(name, cell)| (name.as_str(), cell.as_str())),
    )
}

/// The finger can be built and has a posture at its torque.
fn stands(cells: &Cells, torque: &str) -> bool {
    let row = row(cells);
    let finger = row.finger();
    let mut near = finger.rest.clone();
    if finger.springs[0].is_zero() {
        near[0] = row.real("th1");
    }
    free(&finger, &row.real(torque), &near).is_some_and(|theta| !finger.theta_a(&theta).is_nan())
}

fn f64_of(cells: &Cells, name: &str) -> f64 {
    row(cells).f64(name)
}

/// A contact on any phalanx of `from` on.
fn contact(draw: &mut Draw, cells: &mut Cells, joints: usize, from: usize) {
    let phalanx = from + (draw.bits() % (joints - from + 1) as u64) as usize;
    let length = f64_of(cells, &format!("l{phalanx}"));
    let k = f64::from((draw.within(0.06, 0.94) * length) as f32);
    cells.push(("phal".to_owned(), phalanx.to_string()));
    cells.push(("k".to_owned(), number(k)));
}

/// Recomputes the outputs and puts them behind the inputs, joint angles in their place.
fn completed(kind: &str, mut cells: Cells) -> Option<Cells> {
    let outputs = family(kind)?(&row(&cells));
    for (name, value) in outputs.iter() {
        let text = value.written();
        match cells.iter_mut().find(|(column, _)| column == name) {
            Some((_, cell)) => *cell = text,
            None => cells.push((name.to_owned(), text)),
        }
    }
    Some(cells)
}

/// A place too near to a phalanx's end, to another one or to a proximal contact for a number of 24 bits to be judged by.
fn is_delicate(cells: &Cells) -> bool {
    let proximal = f64_of(cells, "C_proximal");
    if (f64_of(cells, "C_meas") / proximal - 1.0).abs() < 0.003 {
        return true;
    }
    let places = ('a'..='j').filter_map(|slot| {
        let phalanx = f64_of(cells, &format!("phal_{slot}")) as usize;
        let length = (phalanx > 0).then(|| f64_of(cells, &format!("l{phalanx}")))?;
        Some((phalanx, f64_of(cells, &format!("k_{slot}")) / length))
    });
    let places: Vec<(usize, f64)> = places.collect();
    let ends = places
        .iter()
        .any(|(_, share)| !(0.01..=0.99).contains(share));
    let twins = places
        .windows(2)
        .any(|pair| pair[0].0 == pair[1].0 && pair[1].1 - pair[0].1 < 0.1);
    ends || twins
}

/// The contact presses and stays on its phalanx while the torque rises.
fn presses_on(cells: &Cells) -> bool {
    let row = row(cells);
    let (finger, torque) = (row.finger(), row.real("T_c"));
    let theta = crate::forward::posture(&row, &finger, &torque);
    let (phalanx, k) = (row.phalanx("phal"), row.real("k"));
    let point = finger.point(&theta, phalanx, &k);
    let contact = Contact { phalanx, point };
    pressed(&finger, &torque, &row.real("dT"), &contact, &theta).is_some_and(|after| {
        let place = finger.seen_from(&after.theta, phalanx, &contact.point).0;
        let length = &finger.lengths[phalanx];
        after.force.is_positive() && place.is_positive() && place < *length
    })
}

/// A finger with a motor at every joint, in contact.
fn drawn_actuated(draw: &mut Draw, joints: usize) -> Option<Cells> {
    let mut cells = finger(draw, joints, false, 0);
    cells.retain(|(name, _)| !name.starts_with('r'));
    for name in joint_names("t", "").take(joints) {
        cells.push((name, number(draw.within(0.0, 0.5))));
    }
    contact(draw, &mut cells, joints, 1);
    completed("actuated_", cells)
}

/// One row of a kind, or nothing where the drawn finger has none.
fn drawn(
    draw: &mut Draw,
    kind: &str,
    joints: usize,
    has_linkage: bool,
    index: usize,
) -> Option<Cells> {
    if kind.starts_with("actuated") {
        return drawn_actuated(draw, joints);
    }
    // The free finger's stiffness is not defined without a spring at joint 1.
    let spring = if kind.starts_with("preshape") {
        0
    } else {
        index
    };
    let mut cells = finger(draw, joints, has_linkage, spring);
    let torque = if kind.starts_with("preshape") {
        "T_a"
    } else {
        "T_c"
    };
    posture(draw, &mut cells, joints, torque);
    if !stands(&cells, torque) {
        return None;
    }
    if kind.starts_with("kc") {
        contact(draw, &mut cells, joints, 1);
    } else if kind.starts_with("contact") || kind.starts_with("second") {
        contact(draw, &mut cells, joints, 1);
        cells.push(("dT".to_owned(), number(draw.within(0.02, 0.2))));
        if !presses_on(&cells) {
            return None;
        }
        if kind.starts_with("second") {
            let first = f64_of(&cells, "phal") as usize;
            let mut other = 1 + (draw.bits() % (joints as u64 - 1)) as usize;
            other += usize::from(other >= first);
            let length = f64_of(&cells, &format!("l{other}"));
            let place = f64::from((draw.within(0.06, 0.94) * length) as f32);
            cells.push(("phal_b".to_owned(), other.to_string()));
            cells.push(("k_b".to_owned(), number(place)));
        }
    } else if kind.starts_with("inverse") {
        // The compliance of a contact somewhere; of every sixth, one that may have no place.
        let mut there = cells.clone();
        contact(draw, &mut there, joints, 2);
        let there = completed("kc_", there)?;
        let factor = if index % 6 == 5 {
            draw.within(0.02, 8.0)
        } else {
            1.0
        };
        let measured = f64::from((f64_of(&there, "C") * factor) as f32);
        cells.push(("C_meas".to_owned(), number(measured)));
        cells.push(("phal_e".to_owned(), "0".to_owned()));
    }
    let cells = completed(kind, cells)?;
    let is_refused = kind.starts_with("inverse") && is_delicate(&cells);
    (!is_refused).then_some(cells)
}

/// What the head of a new file says.
fn comments(kind: &str) -> Vec<String> {
    let lines: &[&str] = match kind {
        "second" => &[
            "# A second contact after a first: finger, T_c, phal, k, dT as in contact_3L. At T_c + dT another phalanx, phal_b,",
            "# touches at k_b. th_after, k_after and f are the posture, the place and the force of the first contact there,",
            "# C_first the compliance with it alone, C_second with both, at the instant of the second contact; df_b_dT < 0 where",
            "# the phalanx would move away from the place.",
        ],
        "actuated" => &[
            "# A motor at every joint, behind a spring K_i: torques t_i, posture th_i, contact on phal at k. C_i: change of",
            "# theta_i for a unit of t_i while the other motors keep their torques.",
        ],
        _ => &[
            "# Random fingers of more than three phalanges; columns and conventions as in the file of this kind for three.",
            "# Stage j drives phalanx j + 1 and sees theta_(j+1) + F_(j+1)(...), the rotation of the lever beyond.",
        ],
    };
    lines.iter().map(|line| (*line).to_owned()).collect()
}

/// A new file: its name says what (`kc_`, `inverse_`, `contact_`, `preshape_`), how many phalanges, and `T` or `L` for
/// tendon or linkage, as `kc_4L` does.
///
/// # Errors
/// A name of another form.
pub fn table(name: &str, rows: usize) -> Result<Table, String> {
    let wrong = || {
        format!(
            "{name}: not kc_, inverse_, contact_, preshape_, second_ or actuated_ with 2 to 6 and T or L"
        )
    };
    let (kind, finger) = name.split_once('_').ok_or_else(wrong)?;
    let known = ["kc", "inverse", "contact", "preshape", "second", "actuated"].contains(&kind);
    let (joints, has_linkage) = match finger.as_bytes() {
        [joints @ b'2'..=b'6', b'T'] => (usize::from(joints - b'0'), false),
        [joints @ b'2'..=b'6', b'L'] => (usize::from(joints - b'0'), true),
        _ => return Err(wrong()),
    };
    if !known {
        return Err(wrong());
    }
    let mut draw = Draw(
        name.bytes()
            .fold(0, |seed, byte| seed * 256 + u64::from(byte)),
    );
    let mut cells: Vec<Cells> = Vec::new();
    while cells.len() < rows {
        let index = cells.len();
        cells.extend(drawn(
            &mut draw,
            &format!("{kind}_"),
            joints,
            has_linkage,
            index,
        ));
    }
    let columns = cells.first().map_or_else(Vec::new, |row| {
        row.iter().map(|(name, _)| name.clone()).collect()
    });
    Ok(Table {
        name: name.to_owned(),
        comments: comments(kind),
        rows: cells
            .into_iter()
            .map(|row| row.into_iter().map(|(_, cell)| cell).collect())
            .collect(),
        columns,
    })
}
