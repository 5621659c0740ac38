//! Compares the finger with reference values of an independent model (see the headers of the files).

use super::{Finger, Hold};
use crate::object::Body;
use crate::{FingerParameters, Parameters, Shape};
use std::collections::HashMap;

type Row = HashMap<String, f64>;

fn rows(file: &str) -> Vec<Row> {
    let path = format!(
        "{}/../../tests/data/golden/{file}",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = std::fs::read_to_string(path).expect("reference file");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().expect("header").split(',').collect();
    let row = |line: &str| {
        let values = line.split(',').map(|v| v.parse().unwrap_or(f64::NAN));
        names.iter().map(|n| (*n).to_owned()).zip(values).collect()
    };
    lines.map(row).collect()
}

fn finger(row: &Row) -> Finger {
    let list = |names: &[&str]| {
        names
            .iter()
            .filter_map(|n| row.get(*n).copied())
            .collect::<Vec<_>>()
    };
    let degrees = |names: &[&str]| {
        list(names)
            .into_iter()
            .map(f64::to_degrees)
            .collect::<Vec<_>>()
    };
    let length_m = list(&["l1", "l2", "l3"]);
    let count = length_m.len();
    let pulley_m = list(&["r1", "r2", "r3", "r4"]);
    let geometry = FingerParameters {
        hidden_base: false,
        spring_nm_per_rad: list(&["K1", "K2", "K3"]),
        rest_deg: degrees(&["th10", "th20", "th30"]),
        joint_min_deg: vec![-180.0; count],
        joint_max_deg: vec![180.0; count],
        travel_rad: 6.0,
        pulley_m,
        lever_m: list(&["a1", "a2"]),
        coupler_m: list(&["b1", "b2"]),
        driven_m: list(&["c1", "c2"]),
        offset_deg: degrees(&["psi1", "psi2"]),
        mode: list(&["mode1", "mode2"]),
        held_backlash_deg: Vec::new(),
        stated_mass_kg: Vec::new(),
        return_pulley_m: Vec::new(),
        return_tension_n: 0.0,
        return_n_per_m: 0.0,
        length_m,
    };
    let mut parameters = Parameters::default();
    parameters.mechanism.phalanx_half_thickness_m = 1e-4;
    parameters.contact.stiffness_n_per_m = 1e8;
    parameters.contact.friction = 0.0;
    parameters.finger = geometry;
    let mut finger = Finger::new(&parameters).expect("closes");
    finger.stopped = false;
    finger
}

/// Loads the finger from contact to a finite torque beyond; returns the relative error of the input link's motion.
fn motion_error(row: &Row) -> f64 {
    let mut finger = finger(row);
    let theta_1 = row["th1"];
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "2 or 3"
    )]
    let object = finger.met(
        row["phal"] as u8,
        row["k"],
        theta_1,
        &Shape::Cylinder { diameter_m: 0.0 },
    );
    let object = object.expect("on the finger");
    finger.angle[0] = theta_1;
    finger.transmit();
    finger.settle(&Body::Nothing, Hold::Torque(row["T_c"]));
    let before = finger.theta_a;
    for part in 1..=60 {
        finger.settle(
            &object,
            Hold::Torque(row["T_c"] + row["dT"] * f64::from(part) / 60.0),
        );
    }
    (finger.theta_a - before) / row["dtheta_a"] - 1.0
}

/// The penalty contact and the 0.1 mm phalanx leave a little more than rounding; next to e_2, where the finger hardly
/// moves at all, that little is a larger share: hence quantiles.
#[test]
fn loading_curves_are_the_references() {
    for file in [
        "contact_2T.csv",
        "contact_2L.csv",
        "contact_3T.csv",
        "contact_3L.csv",
    ] {
        let mut errors: Vec<f64> = rows(file)
            .iter()
            .map(|row| motion_error(row).abs())
            .collect();
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
        println!(
            "{file}: median {:.1e}, 95 % {:.1e}, 99 % {:.1e}, max {:.1e}",
            at(0.5),
            at(0.95),
            at(0.99),
            at(1.0)
        );
        assert!(
            at(0.5) < 1e-5 && at(0.95) < 1e-4 && at(0.99) < 1e-3,
            "{file}"
        );
    }
}

#[test]
fn four_bars_are_the_references() {
    for row in rows("fourbar.csv") {
        let fourbar = crate::linkage::Fourbar {
            ground: row["g"],
            lever: row["a"],
            coupler: row["b"],
            driven: row["c"],
            offset: row["psi"],
            mode: row["mode"],
        };
        let closed = fourbar.assemble(row["v"]);
        assert_eq!(closed.is_some(), row["x"].is_finite(), "{row:?}");
        if let (Some(gamma), Some(zero)) = (closed, fourbar.assemble(0.0)) {
            let (followed, slope) = fourbar.follow(gamma - 0.01, row["v"]);
            // Near a dead point the lever angle is as the root of the misfit.
            let tolerance = 1e-7 * (1.0 + row["dx"].abs());
            assert!((followed - gamma).abs() < tolerance, "{row:?}");
            assert!(
                (slope - row["x"]).abs() < tolerance * (1.0 + row["x"].abs()),
                "{slope} {row:?}"
            );
            let turned = (gamma - zero - row["F"]).rem_euclid(std::f64::consts::TAU);
            assert!(
                turned.min(std::f64::consts::TAU - turned) < tolerance,
                "{row:?}"
            );
        }
    }
}
