//! The baseline on closings whose truth is known.

use palpate::sample::{Drive, Sample};

use super::place::invert;
use super::*;
use crate::reference::{contact_curve, free_posture, p70, tangent_compliance};

fn model() -> Model {
    Model {
        finger: p70(0.05),
        hidden_base: false,
        stopped: None,
        torque_nm_per_a: 4.0,
        counts_per_rad: 208_608.0,
        counts_per_turn: 1024.0,
        cable_rad_per_nm: 0.8,
        free: Vec::new(),
    }
}

/// A closing at 0.2 rad/s with constant friction, the contact at `k` after 0.3 rad, through the cable. Small friction
/// keeps the margin of the threshold small.
fn closing_onto(k: Option<f64>, friction_nm: f64) -> Vec<Sample> {
    let model = model();
    let curve = k.map(|k| contact_curve(&model.finger, 0.0, 2, k, 0.15, 300));
    let mut samples = Vec::new();
    for time in 0..4000_u64 {
        let angle = time as f64 * 1e-3 * 0.2;
        let torque = curve.as_ref().map_or(0.0, |curve| {
            curve
                .iter()
                .take_while(|p| 0.3 + p.theta_a_rad + model.cable_rad_per_nm * p.torque <= angle)
                .last()
                .map_or(0.0, |p| p.torque)
        });
        samples.push(Sample {
            emf_v: f32::NAN,
            time_us: time * 1000,
            position_counts: (angle * model.counts_per_rad) as i32,
            current_a: ((friction_nm + torque) / model.torque_nm_per_a) as f32,
            drive: Drive::Closing,
            joint: (),
        });
    }
    samples
}

#[test]
fn locates_within_the_bias_of_its_secant() {
    let model = model();
    let threshold = friction_threshold(&model, &closing_onto(None, 0.02)).unwrap();
    let rules = [Rule::Rise(0.05), Rule::TwoLevels];
    for (k, rule) in [0.02, 0.035, 0.05]
        .into_iter()
        .flat_map(|k| rules.map(|rule| (k, rule)))
    {
        let mut samples = closing_onto(Some(k), 0.02);
        // Beyond, the curve ends and the torque stays.
        samples.retain(|sample| f64::from(sample.current_a) * model.torque_nm_per_a < 0.16);
        let verdict = locate(&model, threshold, &samples, rule);
        let PaperResult::Located {
            phalanx: 2,
            k: found,
            ..
        } = verdict
        else {
            panic!("{k}: {verdict:?}");
        };
        // The step is K_2: docs/MECHANICS.md#finite-torque-step gives -4 % of l_2 as the mean bias of the tangent
        // there.
        // Over the whole rise, three times K_2, it is more.
        let bound = if rule == Rule::TwoLevels { 0.16 } else { 0.11 };
        assert!((found - k).abs() < bound * 0.07, "{k} {found} {rule:?}");
    }
}

#[test]
fn a_free_closing_is_no_contact() {
    let model = model();
    let free = closing_onto(None, 0.02);
    let threshold = friction_threshold(&model, &free).unwrap();
    assert_eq!(
        locate(&model, threshold, &free, Rule::Rise(0.05)),
        PaperResult::NoContact
    );
}

#[test]
fn the_free_finger_of_table_1_takes_its_torque() {
    let finger = crate::reference::table_1();
    let model = Model {
        free: free_table(&finger, 1.5),
        finger,
        ..model()
    };
    for angle in [0.2, 0.77, 1.4] {
        let torque = model.free_torque(angle);
        assert!(
            (torque / (0.519_630 * angle) - 1.0).abs() < 1e-4,
            "{angle}: {torque}"
        );
    }
}

#[test]
fn compliance_of_the_proximal_phalanx_is_proximal() {
    let model = model();
    let posture = free_posture(&model.finger, 0.0).unwrap();
    let proximal = tangent_compliance(&model.finger, &posture, 0.0, 1, 0.05).unwrap();
    assert!(matches!(
        invert(&model, 0.0, 1.02 * proximal, 0),
        PaperResult::Proximal { .. }
    ));
    assert!(matches!(
        invert(&model, 0.0, 0.99 * proximal, 0),
        PaperResult::Proximal { .. }
    ));
}

#[test]
fn what_is_not_steady_enters_no_mean() {
    let model = model();
    let mut samples = closing_onto(Some(0.035), 0.02);
    let threshold = friction_threshold(&model, &closing_onto(None, 0.02)).unwrap();
    let before = locate(&model, threshold, &samples, Rule::TwoLevels);
    // The hold: driven on with a larger current at a tenth of the speed.
    let last = *samples.last().unwrap();
    for time in 1..2000_u64 {
        samples.push(Sample {
            time_us: last.time_us + 1000 * time,
            position_counts: last.position_counts + (4 * time) as i32,
            current_a: 3.0 * last.current_a,
            ..last
        });
    }
    assert_eq!(locate(&model, threshold, &samples, Rule::TwoLevels), before);
}
