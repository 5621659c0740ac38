//! Rows of three phalanges.

use crate::files::Row;
use crate::reference::Finger;
use crate::{Case, agree, rounded};

struct Three {
    phalanx: u8,
    l: [f64; 3],
    theta2: f64,
    theta3: f64,
    x: [f64; 2],
    k1: f64,
    h: [f64; 3],
    c: f64,
}

impl Three {
    fn fields(&self) -> String {
        let Self {
            phalanx,
            l,
            theta2,
            theta3,
            x,
            k1,
            h,
            c,
        } = self;
        format!(
            "ThreePhalanges {{ phalanx: {phalanx}, l: {l:?}, theta2_rad: {theta2:?}, theta3_rad: {theta3:?}, cos2: {:?}, \
             cos3: {:?}, cos23: {:?}, x2: {:?}, x3: {:?}, stiffness1: {k1:?}, h22: {:?}, h23: {:?}, h33: {:?}, \
             compliance: {c:?} }}",
            theta2.cos() as f32,
            theta3.cos() as f32,
            (theta2 + theta3).cos() as f32,
            x[0],
            x[1],
            h[0],
            h[1],
            h[2],
        )
    }

    fn places(&self) -> Vec<f64> {
        let Self {
            l,
            theta2,
            theta3,
            x,
            k1,
            h,
            ..
        } = self;
        let (d, e) = if self.phalanx == 2 {
            ([l[0] * theta2.cos(), 0.0, 0.0], [1.0, 1.0, 0.0])
        } else {
            let near = l[1] * theta3.cos();
            ([near + l[0] * (theta2 + theta3).cos(), near, 0.0], [1.0; 3])
        };
        Finger {
            d,
            e,
            x: [1.0, x[0], x[1]],
            h: [[*k1, 0.0, 0.0], [0.0, h[0], h[1]], [0.0, h[1], h[2]]],
        }
        .places(self.c)
    }

    fn length(&self) -> f64 {
        self.l[usize::from(self.phalanx) - 1]
    }
}

/// A hard row.
pub fn three_hard(row: &Row) -> Option<Case> {
    let [k1, k2, k3] = row.numbers(["K1", "K2", "K3"]);
    let finger = Three {
        phalanx: row.number("phal") as u8,
        l: row.numbers(["l1", "l2", "l3"]),
        theta2: row.number("th2"),
        theta3: row.number("th3"),
        x: row.numbers(["x2", "x3"]),
        k1,
        h: [k2, 0.0, k3],
        c: row.number("C"),
    };
    let places: Vec<f64> = row
        .numbers(["k_a", "k_b"])
        .into_iter()
        .filter(|k| k.is_finite())
        .collect();
    let found = finger.places();
    for &k in &places {
        agree("hard_3p", &found, k, k.max(finger.length()), 1e-6);
    }
    Case::new(finger.fields(), &places, finger.length(), true)
}

/// A random row.
pub fn three_random(row: &Row) -> Option<Case> {
    let phalanx = row.number("phal") as u8;
    if phalanx < 2 || row.number("df_dT") <= 0.0 {
        return None;
    }
    let [k2, k3, g22, g23, g33] = row.numbers(["K2", "K3", "g22", "g23", "g33"]);
    let finger = Three {
        phalanx,
        l: row.numbers(["l1", "l2", "l3"]),
        theta2: rounded(row.number("th2")),
        theta3: rounded(row.number("th3")),
        x: row.numbers(["x2", "x3"]).map(rounded),
        k1: row.number("K1"),
        h: [k2 - g22, -g23, k3 - g33].map(rounded),
        c: rounded(row.number("C")),
    };
    let places = finger.places();
    // Near a turn of the compliance the rounding of the data moves the root, or takes it away: not a row to judge by.
    let wanted = row.number("k");
    let near = |k: &f64| (k - wanted).abs() < 1e-3 * finger.length();
    if !places.iter().any(near) {
        return None;
    }
    Case::new(finger.fields(), &places, finger.length(), false)
}
