//! What the firmware demands by its own arithmetic, in single precision: a value at the end of a range may lie a rounding beyond it.
//! The library's checks have the same operations in the same order (`drive/config.rs`, `drive/sequence/motion.rs`, `joint_sensor.rs`).

use std::f32::consts::TAU;

use super::super::Scene;
use super::Checked;

pub(super) fn check(scene: &Scene) -> Checked {
    let of = |key: &str| single(scene.number(key));
    let reference_v = of("sense.reference_v");
    let full_scale_a =
        (reference_v - single(scene.sense_zero_v())) / single(scene.sense_volt_per_a());
    let reduction = single(scene.number("gearhead.ratio") * scene.number("worm.ratio"));
    let counts_per_rad = of("encoder.counts_per_rev") * reduction / TAU;
    let supply = single(1.0 / scene.number("supply.divider"));
    let reach_rad = 5e8 / counts_per_rad;
    for (key, min, max) in [
        ("motor.ambient_c", -20.0, of("motor.winding_limit_c") - 10.0),
        ("limits.current_trip_a", 0.001, 0.95 * full_scale_a),
        (
            "limits.speed_rad_per_s",
            1e-3,
            16.0 * 20_000.0 / counts_per_rad,
        ),
        ("limits.position_min_rad", -reach_rad, 0.0),
        ("limits.position_max_rad", 0.0, reach_rad),
        ("limits.overtravel_rad", 1e-3, reach_rad),
        ("limits.current_a", 0.001, 0.8 * of("limits.current_trip_a")),
        (
            "limits.supply_max_v",
            of("limits.supply_min_v"),
            reference_v * supply,
        ),
        (
            "travel.free_rad",
            of("motion.rest_rad") + 0.05,
            of("limits.position_max_rad"),
        ),
    ] {
        if !(min..=max).contains(&of(key)) {
            return Err(format!(
                "`{key}` = {} is out of range by a rounding, allowed {min} to {max} in the firmware's single precision",
                scene.number(key)
            ));
        }
    }
    if scene.flag("hall.fitted") {
        hall(scene, reference_v)?;
    }
    Ok(())
}

/// Both ends of the sensor's range, clear of what a broken wire and a short read.
fn hall(scene: &Scene, reference_v: f32) -> Checked {
    let of = |key: &str| single(scene.number(key));
    let margin_v = 0.02 * reference_v;
    let (least, most) = (margin_v, reference_v - margin_v);
    for key in ["hall.min_rad", "hall.max_rad"] {
        let volt = of("hall.zero_v") + of("hall.sensitivity_v_per_rad") * of(key);
        if !(least..=most).contains(&volt) {
            return Err(format!(
                "`{key}` = {} is out of range by a rounding: the sensor gives {volt} V there, allowed {least} to {most} V in the \
                 firmware's single precision",
                scene.number(key)
            ));
        }
    }
    Ok(())
}

/// A number as the firmware has it.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the firmware computes in single precision"
)]
fn single(value: f64) -> f32 {
    value as f32
}
