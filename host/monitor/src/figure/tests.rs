//! Tests of what is drawn of a grasp.

use super::*;
use crate::posture::Scales;
use crate::state::Contact;

struct Straight;

impl FingerView for Straight {
    fn points(&mut self, _: f64, _: Option<Touch>) -> Option<Points> {
        Some(vec![[0.0, 0.0], [0.09, 0.0], [0.16, 0.0]])
    }
    fn lengths_m(&self) -> Vec<f64> {
        vec![0.09, 0.07]
    }
    fn curve(&self, _: Touch, _: f64) -> Vec<(f64, f64)> {
        Vec::new()
    }
    fn scales(&self) -> Scales {
        Scales {
            rad_per_count: 1e-3,
            nm_per_a: 2.0,
            efficiency: 0.5,
            cable_rad_per_nm: 0.0,
        }
    }
}

fn located(places: &[(u32, f64)]) -> State {
    State {
        contact: Some(Contact {
            places: places
                .iter()
                .map(|&(phalanx, k_mm)| Place {
                    phalanx,
                    k_mm,
                    sigma_mm: 1.0,
                    weight: 1.0,
                })
                .collect(),
            ..Contact::default()
        }),
        ..State::default()
    }
}

#[test]
fn a_belief_is_counted_from_the_joint_of_its_phalanx() {
    let belief = belief(&located(&[(2, 30.0)]), &Straight).expect("a place");
    assert_eq!(belief.range_mm, (25.0, 35.0));
    let peak = belief.series[0]
        .points
        .iter()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|point| point.0);
    assert!(peak.is_some_and(|at| (at - 30.0).abs() < 0.1), "{peak:?}");
}

#[test]
fn two_phalanges_share_an_axis_along_the_finger() {
    let belief = belief(&located(&[(1, 80.0), (2, 5.0)]), &Straight).expect("places");
    assert_eq!(belief.range_mm, (75.0, 100.0));
    assert!(belief.axis.contains("first joint"));
}

#[test]
fn the_band_lies_on_the_palm_side_of_its_phalanx() {
    let state = located(&[(2, 30.0)]);
    let points = Straight.points(0.0, None).expect("points");
    let picture = posture(&points, &state);
    let band = picture
        .strokes
        .iter()
        .find(|stroke| stroke.role == Role::Estimate)
        .expect("a band");
    assert!((band.from[0] - 0.118).abs() < 1e-9 && (band.to[0] - 0.122).abs() < 1e-9);
    assert!(band.from[1] > HALF_THICKNESS_M);
    assert_eq!(picture.circles.len(), 3);
}
