//! What a free closing must be able to do: turn no joint beyond its stop, with a torque that the motor has.

use super::super::Scene;
use super::linkage::Stage;
use super::{Checked, within};

/// Share of the way by which weight, which is left out here, may move a joint.
const BY_WEIGHT: f64 = 0.1;
/// Tolerance where a joint and the input link reach their stops together: the joint's stop is rounded to fewer digits, in degrees.
const TOGETHER_RAD: f64 = 1e-3;
/// Steps of the input link's travel in which the torque is raised.
const PARTS: u32 = 400;
/// Iterations of the posture under one torque.
const REPETITIONS: u32 = 40;

/// How the input link turns the joints.
enum Row {
    /// The factors of a tendon, or of nothing.
    Constant(Vec<f64>),
    Linkage(Vec<Stage>),
}

impl Row {
    fn of(scene: &Scene) -> Self {
        if scene.has("linkage") {
            return Self::Linkage(Stage::all(scene));
        }
        let mut factors = vec![1.0];
        for pair in scene.list("tendon.pulley_m").chunks(2) {
            factors.push(factors[factors.len() - 1] * pair[1] / pair[0]);
        }
        factors.resize(scene.phalanges(), 0.0);
        Self::Constant(factors)
    }

    /// The factors in a posture.
    fn at(&self, angles: &[f64]) -> Vec<f64> {
        match self {
            Self::Constant(factors) => factors.clone(),
            Self::Linkage(stages) => {
                let (mut factors, mut factor) = (vec![1.0], 1.0);
                for (i, stage) in stages.iter().enumerate() {
                    let behind = stages
                        .get(i + 1)
                        .map_or(0.0, |next| next.turned(angles[i + 2]));
                    factor *= stage.ratio(angles[i + 1] + behind);
                    factors.push(factor);
                }
                factors
            }
        }
    }
}

/// Checks the way of a free closing.
pub(super) fn check(scene: &Scene) -> Checked {
    let [low, high, rest, spring] = [
        "joint_min_deg",
        "joint_max_deg",
        "rest_deg",
        "spring_nm_per_rad",
    ]
    .map(|name| scene.list(&format!("finger.{name}")));
    if spring[0] > 0.0 {
        let high_rad: Vec<f64> = high.iter().map(|deg| deg.to_radians()).collect();
        let rest: Vec<f64> = rest.iter().map(|deg| deg.to_radians()).collect();
        return sprung(scene, [&high, &high_rad, &rest, &spring]);
    }
    // Joint 1 alone turns: from its rest against a return cable, else from theta_1 = 0 (docs/MANUAL.md#scenes).
    let open = if scene.has("return_cable") {
        low[0]
    } else {
        low[0].max(0.0)
    };
    joint_turns(scene, 0, high[0], (high[0] - open).to_radians())?;
    let radius_m = scene
        .list("return_cable.pulley_m")
        .first()
        .map_or(0.0, |radius_m| *radius_m);
    let stretch_m = radius_m * scene.number("travel.free_rad");
    let tension_n = scene.number("return_cable.tension_n")
        + scene.number("return_cable.stiffness_n_per_m") * stretch_m;
    motor_turns(scene, "[return_cable] takes", radius_m * tension_n)
}

/// Raises the torque from rest until the input link has closed, or a joint has come to its stop.
fn sprung(scene: &Scene, [high, high_rad, rest, spring]: [&[f64]; 4]) -> Checked {
    let row = Row::of(scene);
    let [stop, free] = ["travel.stop_rad", "travel.free_rad"].map(|key| scene.number(key));
    let allowed = if scene.has("finger.mass_kg") {
        1.0 + BY_WEIGHT
    } else {
        1.0
    };
    let step = stop / f64::from(PARTS);
    let (mut posture, mut way, mut torque_nm) = (rest.to_vec(), 0.0, 0.0);
    while way < stop {
        let factors = row.at(&posture);
        let compliance: f64 = factors.iter().zip(spring).map(|(x, k)| x * x / k).sum();
        torque_nm += step / compliance;
        let before = posture.clone();
        for _ in 0..REPETITIONS {
            let factors = row.at(&posture);
            for i in 0..posture.len() {
                let held = rest[i] + factors[i] * torque_nm / spring[i];
                posture[i] = 0.5 * (posture[i] + held);
            }
        }
        let turned: f64 = (row.at(&posture).iter().zip(&posture).zip(&before))
            .map(|((x, to), from)| x * (to - from))
            .sum();
        // The iteration has not found a posture of equilibrium: this check cannot judge the finger.
        if !(0.1 * step..10.0 * step).contains(&turned) {
            return Ok(());
        }
        let beyond = |i: &usize| posture[*i] - rest[*i] > allowed * (high_rad[*i] - rest[*i]);
        if let Some(i) = (0..posture.len()).find(beyond) {
            return joint_turns(scene, i, high[i], way);
        }
        if way < free && way + turned >= free {
            motor_turns(
                scene,
                &format!("`finger.spring_nm_per_rad` = {spring:?} take"),
                torque_nm,
            )?;
        }
        way += turned;
    }
    Ok(())
}

/// Checks that the input link comes to its stop before a joint does, which is at its own once the link has turned by `way`.
fn joint_turns(scene: &Scene, i: usize, high: f64, way: f64) -> Checked {
    let stop = scene.number("travel.stop_rad");
    if stop <= way + TOGETHER_RAD {
        return Ok(());
    }
    within("travel.stop_rad", stop, 0.0, way).map_err(|range| {
        format!(
            "joint {} comes to `finger.joint_max_deg[{i}]` = {high} deg before the input link to its stop: {range}",
            i + 1
        )
    })
}

/// Checks that the current of free motion gives the torque that a closing takes at its end.
fn motor_turns(scene: &Scene, taken: &str, torque_nm: f64) -> Checked {
    let of = |key: &str| scene.number(key);
    let current_a = of("motion.free_current_a");
    let most_nm = current_a * scene.torque_nm_per_a();
    if torque_nm <= most_nm {
        return Ok(());
    }
    Err(format!(
        "{taken} {torque_nm:.4} N m at `travel.free_rad` = {}: `motion.free_current_a` = {current_a} gives {most_nm:.4} N m without \
         friction",
        of("travel.free_rad")
    ))
}
