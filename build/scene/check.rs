//! What a scene must satisfy: kind and range of every key, then the ranges that depend on other values.

use std::f64::consts::TAU;

use toml::Value;

use super::schema::{KEYS, Key, Kind};
use super::{Scene, TRANSMISSIONS};

type Checked = Result<(), String>;

pub(super) fn check(scene: &Scene) -> Checked {
    let count = scene.phalanges();
    if !(2..=3).contains(&count) {
        return Err(format!(
            "`finger.length_m` has {count} numbers, expected 2 or 3"
        ));
    }
    transmission(scene)?;
    for key in KEYS {
        match scene.value(key.name) {
            Some(value) => kind(key, value, count)?,
            None if key.optional => {}
            None => return Err(format!("`{}` is missing: it has no default", key.name)),
        }
    }
    finger(scene)?;
    drive(scene)?;
    motion(scene)?;
    return_cable(scene)?;
    preload(scene)?;
    hidden_base(scene)?;
    held_joint(scene)?;
    hall(scene)
}

/// NaN is out of every range.
fn within(key: &str, value: f64, min: f64, max: f64) -> Checked {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(format!(
            "`{key}` = {value} is out of range, allowed {} to {}",
            short(min),
            short(max)
        ))
    }
}

/// A limit without the digits that a computation leaves behind.
fn short(limit: f64) -> f64 {
    format!("{limit:.4e}").parse().unwrap_or(limit)
}

fn kind(key: &Key, value: &Value, count: usize) -> Checked {
    let name = key.name;
    let wrong = |expected: &str| Err(format!("`{name}` = {value} must be {expected}"));
    let each = |expected: usize, check: &dyn Fn(&str, &Value) -> Checked| {
        let Some(list) = value.as_array() else {
            return wrong(&format!("a list of {expected}"));
        };
        if list.len() != expected {
            return Err(format!(
                "`{name}` has {} values, expected {expected}",
                list.len()
            ));
        }
        let mut numbered = list.iter().enumerate();
        numbered.try_for_each(|(i, value)| check(&format!("{name}[{i}]"), value))
    };
    let ranged = |min, max| {
        move |name: &str, value: &Value| match super::number(value) {
            Some(number) => within(name, number, min, max),
            None => Err(format!(
                "`{name}` = {value} must be a number from {min} to {max}"
            )),
        }
    };
    match key.kind {
        Kind::Number(min, max) => ranged(min, max)(name, value),
        Kind::PerPhalanx(min, max) => each(count, &ranged(min, max)),
        Kind::PerStage(min, max) => each(count - 1, &ranged(min, max)),
        Kind::PerPulley(min, max) => each(2 * (count - 1), &ranged(min, max)),
        Kind::Words(words) => each(count - 1, &|name, value| match value.as_str() {
            Some(word) if words.contains(&word) => Ok(()),
            _ => Err(format!(
                "`{name}` = {value} must be one of: {}",
                words.join(", ")
            )),
        }),
        Kind::Flag if value.is_bool() => Ok(()),
        Kind::Flag => wrong("true or false"),
        Kind::Text if value.is_str() => Ok(()),
        Kind::Text => wrong("a text"),
    }
}

/// A linkage with all its keys, a tendon, or a motor at every joint.
fn transmission(scene: &Scene) -> Checked {
    let mut has = TRANSMISSIONS.iter().filter(|section| scene.has(section));
    let (Some(section), None) = (has.next(), has.next()) else {
        return Err("a finger has one transmission: [linkage], [tendon] or [direct]".to_owned());
    };
    let lacking = KEYS.iter().find(|key| {
        let of = key.name.split_once('.').map(|(section, _)| section);
        of == Some(section) && !scene.has(key.name)
    });
    lacking.map_or(Ok(()), |key| {
        Err(format!("`{}` is missing: it has no default", key.name))
    })
}

fn finger(scene: &Scene) -> Checked {
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
            low[i],
            180.0,
        )?;
        // Where nothing turns joint 2 before a contact its spring may be preloaded against its stop.
        let may_be_preloaded =
            spring[0] == 0.0 && scene.phalanges() == 2 && !scene.flag("finger.hidden_base");
        let least = if i > 0 && may_be_preloaded {
            low[i] - 90.0
        } else {
            low[i]
        };
        within(&format!("finger.rest_deg[{i}]"), rest[i], least, high[i])?;
        // Joint 1 may be without a spring; the others would be left to themselves without a return cable.
        if i > 0 && !scene.has("return_cable") {
            within(
                &format!("finger.spring_nm_per_rad[{i}]"),
                spring[i],
                1e-6,
                1e3,
            )?;
        }
    }
    let stop = scene.number("travel.stop_rad");
    within(
        "travel.free_rad",
        scene.number("travel.free_rad"),
        0.01,
        stop,
    )?;
    if scene.has("linkage") {
        closes(scene, &low, &high)
    } else {
        Ok(())
    }
}

/// The coupler of every stage must reach at every angle of its joint, and at what the stage behind adds to that.
fn closes(scene: &Scene, low: &[f64], high: &[f64]) -> Checked {
    const STEPS: u32 = 64;
    let ground = scene.list("finger.length_m");
    let [drive, coupler, driven, offset] = ["driving_m", "coupler_m", "driven_m", "offset_deg"]
        .map(|name| scene.list(&format!("linkage.{name}")));
    let signs: Vec<f64> = scene
        .words("linkage.assembly")
        .iter()
        .map(|word| if *word == "clockwise" { -1.0 } else { 1.0 })
        .collect();
    // What the stage behind adds to the angle of this one.
    let mut behind = [0.0, 0.0];
    for stage in (0..drive.len()).rev() {
        let (a, b, c) = (drive[stage], coupler[stage], driven[stage]);
        // Angle of the driving lever when the driven one is at v.
        let lever = |v: f64| -> Result<f64, f64> {
            let angle = v - offset[stage].to_radians();
            let tip = [ground[stage] + c * angle.cos(), c * angle.sin()];
            let reach = tip[0].hypot(tip[1]);
            let cosine = (a * a + reach * reach - b * b) / (2.0 * a * reach);
            if cosine.abs() < 1.0 {
                Ok(tip[1].atan2(tip[0]) + signs[stage] * cosine.acos())
            } else {
                Err(reach)
            }
        };
        let (from, to) = (
            low[stage + 1].to_radians() + behind[0],
            high[stage + 1].to_radians() + behind[1],
        );
        let zero = lever(0.0).unwrap_or(0.0);
        let mut turned = [0.0f64, 0.0];
        for step in 0..=STEPS {
            let v = from + (to - from) * f64::from(step) / f64::from(STEPS);
            match lever(v) {
                Ok(angle) => {
                    let mut turn = (angle - zero).rem_euclid(TAU);
                    if turn > 0.5 * TAU {
                        turn -= TAU;
                    }
                    turned = [turned[0].min(turn), turned[1].max(turn)];
                }
                Err(reach) => {
                    let nearest = (reach - a).abs();
                    let open = format!(
                        "linkage {} does not close at theta_{} = {:.0} deg (with the stage behind)",
                        stage + 1,
                        stage + 2,
                        v.to_degrees()
                    );
                    let open = if behind == [0.0, 0.0] {
                        open.replace(" (with the stage behind)", "")
                    } else {
                        open
                    };
                    return within(
                        &format!("linkage.coupler_m[{stage}]"),
                        b,
                        nearest,
                        reach + a,
                    )
                    .map_err(|range| format!("{open}: {range}"));
                }
            }
        }
        behind = turned;
    }
    Ok(())
}

fn drive(scene: &Scene) -> Checked {
    let of = |key: &str| scene.number(key);
    let full_scale_a = (of("sense.reference_v") - scene.sense_zero_v()) / scene.sense_volt_per_a();
    let counts_per_rad =
        of("encoder.counts_per_rev") * of("gearhead.ratio") * of("worm.ratio") / TAU;
    for (key, min, max) in [
        // The drive's arithmetic: at most 16 counts a control period, positions within a quarter of 32 bits.
        ("motor.ambient_c", -20.0, of("motor.winding_limit_c") - 10.0),
        (
            "limits.speed_rad_per_s",
            1e-3,
            16.0 * 20_000.0 / counts_per_rad,
        ),
        ("limits.position_min_rad", -5e8 / counts_per_rad, 0.0),
        ("limits.position_max_rad", 0.0, 5e8 / counts_per_rad),
        // Saturation of the sense would hide more.
        ("limits.current_trip_a", 0.001, 0.95 * full_scale_a),
        // Below the trip by what a motor 20 % off its resistance overshoots.
        ("limits.current_a", 0.001, 0.8 * of("limits.current_trip_a")),
        (
            "limits.supply_max_v",
            of("limits.supply_min_v"),
            of("sense.reference_v") / of("supply.divider"),
        ),
    ] {
        within(key, of(key), min, max)?;
    }
    let reduction = of("gearhead.ratio") * of("worm.ratio");
    if (1.0..=10_000.0).contains(&reduction) {
        return Ok(());
    }
    within(
        "gearhead.ratio",
        of("gearhead.ratio"),
        1.0,
        10_000.0 / of("worm.ratio"),
    )
}

fn motion(scene: &Scene) -> Checked {
    let of = |key: &str| scene.number(key);
    let (current, speed) = (of("limits.current_a"), of("limits.speed_rad_per_s"));
    for (key, min, max) in [
        ("motion.closing_rad_per_s", 0.02, speed),
        ("motion.opening_rad_per_s", 0.02, speed),
        ("motion.free_current_a", 1e-3, current),
        ("motion.homing_current_a", 1e-3, current),
        ("motion.probing_current_a", 1e-3, current),
        ("motion.holding_current_a", 0.0, current),
        (
            "travel.free_rad",
            of("motion.rest_rad") + 0.05,
            of("limits.position_max_rad"),
        ),
        // What the probing current gives at the input link, without friction.
        (
            "sensing.probe_torque_nm",
            1e-3,
            of("motion.probing_current_a")
                * of("motor.torque_constant_nm_per_a")
                * of("gearhead.ratio")
                * of("worm.ratio")
                * of("gearhead.efficiency")
                * of("worm.efficiency"),
        ),
    ] {
        within(key, of(key), min, max)?;
    }
    Ok(())
}

/// Checks that there is no preload where no joint stands at its stop until a contact. A spring at joint 1 turns the others before.
fn preload(scene: &Scene) -> Checked {
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
fn hidden_base(scene: &Scene) -> Checked {
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
fn return_cable(scene: &Scene) -> Checked {
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

/// What follows a contact is told from changes of the stiffness, and joint 2 leaving its stop is one.
fn held_joint(scene: &Scene) -> Checked {
    let [rest, low] =
        ["rest_deg", "joint_min_deg"].map(|name| scene.list(&format!("finger.{name}")));
    let is_preloaded = rest.iter().zip(&low).any(|(rest, low)| rest < low);
    for key in ["options.second_contact", "options.contact_changes"] {
        if scene.flag(key) && (is_preloaded || scene.has("return_cable")) {
            return Err(format!(
                "`{key}` = true is not possible with [return_cable] or a spring at rest beyond its stop: joint 2 leaving that stop \
                 changes the stiffness as well"
            ));
        }
    }
    Ok(())
}

/// Both ends of the sensor's range must stand clear of what a broken wire and a short read.
fn hall(scene: &Scene) -> Checked {
    if !scene.flag("hall.fitted") {
        return Ok(());
    }
    let of = |key: &str| scene.number(key);
    let (zero, slope, reference) = (
        of("hall.zero_v"),
        of("hall.sensitivity_v_per_rad"),
        of("sense.reference_v"),
    );
    let margin = 0.02 * reference;
    if slope.abs() < 0.01 {
        return Err(format!(
            "`hall.sensitivity_v_per_rad` = {slope} is out of range, allowed 0.01 to 10, or negative"
        ));
    }
    within("hall.max_rad", of("hall.max_rad"), of("hall.min_rad"), 3.2)?;
    for key in ["hall.min_rad", "hall.max_rad"] {
        let [first, last] = [margin, reference - margin].map(|volt| (volt - zero) / slope);
        within(key, of(key), first.min(last), first.max(last))?;
    }
    Ok(())
}
