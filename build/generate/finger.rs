//! Writes the type of a scene's finger and its constant.

use super::{list, literal};
use crate::scene::Scene;

/// Standard gravity.
const GRAVITY_M_PER_S2: f64 = 9.81;

/// The finger's type, and the constant that the compiler checks.
pub fn of(scene: &Scene) -> (String, String) {
    let count = scene.phalanges();
    let degrees =
        |key: &str| -> Vec<f64> { scene.list(key).into_iter().map(f64::to_radians).collect() };
    let springs = scene.list("finger.spring_nm_per_rad");
    // A spring at rest beyond its stop is preloaded by it ([`Scene::preload_nm`]).
    let rest: Vec<f64> = (degrees("finger.rest_deg").iter())
        .zip(degrees("finger.joint_min_deg"))
        .map(|(rest, low)| rest.max(low))
        .collect();
    let returned = scene.has("return_cable").then(|| {
        let pulleys_m = scene.list("return_cable.pulley_m");
        let [first, second] = [pulleys_m[0], pulleys_m[1]];
        format!(
            "palpate::finger::ReturnCable {{ ratio: {}, torque_nm: {}, stiffness_nm_per_rad: {} }}",
            literal(second / first),
            literal(scene.number("return_cable.tension_n") * first),
            literal(scene.number("return_cable.stiffness_n_per_m") * first * first),
        )
    });
    let preload_nm = scene.preload_nm();
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
        _ if returned.is_some() => ", palpate::finger::ReturnCable",
        _ if preload_nm > 0.0 => ", palpate::finger::Preloaded",
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
    let parameters = format!(
        "palpate::finger::Parameters {{
            lengths_m: {},
            stiffness_nm_per_rad: {},
            rest_rad: {},
            range_rad: [{}],
        }}",
        list(&scene.list("finger.length_m")),
        list(&springs),
        list(&rest),
        ranges.join(", "),
    );
    let of = |base: &str| {
        format!("palpate::finger::Finger<{count}, palpate::finger::{transmission}{base}>")
    };
    let constant = |base: &str| {
        format!(
            "palpate::scene::valid(<{}>::constant(
        {parameters},
        {design},
    ))",
            of(base)
        )
    };
    let mechanism = match returned {
        Some(cable) => format!(
            "palpate::scene::valid(<Self::Finger>::returned(
        {parameters},
        {design},
        {cable},
    ))"
        ),
        None if preload_nm > 0.0 => format!(
            "palpate::scene::valid({}.preloaded({}))",
            constant(", palpate::finger::Springless"),
            literal(preload_nm)
        ),
        None => constant(base),
    };
    if !scene.has("finger.mass_kg") {
        return (of(base), mechanism);
    }
    let weights_n: Vec<f64> = (scene.list("finger.mass_kg").iter())
        .map(|mass_kg| GRAVITY_M_PER_S2 * mass_kg)
        .collect();
    let inner = base
        .strip_prefix(", ")
        .unwrap_or("palpate::finger::AnyBase");
    let weighted = format!(
        "palpate::scene::valid({}.weighted(
        {},
        palpate::finger::Mounting {{ gravity_rad: {}, share: 1.0 }},
    ))",
        mechanism.replace("<Self::Finger>", &format!("<{}>", of(base))),
        list(&weights_n),
        literal(scene.number("finger.mounting_deg").to_radians()),
    );
    (
        of(&format!(", palpate::finger::Weighted<{inner}>")),
        weighted,
    )
}
