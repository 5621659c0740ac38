//! Writes the type of a scene's finger and its constant.

use super::{list, literal};
use crate::scene::Scene;

/// The finger's type, and the constant that the compiler checks.
pub fn of(scene: &Scene) -> (String, String) {
    let count = scene.phalanges();
    let degrees =
        |key: &str| -> Vec<f64> { scene.list(key).into_iter().map(f64::to_radians).collect() };
    let springs = scene.list("finger.spring_nm_per_rad");
    let springless = springs.first() == Some(&0.0);
    let (transmission, design) = if scene.has("linkage") {
        let [driving, coupler, driven] =
            ["driving_m", "coupler_m", "driven_m"].map(|key| scene.list(&format!("linkage.{key}")));
        let offset = degrees("linkage.offset_deg");
        let stage = |(i, assembly): (usize, &&str)| {
            let assembly = if *assembly == "clockwise" {
                "Clockwise"
            } else {
                "Counterclockwise"
            };
            format!(
                "palpate::finger::Levers {{ driving_m: {}, coupler_m: {}, driven_m: {}, offset_rad: {}, \
                 assembly: palpate::finger::Assembly::{assembly} }}",
                literal(driving[i]),
                literal(coupler[i]),
                literal(driven[i]),
                literal(offset[i]),
            )
        };
        let assemblies = scene.words("linkage.assembly");
        let stages: Vec<String> = assemblies.iter().enumerate().map(stage).collect();
        (
            format!("Linkage<{}>", count - 1),
            format!("[{}]", stages.join(", ")),
        )
    } else if scene.has("direct") {
        (format!("Direct<{count}>"), "()".to_owned())
    } else {
        (
            format!("Tendon<{count}>"),
            list(&scene.list("tendon.pulley_m")),
        )
    };
    let base = match (springless, scene.flag("finger.hidden_base")) {
        (false, false) => "",
        (true, false) => ", palpate::finger::Springless",
        (false, true) => ", palpate::finger::HiddenBase<palpate::finger::AnyBase>",
        (true, true) => ", palpate::finger::HiddenBase<palpate::finger::Springless>",
    };
    let (low, high) = (
        degrees("finger.joint_min_deg"),
        degrees("finger.joint_max_deg"),
    );
    let ranges: Vec<String> = low
        .iter()
        .zip(&high)
        .map(|(low, high)| list(&[*low, *high]))
        .collect();
    (
        format!("palpate::finger::Finger<{count}, palpate::finger::{transmission}{base}>"),
        format!(
            "palpate::scene::valid(<Self::Finger>::constant(
        palpate::finger::Parameters {{
            lengths_m: {},
            stiffness_nm_per_rad: {},
            rest_rad: {},
            range_rad: [{}],
        }},
        {design},
    ))",
            list(&scene.list("finger.length_m")),
            list(&springs),
            list(&degrees("finger.rest_deg")),
            ranges.join(", "),
        ),
    )
}
