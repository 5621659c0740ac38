//! The paper's own algorithm (its section VI, Fig 8, and VII), to stand beside ours on the same samples.
//!
//! A constant friction threshold from a free closing, a two-point secant of the stiffness over a fixed rise of torque,
//! the cable's stiffness taken off, and the tangent model (18) turned round. In f64, with the independent mechanics of
//! [`crate::reference`]: nothing here comes from the library but the samples' type.
//!
//! The text leaves open how its torque was smoothed, how far above friction its threshold lay and what it did when several
//! places fit. Chosen here, in its favour: a mean over 20 ms of torque and angle alike; a threshold a tenth above the
//! largest torque of the free closing; the solution nearest to the base; a place nearer to a joint than the paper's mean
//! error counts as a contact of the phalanx before it. With a spring at the base, the torque that the free finger takes at
//! each angle (6) is taken off before the threshold (the comparison with K_a' in Fig 8).

use nalgebra::DVector;
use palpate::sample::{Drive, Sample};

use crate::reference::{Finger, free_posture, tangent_compliance};

/// Samples in the mean, milliseconds.
const SMOOTHING: usize = 20;
/// Margin of the threshold over the largest torque of the free closing.
const MARGIN: f64 = 1.1;
/// Points of the table of the free finger's torque.
const FREE_POINTS: u32 = 60;
/// Longer without a closing sample is a pause, microseconds.
const PAUSE_US: u64 = 2_000 * SMOOTHING as u64;
/// Rise of torque of the two-point secant, newton metre (docs/MECHANICS.md#finite-torque-step's runs of the baseline).
pub const TORQUE_STEP_NM: f64 = 0.05;
/// The paper's mean error as a share of the phalanx: nearer to the joint it cannot tell the phalanges apart.
const JOINT_SHARE: f64 = 0.073;
/// Places tried on a phalanx before the root is refined.
const SCAN: u32 = 140;
/// Begin of a closing that is left out, microseconds: the motor still starts and takes up the gears' backlash there.
const START_UP_US: u64 = 250_000;

/// What the algorithm takes for granted.
#[derive(Clone, Debug)]
pub struct Model {
    /// The finger.
    pub finger: Finger,
    /// Torque at the input link for a motor current, newton metre per ampere.
    pub torque_nm_per_a: f64,
    /// Encoder counts in a radian of the input link.
    pub counts_per_rad: f64,
    /// Compliance of the cable, radian per newton metre.
    pub cable_rad_per_nm: f64,
    /// Angle of the input link from rest and torque of the free finger there, rising; empty without a spring at the base.
    pub free: Vec<(f64, f64)>,
}

impl Model {
    /// Torque of the free finger at an angle of the input link from rest, newton metre (6).
    fn free_torque(&self, angle_rad: f64) -> f64 {
        let after = self.free.partition_point(|(angle, _)| *angle < angle_rad);
        let (Some(b), Some(a)) = (
            self.free.get(after.clamp(1, self.free.len().max(2) - 1)),
            self.free
                .get(after.clamp(1, self.free.len().max(2) - 1) - 1),
        ) else {
            return 0.0;
        };
        (a.1 + (b.1 - a.1) * (angle_rad - a.0) / (b.0 - a.0)).max(0.0)
    }
}

/// The table for [`Model::free`], up to an angle of the input link.
#[must_use]
pub fn free_table(finger: &Finger, travel_rad: f64) -> Vec<(f64, f64)> {
    if finger.springs[0] == 0.0 {
        return Vec::new();
    }
    let rest = finger.theta_a(&DVector::from_vec(finger.rest_rad.clone()));
    // No finger is stiffer while free than its stiffest spring is on its own.
    let stiffest = finger.springs.iter().copied().fold(0.0, f64::max);
    let mut table = Vec::new();
    for point in 0..=FREE_POINTS {
        let torque = stiffest * travel_rad * f64::from(point) / f64::from(FREE_POINTS);
        let Some(posture) = free_posture(finger, torque) else {
            break;
        };
        let angle = finger.theta_a(&posture) - rest;
        table.push((angle, torque));
        if angle > travel_rad {
            break;
        }
    }
    table
}

/// What the algorithm says of one closing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The torque stayed below the threshold.
    NoContact,
    /// A contact, but the torque did not rise far enough to measure a stiffness.
    Touched {
        /// When, microseconds.
        time_us: u64,
    },
    /// A contact on the proximal phalanx.
    Proximal {
        /// When, microseconds.
        time_us: u64,
    },
    /// A located contact.
    Located {
        /// When, microseconds.
        time_us: u64,
        /// Phalanx, 2 or 3.
        phalanx: u8,
        /// Place from the phalanx's joint, in the finger's unit of length.
        k: f64,
    },
}

impl Verdict {
    /// When the contact was decided.
    #[must_use]
    pub fn touched_us(&self) -> Option<u64> {
        match *self {
            Self::NoContact => None,
            Self::Touched { time_us }
            | Self::Proximal { time_us }
            | Self::Located { time_us, .. } => Some(time_us),
        }
    }
}

/// Torque and angle, smoothed.
struct Point {
    time_us: u64,
    torque_nm: f64,
    /// The free finger's torque taken off.
    excess_nm: f64,
    angle_rad: f64,
}

/// Runs over the samples that drive in the closing direction, means of [`SMOOTHING`] of them.
fn closing(model: &Model, samples: &[Sample]) -> impl Iterator<Item = Point> {
    let driven: Vec<&Sample> = samples
        .iter()
        .filter(|sample| sample.drive == Drive::Closing)
        .collect();
    let mut started = 0;
    let mut points = Vec::new();
    for (index, window) in driven.windows(SMOOTHING).enumerate() {
        let (first, last) = (window[0], window[SMOOTHING - 1]);
        // After a pause, a gap or another motion it starts again.
        let paused = index == 0 || first.time_us - driven[index - 1].time_us > PAUSE_US;
        if paused {
            started = first.time_us;
        }
        if last.time_us - first.time_us > PAUSE_US || first.time_us - started < START_UP_US {
            continue;
        }
        let mean = |value: &dyn Fn(&Sample) -> f64| {
            window.iter().map(|sample| value(sample)).sum::<f64>() / SMOOTHING as f64
        };
        let torque_nm = mean(&|sample| f64::from(sample.current_a)) * model.torque_nm_per_a;
        let angle_rad = mean(&|sample| f64::from(sample.position_counts)) / model.counts_per_rad;
        points.push(Point {
            time_us: last.time_us,
            torque_nm,
            excess_nm: torque_nm - model.free_torque(angle_rad),
            angle_rad,
        });
    }
    points.into_iter()
}

/// A torque that a free closing does not exceed: threshold of contact and friction at once, as in the paper's Fig 12.
///
/// `None` where the samples hold no closing motion.
#[must_use]
pub fn friction_threshold(model: &Model, free_closing: &[Sample]) -> Option<f64> {
    closing(model, free_closing)
        .map(|point| point.excess_nm)
        .max_by(f64::total_cmp)
        .map(|largest| MARGIN * largest)
}

/// The algorithm on one closing, with the threshold of a free one.
#[must_use]
pub fn locate(model: &Model, threshold_nm: f64, samples: &[Sample]) -> Verdict {
    let mut touch: Option<Point> = None;
    for point in closing(model, samples) {
        match &touch {
            None if point.excess_nm > threshold_nm => touch = Some(point),
            Some(first) if point.torque_nm >= first.torque_nm + TORQUE_STEP_NM => {
                let measured =
                    (point.angle_rad - first.angle_rad) / (point.torque_nm - first.torque_nm);
                let contact_torque = first.torque_nm - threshold_nm;
                return invert(
                    model,
                    contact_torque,
                    measured - model.cable_rad_per_nm,
                    first.time_us,
                );
            }
            _ => {}
        }
    }
    touch.map_or(Verdict::NoContact, |first| Verdict::Touched {
        time_us: first.time_us,
    })
}

/// Which place makes the finger that compliant (18)?
fn invert(model: &Model, torque: f64, compliance: f64, time_us: u64) -> Verdict {
    let finger = &model.finger;
    let posture = free_posture(
        finger,
        if finger.springs[0] == 0.0 {
            0.0
        } else {
            torque
        },
    )
    .unwrap_or_else(|| DVector::from_vec(finger.rest_rad.clone()));
    let torque = if finger.springs[0] == 0.0 {
        0.0
    } else {
        torque
    };
    for phalanx in 2..=finger.phalanges() {
        let length = finger.lengths[phalanx - 1];
        let excess = |k: f64| {
            tangent_compliance(finger, &posture, torque, phalanx, k).map(|value| value - compliance)
        };
        let Some(k) = first_root(length, excess) else {
            continue;
        };
        if k < JOINT_SHARE * length {
            return on_phalanx_before(finger, phalanx, time_us);
        }
        return Verdict::Located {
            time_us,
            phalanx: phalanx as u8,
            k,
        };
    }
    // No place is that stiff or that soft: beyond the tip it saturates, otherwise it is the proximal phalanx.
    let last = finger.phalanges();
    let tip = tangent_compliance(finger, &posture, torque, last, finger.lengths[last - 1]);
    if tip.is_some_and(|tip| compliance < tip) {
        return Verdict::Located {
            time_us,
            phalanx: last as u8,
            k: finger.lengths[last - 1],
        };
    }
    Verdict::Proximal { time_us }
}

fn on_phalanx_before(finger: &Finger, phalanx: usize, time_us: u64) -> Verdict {
    if phalanx == 2 {
        return Verdict::Proximal { time_us };
    }
    Verdict::Located {
        time_us,
        phalanx: (phalanx - 1) as u8,
        k: finger.lengths[phalanx - 2],
    }
}

/// The root nearest to the joint within the phalanx.
fn first_root(length: f64, excess: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let at = |step: u32| length * (f64::from(step) + 1e-3) / f64::from(SCAN);
    let mut last = (at(0), excess(at(0))?);
    for step in 1..=SCAN {
        let k = at(step).min(length);
        let Some(value) = excess(k) else { continue };
        if value.signum() != last.1.signum() {
            let (mut low, mut high) = (last.0, k);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if excess(middle)?.signum() == last.1.signum() {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            return Some(0.5 * (low + high));
        }
        last = (k, value);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{contact_curve, p70};

    fn model() -> Model {
        Model {
            finger: p70(0.05),
            torque_nm_per_a: 4.0,
            counts_per_rad: 208_608.0,
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
                    .take_while(|p| {
                        0.3 + p.theta_a_rad + model.cable_rad_per_nm * p.torque <= angle
                    })
                    .last()
                    .map_or(0.0, |p| p.torque)
            });
            samples.push(Sample {
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
        for k in [0.02, 0.035, 0.05] {
            let verdict = locate(&model, threshold, &closing_onto(Some(k), 0.02));
            let Verdict::Located {
                phalanx: 2,
                k: found,
                ..
            } = verdict
            else {
                panic!("{k}: {verdict:?}");
            };
            // The step is K_2: docs/MECHANICS.md#finite-torque-step gives -4 % of l_2 as the mean bias of the tangent
            // there.
            assert!((found - k).abs() < 0.11 * 0.07, "{k} {found}");
        }
    }

    #[test]
    fn a_free_closing_is_no_contact() {
        let model = model();
        let free = closing_onto(None, 0.02);
        let threshold = friction_threshold(&model, &free).unwrap();
        assert_eq!(locate(&model, threshold, &free), Verdict::NoContact);
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
            Verdict::Proximal { .. }
        ));
        assert!(matches!(
            invert(&model, 0.0, 0.99 * proximal, 0),
            Verdict::Proximal { .. }
        ));
    }
}
