//! What the finger of a scene must satisfy beyond kind and range of every key.

use super::super::Scene;
use super::{Checked, within};

/// Least angle from one stop of a joint to the other, degree: radians by mistake lie below.
const LEAST_RANGE_DEG: f64 = 5.0;
/// Least way of the input link from the end of a free closing to its closing stop, radian: homings differ by some milliradians, and near
/// the stop a contact has no curve (chosen).
const LEAST_BEFORE_STOP_RAD: f64 = 0.02;
/// How far a joint that a motor of its own holds must rest above its opening stop, degree.
const LEAST_WAY_DEG: f64 = 1.0;
/// Largest mass of a phalanx by its length: steel of 35 mm square. Grams lie above.
const MOST_KG_PER_M: f64 = 10.0;

/// Stops, rest angles, springs and travel.
pub(super) fn joints(scene: &Scene) -> Checked {
    let lists = [
        "joint_min_deg",
        "joint_max_deg",
        "rest_deg",
        "spring_nm_per_rad",
    ];
    let [low, high, rest, spring] = lists.map(|name| scene.list(&format!("finger.{name}")));
    for i in 0..scene.phalanges() {
        within(
            &format!("finger.joint_max_deg[{i}]"),
            high[i],
            low[i] + LEAST_RANGE_DEG,
            180.0,
        )
        .map_err(|range| {
            format!(
                "{range} degrees: the closing stop lies {LEAST_RANGE_DEG} or more above `finger.joint_min_deg[{i}]` = {}",
                low[i]
            )
        })?;
        // Where nothing turns joint 2 before a contact its spring may be preloaded against its stop.
        let may_be_preloaded =
            spring[0] == 0.0 && scene.phalanges() == 2 && !scene.flag("finger.hidden_base");
        let is_held = i > 0 && scene.has("direct");
        let least = if is_held {
            low[i] + LEAST_WAY_DEG
        } else if i > 0 && may_be_preloaded {
            low[i] - 90.0
        } else {
            low[i]
        };
        within(&format!("finger.rest_deg[{i}]"), rest[i], least, high[i]).map_err(|range| {
            if is_held {
                let joint = i + 1;
                format!("{range}: with [direct] a contact pushes joint {joint} open, which cannot give way at its opening stop")
            } else {
                range
            }
        })?;
        // Joint 1 may be without a spring; the others would be left to themselves without a return cable.
        if i > 0 && !scene.has("return_cable") {
            within(
                &format!("finger.spring_nm_per_rad[{i}]"),
                spring[i],
                1e-6,
                1e3,
            )
            .map_err(|range| {
                format!("{range}: only joint 1 may be without a spring, or all with [return_cable]")
            })?;
        }
    }
    if spring[0] == 0.0 && !scene.has("return_cable") {
        // Where it counts from: the input link's angle, the weight's direction and the posture of a force begin there.
        let open = low[0].max(0.0);
        within("finger.rest_deg[0]", rest[0], open, open).map_err(|range| {
            format!("{range}: without a spring at joint 1 the finger opens to theta_1 = 0, or to its opening stop above that")
        })?;
    }
    let stop = scene.number("travel.stop_rad");
    within(
        "travel.free_rad",
        scene.number("travel.free_rad"),
        0.01,
        stop - LEAST_BEFORE_STOP_RAD,
    )
    .map_err(|range| {
        format!("{range}: a free closing ends {LEAST_BEFORE_STOP_RAD} or more before `travel.stop_rad` = {stop}")
    })
}

/// Checks that there is no preload where no joint stands at its stop until a contact. A spring at joint 1 turns the others before.
pub(super) fn preload(scene: &Scene) -> Checked {
    let lists = ["spring_nm_per_rad", "rest_deg", "joint_min_deg"];
    let [spring, rest, low] = lists.map(|name| scene.list(&format!("finger.{name}")));
    if spring[0] == 0.0
        && rest[1..]
            .iter()
            .zip(&low[1..])
            .all(|(rest, low)| rest <= low)
        && !scene.has("return_cable")
    {
        return Ok(());
    }
    for key in ["sensing.preload_nm", "sensing.preload_sigma_nm"] {
        let value = scene.number(key);
        if value != 0.0 {
            return Err(format!(
                "`{key}` = {value} must be 0 where joint 1 has a spring or the finger a return cable, or a joint rests above \
                 `finger.joint_min_deg`"
            ));
        }
    }
    Ok(())
}

/// A second contact is told from which phalanges touch, the first among them.
pub(super) fn hidden_base(scene: &Scene) -> Checked {
    if scene.flag("finger.hidden_base") && scene.flag("options.second_contact") {
        return Err(
            "`options.second_contact` = true is not possible with `finger.hidden_base`: a phalanx that touches nothing \
             has no contact to tell"
                .to_owned(),
        );
    }
    Ok(())
}

/// A return cable takes the place of all springs, and holds the joints of a tendon finger of two phalanges at their opening stops.
pub(super) fn return_cable(scene: &Scene) -> Checked {
    if !scene.has("return_cable") {
        return Ok(());
    }
    for key in ["pulley_m", "tension_n", "stiffness_n_per_m"] {
        let key = format!("return_cable.{key}");
        if !scene.has(&key) {
            return Err(format!("`{key}` is missing: it has no default"));
        }
    }
    if scene.phalanges() != 2 || !scene.has("tendon") || scene.flag("finger.hidden_base") {
        return Err(
            "[return_cable] is only possible in a finger of two phalanges with [tendon] and without `finger.hidden_base`"
                .to_owned(),
        );
    }
    let lists = ["spring_nm_per_rad", "rest_deg", "joint_min_deg"];
    let [spring, rest, low] = lists.map(|name| scene.list(&format!("finger.{name}")));
    for i in 0..2 {
        within(
            &format!("finger.spring_nm_per_rad[{i}]"),
            spring[i],
            0.0,
            0.0,
        )?;
        within(&format!("finger.rest_deg[{i}]"), rest[i], low[i], low[i])?;
    }
    let [closing, opening] =
        ["tendon.pulley_m", "return_cable.pulley_m"].map(|key| scene.list(key));
    // A smaller one would not hold joint 2 at its stop.
    within(
        "return_cable.pulley_m[1]",
        opening[1],
        1.02 * opening[0] * closing[1] / closing[0],
        0.1,
    )
}

/// One stage of long levers, or none, has the leverage that its lengths say: a deviation would be ignored.
pub(super) fn leverage(scene: &Scene) -> Checked {
    let is_even = scene.has("direct") || scene.has("linkage") && scene.phalanges() == 2;
    let share = scene.number("sensing.leverage_sigma");
    if is_even && share > 0.0 {
        return Err(format!(
            "`sensing.leverage_sigma` = {share} must be 0 with [direct], and with [linkage] in a finger of two phalanges"
        ));
    }
    Ok(())
}

/// Weight and its direction belong together. Where nothing but the motor holds joint 1 the friction record tells the weight.
pub(super) fn weight(scene: &Scene) -> Checked {
    let [has_mass, has_mounting] =
        ["finger.mass_kg", "finger.mounting_deg"].map(|key| scene.has(key));
    if has_mass != has_mounting {
        let lacking = if has_mass {
            "finger.mounting_deg"
        } else {
            "finger.mass_kg"
        };
        return Err(format!(
            "`{lacking}` is missing: `finger.mass_kg` and `finger.mounting_deg` belong together"
        ));
    }
    let length_m = scene.list("finger.length_m");
    for (i, mass_kg) in scene.list("finger.mass_kg").into_iter().enumerate() {
        let key = format!("finger.mass_kg[{i}]");
        within(&key, mass_kg, 0.0, MOST_KG_PER_M * length_m[i])
            .map_err(|range| format!("{range}: a phalanx has at most {MOST_KG_PER_M} kg/m"))?;
    }
    let held = scene.has("return_cable") || scene.list("finger.spring_nm_per_rad")[0] > 0.0;
    if has_mass && !held {
        return Err(format!(
            "`finger.mass_kg` = {:?} is only possible with a spring at joint 1 or [return_cable]: without, the motor tells the weight",
            scene.list("finger.mass_kg")
        ));
    }
    Ok(())
}

/// What follows a contact is told from changes of the stiffness, and joint 2 leaving its stop is one. An object that gives way lets the
/// finger turn before.
pub(super) fn held_joint(scene: &Scene) -> Checked {
    let is_held = scene.preload_nm() > 0.0 || scene.has("return_cable");
    for key in [
        "options.second_contact",
        "options.contact_changes",
        "options.object_stiffness",
    ] {
        if scene.flag(key) && is_held {
            return Err(format!(
                "`{key}` = true is not possible with [return_cable] or a spring at rest beyond its stop: joint 2 leaving that stop \
                 changes the stiffness as well"
            ));
        }
    }
    Ok(())
}
