//! The paper's Figs 4 to 7: the library in f32 (symbols) over an independent evaluation in f64 (lines).

use std::path::Path;

use palpate::finger::{Contact, Finger, Mechanics, Parameters, Tendon};

use crate::reference::{self, contact_curve, free_posture, tangent_compliance};
use palpate_document::chart::{
    AMBER, BLUE, Chart, DrawError, GREEN, GREY, Legend, Mark, ORANGE, SKY, Series, write,
};

/// Places on a phalanx at which the f64 lines are computed.
const LINE_POINTS: u32 = 160;
/// Places at which the library is asked.
const SYMBOLS: u32 = 16;

/// The library's finger of Table I's kind: pulleys of Table I on phalanges of these lengths.
fn tendon_2(finger: &reference::Finger) -> Result<Finger<2, Tendon<2>>, DrawError> {
    let parameters = Parameters {
        lengths_m: [finger.lengths[0] as f32, finger.lengths[1] as f32],
        stiffness_nm_per_rad: [finger.springs[0] as f32, finger.springs[1] as f32],
        rest_rad: [finger.rest_rad[0] as f32; 2],
        range_rad: [[-3.0, 3.0]; 2],
    };
    Finger::new(parameters, [0.10, 0.08]).map_err(|error| format!("{error:?}").into())
}

/// The same with three phalanges.
fn tendon_3(finger: &reference::Finger) -> Result<Finger<3, Tendon<3>>, DrawError> {
    let three = |values: &[f64]| [values[0] as f32, values[1] as f32, values[2] as f32];
    let parameters = Parameters {
        lengths_m: three(&finger.lengths),
        stiffness_nm_per_rad: three(&finger.springs),
        rest_rad: three(&finger.rest_rad),
        range_rad: [[-3.0, 3.0]; 3],
    };
    Finger::new(parameters, [0.10, 0.08, 0.06, 0.04]).map_err(|error| format!("{error:?}").into())
}

/// K_c of the library along one phalanx, x from `axis(k)`.
fn library_curve<F: Mechanics>(
    finger: &F,
    torque: f64,
    phalanx: u8,
    axis: impl Fn(f64) -> f64,
) -> Vec<(f64, f64)> {
    let (Some(at), Some(length)) = (
        finger.free_at_torque(torque as f32, &finger.rest()),
        finger.phalanx_length_m(phalanx),
    ) else {
        return Vec::new();
    };
    (1..=SYMBOLS)
        .filter_map(|step| {
            let k = length * (step as f32 - 0.5) / SYMBOLS as f32;
            let compliance = finger.contact_compliance(&at, torque as f32, phalanx, k)?;
            Some((axis(f64::from(k)), f64::from(1.0 / compliance)))
        })
        .collect()
}

/// K_c of the independent evaluation along one phalanx.
fn reference_curve(
    finger: &reference::Finger,
    torque: f64,
    phalanx: usize,
    axis: impl Fn(f64) -> f64,
) -> Vec<(f64, f64)> {
    let Some(posture) = free_posture(finger, torque) else {
        return Vec::new();
    };
    (0..=LINE_POINTS)
        .filter_map(|step| {
            let share = (f64::from(step) + 0.02) / (f64::from(LINE_POINTS) + 0.02);
            let k = finger.lengths[phalanx - 1] * share;
            let compliance = tangent_compliance(finger, &posture, torque, phalanx, k)?;
            Some((axis(k), 1.0 / compliance))
        })
        .collect()
}

/// Where the library and the f64 evaluation differ most, relative, along one phalanx.
fn largest_difference<F: Mechanics>(
    library: &F,
    reference: &reference::Finger,
    torque: f64,
    phalanx: u8,
) -> f64 {
    let Some(posture) = free_posture(reference, torque) else {
        return f64::NAN;
    };
    library_curve(library, torque, phalanx, |k| k)
        .into_iter()
        .filter_map(|(k, stiffness)| {
            let compliance =
                tangent_compliance(reference, &posture, torque, usize::from(phalanx), k)?;
            Some((stiffness * compliance - 1.0).abs())
        })
        .fold(0.0, f64::max)
}

/// Fig 4: global stiffness K_a while closing, free and after contacts along each phalanx.
fn figure_4() -> Result<Chart, DrawError> {
    let finger = reference::table_1();
    let library = tendon_3(&finger)?;
    let (contact_torque, last) = (0.3, 1.0);
    let mut series = vec![Series::new(
        "free, f64",
        GREY,
        Mark::Line,
        (1..=40)
            .filter_map(|step| {
                let torque = f64::from(step) * last / 40.0;
                let posture = free_posture(&finger, torque)?;
                let rest = nalgebra::DVector::from_vec(finger.rest_rad.clone());
                Some((
                    torque,
                    torque / (finger.theta_a(&posture) - finger.theta_a(&rest)),
                ))
            })
            .collect(),
    )];
    let looks = [(1_u8, GREEN, 1), (2, BLUE, 4), (3, ORANGE, 4)];
    for (phalanx, colour, places) in looks {
        let name = ["proximal", "intermediate", "distal"][usize::from(phalanx) - 1];
        for place in 1..=places {
            let share = if places == 1 {
                0.5
            } else {
                f64::from(place) / f64::from(places)
            };
            let k = share * finger.lengths[usize::from(phalanx) - 1];
            let curve = contact_curve(&finger, contact_torque, usize::from(phalanx), k, last, 60);
            let points = curve
                .iter()
                .map(|p| (p.torque, p.torque / p.theta_a_rad))
                .collect();
            let first = |text: String| if place == 1 { text } else { String::new() };
            series.push(Series::new(
                first(format!("contact on the {name} phalanx, f64")),
                colour,
                Mark::Line,
                points,
            ));
            series.push(Series::new(
                first("the same, library in f32".to_owned()),
                colour,
                Mark::Rings,
                library_closure(&library, contact_torque, phalanx, k, last),
            ));
        }
    }
    Ok(Chart {
        title: "Fig 4: stiffness with and without contact, Table I, contact at T_a = 0.3".into(),
        x_label: "input torque T_a / K".into(),
        y_label: "global stiffness K_a / K".into(),
        x: (0.0, 1.02),
        y: (0.4, 1.8),
        log_y: false,
        legend: Legend::UpperLeft,
        series,
    })
}

/// K_a of the library along a contact path.
fn library_closure<F: Mechanics>(
    finger: &F,
    contact_torque: f64,
    phalanx: u8,
    k: f64,
    last: f64,
) -> Vec<(f64, f64)> {
    let contact = Contact {
        phalanx,
        k_m: k as f32,
        radius_m: 0.0,
    };
    let rest = finger.rest();
    let (Some(at), mut points) = (
        finger.free_at_torque(contact_torque as f32, &rest),
        Vec::new(),
    ) else {
        return Vec::new();
    };
    let turned = finger.input_angle_rad(&at) - finger.input_angle_rad(&rest);
    let Some(mut path) = finger.path(&at, contact_torque as f32, contact) else {
        return points;
    };
    for step in 0..=7 {
        let torque = contact_torque + f64::from(step) * (last - contact_torque) / 7.0;
        let Some(point) = finger.follow(&mut path, (torque - contact_torque) as f32) else {
            break;
        };
        points.push((torque, torque / f64::from(turned + point.rotation_rad)));
    }
    points
}

/// Fig 5: K_c of the two-phalanx tendon finger for springs of several stiffnesses.
fn figure_5() -> Result<Chart, DrawError> {
    let torque = 0.3;
    let mut series = Vec::new();
    let colours = [SKY, BLUE, GREEN, AMBER, ORANGE];
    for (spring, colour) in [0.5, 1.0, 2.0, 4.0, 8.0].into_iter().zip(colours) {
        let mut finger = reference::table_1_two_phalanges();
        finger.springs = vec![spring; 2];
        let library = tendon_2(&finger)?;
        let equilibrium = library
            .free_at_torque(torque as f32, &library.rest())
            .and_then(|at| library.stiffest_m(&at, torque as f32, 2))
            .ok_or("Table I has an equilibrium point")?;
        let axis = |k: f64| k / f64::from(equilibrium);
        series.push(Series::new(
            format!("K_1 = K_2 = {spring}, f64"),
            colour,
            Mark::Line,
            reference_curve(&finger, torque, 2, axis),
        ));
        series.push(Series::new(
            if spring < 0.6 { "library in f32" } else { "" },
            if spring < 0.6 { GREY } else { colour },
            Mark::Rings,
            library_curve(&library, torque, 2, axis),
        ));
    }
    Ok(Chart {
        title: "Fig 5: K_c of the two-phalanx tendon finger, Table I, T_a = 0.3".into(),
        x_label: "contact location k_2 / e_2".into(),
        y_label: "stiffness after contact K_c".into(),
        x: (0.0, 0.36),
        y: (1.0, 100.0),
        log_y: true,
        legend: Legend::LowerRight,
        series,
    })
}

/// Fig 6: K_c of the three-phalanx finger for several K_2.
fn figure_6() -> Result<Vec<Chart>, DrawError> {
    let torque = 0.3;
    let mut charts = Vec::new();
    for phalanx in [2_u8, 3] {
        let mut series = Vec::new();
        let length = reference::table_1().lengths[usize::from(phalanx) - 1];
        let colours = [SKY, BLUE, GREEN, AMBER, ORANGE];
        for (spring, colour) in [0.2, 0.5, 1.0, 2.0, 5.0].into_iter().zip(colours) {
            let mut finger = reference::table_1();
            finger.springs[1] = spring;
            let library = tendon_3(&finger)?;
            let axis = |k: f64| k / length;
            series.push(Series::new(
                format!("K_2 = {spring}, f64"),
                colour,
                Mark::Line,
                reference_curve(&finger, torque, usize::from(phalanx), axis),
            ));
            series.push(Series::new(
                if spring < 0.3 { "library in f32" } else { "" },
                if spring < 0.3 { GREY } else { colour },
                Mark::Rings,
                library_curve(&library, torque, phalanx, axis),
            ));
        }
        charts.push(Chart {
            title: format!("Fig 6: K_c, contact on phalanx {phalanx}, Table I, T_a = 0.3"),
            x_label: format!("contact location k_{phalanx} / l_{phalanx}"),
            y_label: "stiffness after contact K_c".into(),
            x: (0.0, 1.0),
            y: if phalanx == 2 {
                (0.3, 5.0)
            } else {
                (0.5, 60.0)
            },
            log_y: true,
            legend: if phalanx == 2 {
                Legend::LowerRight
            } else {
                Legend::UpperLeft
            },
            series,
        });
    }
    Ok(charts)
}

/// Fig 7: two designs, the oversized one with a peak on each phalanx.
fn figure_7() -> Result<Chart, DrawError> {
    let torque = 0.3;
    let mut series = Vec::new();
    for (finger, name, colour) in [
        (reference::table_1(), "Table I", BLUE),
        (reference::oversized(), "oversized", ORANGE),
    ] {
        let library = tendon_3(&finger)?;
        for phalanx in [2_u8, 3] {
            let length = finger.lengths[usize::from(phalanx) - 1];
            let axis = |k: f64| f64::from(phalanx) + k / length;
            let first = |text: String| if phalanx == 2 { text } else { String::new() };
            series.push(Series::new(
                first(format!("{name}, f64")),
                colour,
                Mark::Line,
                reference_curve(&finger, torque, usize::from(phalanx), axis),
            ));
            series.push(Series::new(
                first(format!("{name}, library in f32")),
                colour,
                Mark::Rings,
                library_curve(&library, torque, phalanx, axis),
            ));
        }
    }
    Ok(Chart {
        title: "Fig 7: K_c along two three-phalanx designs, T_a = 0.3".into(),
        x_label: "phalanx + contact location k / l  (2 to 3: intermediate, 3 to 4: distal)".into(),
        y_label: "stiffness after contact K_c / K".into(),
        x: (2.0, 4.0),
        y: (1.0, 100.0),
        log_y: true,
        legend: Legend::UpperLeft,
        series,
    })
}

/// Writes Figs 4 to 7 and returns, for each K_c curve, how far the library is from the f64 evaluation at most.
///
/// # Errors
/// A file that cannot be written.
pub fn mechanics(directory: &Path) -> Result<Vec<(String, f64)>, DrawError> {
    write(directory, "fig04_stiffness", &[figure_4()?])?;
    write(directory, "fig05_two_phalanges", &[figure_5()?])?;
    write(directory, "fig06_three_phalanges", &figure_6()?)?;
    write(directory, "fig07_two_designs", &[figure_7()?])?;
    let mut differences = Vec::new();
    let two = reference::table_1_two_phalanges();
    differences.push(("two phalanges, Table I, phalanx 2".to_owned(), {
        largest_difference(&tendon_2(&two)?, &two, 0.3, 2)
    }));
    for (name, finger) in [
        ("Table I", reference::table_1()),
        ("oversized", reference::oversized()),
    ] {
        let library = tendon_3(&finger)?;
        for phalanx in [2, 3] {
            differences.push((
                format!("three phalanges, {name}, phalanx {phalanx}"),
                largest_difference(&library, &finger, 0.3, phalanx),
            ));
        }
    }
    Ok(differences)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn library_and_independent_evaluation_draw_one_curve() {
        let two = reference::table_1_two_phalanges();
        assert!(largest_difference(&tendon_2(&two).unwrap(), &two, 0.3, 2) < 2e-5);
        for finger in [reference::table_1(), reference::oversized()] {
            let library = tendon_3(&finger).unwrap();
            for phalanx in [2, 3] {
                let difference = largest_difference(&library, &finger, 0.3, phalanx);
                assert!(difference < 2e-5, "phalanx {phalanx}: {difference}");
            }
        }
    }

    #[test]
    fn paths_after_contact_agree() {
        let finger = reference::table_1();
        let library = tendon_3(&finger).unwrap();
        for phalanx in [2_u8, 3] {
            let ours = library_closure(&library, 0.3, phalanx, 0.3, 1.0);
            let curve = contact_curve(&finger, 0.3, usize::from(phalanx), 0.3, 1.0, 7);
            assert_eq!(ours.len(), 8);
            for (ours, theirs) in ours.iter().zip(&curve) {
                let expected = theirs.torque / theirs.theta_a_rad;
                assert!(
                    (ours.1 / expected - 1.0).abs() < 1e-5,
                    "{ours:?} {expected}"
                );
            }
        }
    }
}
