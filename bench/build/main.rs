//! Turns the reference files into the rows that candidates are judged on, and a part of them into the rows that the chip
//! times. See `rows.rs`.

mod files;
mod reference;
mod three;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use files::{Row, Table};
use reference::Finger;
use three::{three_hard, three_random};

/// Roots this near to the end of the phalanx are left out: rounding decides on which side they fall.
const END: f64 = 2e-3;

/// A row as Rust source: reduced data, roots on the phalanx, whether it is a hard case.
struct Case {
    fields: String,
    roots: Vec<f64>,
    hard: bool,
}

impl Case {
    /// Keeps a row whose roots are clearly on or clearly off the phalanx, and not twice the same.
    fn new(fields: String, places: &[f64], length: f64, hard: bool) -> Option<Self> {
        let edge = |k: &f64| (k / length - 1.0).abs() < END;
        if places.iter().any(edge) {
            return None;
        }
        let roots: Vec<f64> = places
            .iter()
            .copied()
            .filter(|&k| k > 0.0 && k < length)
            .collect();
        Some(Self {
            fields,
            roots,
            hard,
        })
    }
}

fn rounded(x: f64) -> f64 {
    f64::from(x as f32)
}

/// Fails the build where the f64 reference and a 50-digit file disagree by more than rounding explains.
fn agree(what: &str, found: &[f64], wanted: f64, length: f64, tolerance: f64) {
    let nearest = found
        .iter()
        .map(|k| (k - wanted).abs())
        .fold(f64::INFINITY, f64::min);
    assert!(
        nearest <= tolerance * length,
        "{what}: the reference file has k = {wanted}, the f64 reference {found:?}"
    );
}

/// Reduced data of two phalanges, f32-exact but for the cosine.
fn two(l1: f64, l2: f64, theta2: f64, x2: f64, k1: f64, k2: f64, c: f64) -> (String, Finger) {
    let fields = format!(
        "TwoPhalanges {{ l1: {l1:?}, l2: {l2:?}, theta2_rad: {theta2:?}, cos2: {:?}, x2: {x2:?}, stiffness1: {k1:?}, \
         stiffness2: {k2:?}, compliance: {c:?} }}",
        theta2.cos() as f32
    );
    let finger = Finger {
        d: [l1 * theta2.cos(), 0.0, 0.0],
        e: [1.0, 1.0, 0.0],
        x: [1.0, x2, 0.0],
        h: [[k1, 0.0, 0.0], [0.0, k2, 0.0], [0.0, 0.0, 1.0]],
    };
    (fields, finger)
}

fn two_hard(row: &Row) -> Option<Case> {
    let [l1, l2, theta2, x2, k1, k2, c] = row.numbers(["l1", "l2", "th2", "x2", "K1", "K2p", "C"]);
    let (fields, finger) = two(l1, l2, theta2, x2, k1, k2, c);
    let mut places: Vec<f64> = row
        .numbers(["k_minus", "k_plus"])
        .into_iter()
        .filter(|k| k.is_finite())
        .collect();
    let found = finger.places(c);
    for &k in &places {
        // Where C = 0 both roots are e_2 and the quadratic has lost half its digits.
        agree(
            "hard_2p",
            &found,
            k,
            k.max(l2),
            if c == 0.0 { 1e-6 } else { 1e-9 },
        );
    }
    places.dedup();
    Case::new(fields, &places, l2, true)
}

fn two_random(row: &Row) -> Option<Case> {
    if row.number("phal") != 2.0 || row.number("df_dT") <= 0.0 {
        return None;
    }
    let [l1, l2, theta2, x2, k1, k2, g22, c] = row
        .numbers(["l1", "l2", "th2", "x2", "K1", "K2", "g22", "C"])
        .map(|x| x);
    let [theta2, x2, k2, c] = [theta2, x2, k2 - g22, c].map(rounded);
    let (fields, finger) = two(l1, l2, theta2, x2, k1, k2, c);
    let places = finger.places(c);
    agree("kc_2", &places, row.number("k"), l2, 1e-4);
    Case::new(fields, &places, l2, false)
}

/// Reference rows for a PC, `timed` of the random and of the hard ones for the chip.
fn emit(out: &mut String, name: &str, kind: &str, cases: &[Case], timed: usize) {
    let _ = writeln!(
        out,
        "/// What results are judged by.\n#[cfg(not(target_os = \"none\"))]\npub static {name}: &[Reference<{kind}>] = &["
    );
    for case in cases {
        let root = |at: usize| {
            case.roots
                .get(at)
                .map_or("f64::NAN".to_owned(), |k| format!("{k:?}"))
        };
        let _ = writeln!(
            out,
            "Reference {{ input: {}, roots: [{}, {}], hard: {} }},",
            case.fields,
            root(0),
            root(1),
            case.hard
        );
    }
    let _ = writeln!(
        out,
        "];\n/// The part of them that the chip times.\npub static {name}_TIMED: &[{kind}] = &["
    );
    for hard in [false, true] {
        let half: Vec<&Case> = cases.iter().filter(|case| case.hard == hard).collect();
        for at in 0..timed.min(half.len()) {
            let _ = writeln!(
                out,
                "{},",
                half[at * half.len() / timed.min(half.len())].fields
            );
        }
    }
    let _ = writeln!(out, "];");
}

/// A file of finite steps: the rows' name and type, columns of the finger.
struct Steps<'a> {
    file: &'a str,
    name: &'a str,
    kind: &'a str,
    phalanges: usize,
    /// How many of them the chip times: their fingers must fit its memory.
    timed: usize,
}

/// Rows of the files of finite steps, contact beyond phalanx 1, and the place at first contact.
fn steps(out: &mut String, folder: &Path, of: &Steps) {
    let Steps {
        name, kind, timed, ..
    } = of;
    let table = Table::read(&folder.join(of.file));
    let rows: Vec<(String, f64)> = table
        .rows()
        .filter(|row| row.number("phal") > 1.0)
        .map(|row| {
            let list = |columns: &[String]| {
                let numbers: Vec<String> = columns.iter().map(|name| format!("{:?}", row.number(name))).collect();
                format!("[{}]", numbers.join(", "))
            };
            let each = |prefix: &str, suffix: &str| -> String {
                let columns: Vec<String> = (1..=of.phalanges).map(|i| format!("{prefix}{i}{suffix}")).collect();
                list(&columns)
            };
            // The joints' stops are as near as the row's postures allow.
            let ranges: Vec<String> = (1..=of.phalanges)
                .map(|i| {
                    let angles = ["0", "", "_after"].map(|suffix| row.number(&format!("th{i}{suffix}")));
                    let [least, most] = angles.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], angle| {
                        [a.min(*angle), b.max(*angle)]
                    });
                    format!("[{:?}, {:?}]", (least - 1e-3) as f32, (most + 1e-3) as f32)
                })
                .collect();
            let stages: Vec<String> = (1..of.phalanges)
                .map(|stage| list(&["a", "b", "c", "psi", "mode"].map(|name| format!("{name}{stage}"))))
                .collect();
            let fields = format!(
                "{kind} {{ phalanx: {}, l: {}, stiffness: {}, rest_rad: {}, theta_rad: {}, range_rad: [{}], design: [{}], rise: Rise {{ \
                 torque: {:?}, rise: {:?}, rotation_rad: {:?}, half_rotation_rad: {:?} }} }}",
                row.number("phal"),
                each("l", ""),
                each("K", ""),
                each("th", "0"),
                each("th", ""),
                ranges.join(", "),
                stages.join(", "),
                row.number("T_c"),
                row.number("dT"),
                row.number("dtheta_a") as f32,
                row.number("dtheta_a_half") as f32,
            );
            (fields, row.number("k"))
        })
        .collect();
    let _ = writeln!(
        out,
        "/// Steps and the places that they came from.\n#[cfg(not(target_os = \"none\"))]"
    );
    let _ = writeln!(out, "pub static {name}: &[({kind}, f64)] = &[");
    for (fields, k) in &rows {
        let _ = writeln!(out, "({fields}, {k:?}),");
    }
    let _ = writeln!(
        out,
        "];\n/// The part of them that the chip times.\npub static {name}_TIMED: [{kind}; {timed}] = ["
    );
    for at in 0..*timed {
        let _ = writeln!(out, "{},", rows[at * rows.len() / timed].0);
    }
    let _ = writeln!(out, "];");
}

/// Turns a row of a file into a case, or leaves it out.
type Reader = fn(&Row) -> Option<Case>;

fn gather(folder: &Path, sources: &[(&str, Reader)]) -> Vec<Case> {
    sources
        .iter()
        .flat_map(|(file, case)| {
            let table = Table::read(&folder.join(file));
            table
                .rows()
                .filter_map(|row| case(&row))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Arguments of the functions: numbers over 40 octaves, points all round, angles within a turn with the last sample's.
fn functions(out: &mut String, count: u32) {
    // Weyl sequences: evenly spread, nothing random about them.
    let spread = |at: u32, step: f64| (f64::from(at) + 0.5) * step % 1.0;
    let mut list = |name: &str, kind: &str, row: &dyn Fn(f64, f64) -> String| {
        let rows: Vec<String> = (0..count)
            .map(|at| {
                row(
                    spread(at, 0.618_033_988_749_895),
                    spread(at, 0.754_877_666_246_693),
                )
            })
            .collect();
        let _ = writeln!(
            out,
            "/// Arguments.\npub static {name}: &[{kind}] = &[{}];",
            rows.join(", ")
        );
    };
    list("NUMBERS_TIMED", "f32", &|u, _| {
        format!("{:?}", (40.0 * u - 20.0).exp2() as f32)
    });
    list("POINTS_TIMED", "[f32; 2]", &|u, v| {
        let (angle, length) = (std::f64::consts::TAU * (u - 0.5), (10.0 * v - 5.0).exp2());
        format!(
            "[{:?}, {:?}]",
            (length * angle.sin()) as f32,
            (length * angle.cos()) as f32
        )
    });
    list("EQUATIONS_TIMED", "Equations", &|u, v| {
        // M M^T plus a share of the unit matrix: positive definite.
        let m: [[f64; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| ((3 * i + j) as f64 * 0.7 + 7.0 * u + 11.0 * v).sin())
        });
        let a: [[f32; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let product: f64 = (0..3).map(|k| m[i][k] * m[j][k]).sum();
                (product + if i == j { 0.1 + v } else { 0.0 }) as f32
            })
        });
        format!(
            "Equations {{ a: {a:?}, b: [{:?}, {:?}, 1.0] }}",
            (2.0 * u - 1.0) as f32,
            (2.0 * v - 1.0) as f32
        )
    });
    list("ANGLES_TIMED", "Angle", &|u, v| {
        let (rad, step) = (
            (std::f64::consts::TAU * (u - 0.5)) as f32,
            (0.04 * (v - 0.5)) as f32,
        );
        let last = f64::from(rad) - f64::from(step);
        format!(
            "Angle {{ rad: {rad:?}, last_cos: {:?}, last_sin: {:?}, step_rad: {step:?} }}",
            last.cos() as f32,
            last.sin() as f32
        )
    });
}

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out_dir = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    let folder = root.join("../tests/data/golden");
    println!("cargo:rerun-if-changed={}", folder.display());
    println!("cargo:rerun-if-changed=build");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        // See memory.x: the bench keeps no records and has no tasks; its candidates need the room.
        println!("cargo:rustc-link-arg-bins=--defsym=_bench=1");
    }
    let mut out = String::new();
    let cases = gather(
        &folder,
        &[
            ("kc_2T.csv", two_random),
            ("kc_2L.csv", two_random),
            ("hard_2p.csv", two_hard),
        ],
    );
    emit(&mut out, "TWO", "TwoPhalanges", &cases, 32);
    let cases = gather(
        &folder,
        &[
            ("kc_3T.csv", three_random),
            ("kc_3L.csv", three_random),
            ("hard_3p.csv", three_hard),
        ],
    );
    emit(&mut out, "THREE", "ThreePhalanges", &cases, 32);
    functions(&mut out, 48);
    for file in [
        Steps {
            file: "contact_2L.csv",
            name: "TWO_STEPS",
            kind: "TwoRow",
            phalanges: 2,
            timed: 24,
        },
        Steps {
            file: "contact_3L.csv",
            name: "THREE_STEPS",
            kind: "ThreeRow",
            phalanges: 3,
            timed: 12,
        },
    ] {
        steps(&mut out, &folder, &file);
    }
    std::fs::write(out_dir.join("rows.rs"), out).expect("the rows can be written");
}
