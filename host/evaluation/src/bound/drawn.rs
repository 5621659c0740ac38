//! Curves drawn from what the locator assumes: every unknown from its prior, all noise from its model.

use palpate::scene::Scene;
use palpate::sensing::curve::{Curve as Bins, Point};
use palpate::sensing::locator::{Noise as AssumedNoise, Place as AssumedPlace, Prior};
use palpate::sensing::{Cable, Drivetrain};
use palpate_scenes::P70;
use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;
use std::marker::PhantomData;

use super::Knowledge;
use super::known::{DETECTED_RAD, WHITE_NM};
use crate::reference::{BESIDE, Curve, Noise, Place, Priors, Rolling, Sample, predicted};

/// Measured angle of the true onset, radian.
const ONSET_RAD: f64 = 0.8;
/// Blocks before the detected onset: those in the curve, and all.
const LEAD: i32 = 4;
const BEFORE: i32 = 28;
/// Blocks after it at most.
const AFTER: i32 = 200;
/// Torque at which a probing ends, newton metre.
const TOP_NM: f64 = 0.33;
/// Places of the contacts, as shares of the phalanx.
const SHARES: [f64; 2] = [0.1, 0.95];
/// Half the thickness of a phalanx, metre.
const HALF_THICKNESS_M: f64 = 0.006;

/// Where the truths of contacts come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truths {
    /// From what the locator assumes.
    Assumed,
    /// No friction of contact and joints, what was calibrated is exact, and there is no noise.
    Ideal,
}

/// A contact with its curve, in the form of the library and of the reference.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Where the contact is.
    pub truth: Place,
    /// The unknowns beside.
    pub values: [f64; BESIDE],
    /// For the library.
    pub bins: Bins,
    /// The same points for the reference.
    pub curve: Curve,
    /// What the library is told.
    pub prior: Prior<Cable>,
    /// The same for the reference.
    pub priors: Priors,
}

/// What the library assumes of friction, as after a usual record.
pub(super) const NOISE: AssumedNoise = AssumedNoise {
    wander_nm: 0.5e-3,
    wander_s: 3.0,
    level_nm: 1e-3,
    trend_nm_per_s: 3e-4,
    speed_rad_per_s: 0.1,
    worm_error_rad: 0.0,
};

/// The noise of every curve: docs/BOUNDS.md#estimation-from-recordings, as `palpate::sensing::locator` takes it over.
pub const REFERENCE_NOISE: Noise = Noise {
    level_nm: 1e-3,
    trend_nm_per_s: 3e-4,
    wander_nm: 0.5e-3,
    wander_s: 3.0,
    wave: 0.012,
    rest: [0.004, 0.3],
    white: 0.003,
    impact: [5e-3 / 3.0, 0.1 * 0.04],
    angle_rad: 4e-5,
};

/// The finger of the reference, with the stiffness that the library takes for granted.
///
/// # Panics
/// Never: the prototype has two phalanges and no spring at joint 1.
#[must_use]
pub fn rolling() -> Rolling {
    Rolling::of(&crate::reference::p70(0.05)).expect("the prototype rolls")
}

/// Friction as an Ornstein-Uhlenbeck process: its value after a step that leaves `kept` of it.
fn next(value: f64, kept: f64, rms: f64, random: &mut Pcg64Mcg) -> f64 {
    kept * value + rms * (1.0 - kept * kept).sqrt() * normal(random)
}

fn normal(random: &mut Pcg64Mcg) -> f64 {
    Normal::new(0.0, 1.0).map_or(0.0, |normal| normal.sample(random))
}

/// The drivetrain of the scene.
#[must_use]
pub fn drivetrain() -> Drivetrain {
    P70::drivetrain(&P70::MECHANISM)
}

/// A block of one motor turn: middle, counts, and the torque that a finger without noise would show there.
struct Block {
    counts: i32,
    torque_nm: f64,
}

/// Blocks around the onset of a contact without noise.
fn blocks(
    rolling: &Rolling,
    truth: Place,
    values: &[f64; BESIDE],
    first: i32,
) -> Option<Vec<Block>> {
    let drivetrain = drivetrain();
    let (turn, rad) = (
        drivetrain.counts_per_turn as i32,
        f64::from(drivetrain.rad_per_count),
    );
    let origin_rad = f64::from(drivetrain.closing_rad(0));
    let at = |index: i32, late_nm: f64| -> Option<f64> {
        let sample = Sample {
            angle_rad: origin_rad + rad * f64::from((first + index) * turn),
            width_rad: rad * f64::from(turn),
            late_nm,
            ..Sample::default()
        };
        let curve = Curve {
            samples: vec![sample],
            creep: f64::from(drivetrain.creep),
        };
        predicted(rolling, &curve, &truth, HALF_THICKNESS_M, values)?.pop()
    };
    let step_s = rad * f64::from(turn) / f64::from(NOISE.speed_rad_per_s);
    let mut late_nm = 0.0;
    let mut found = Vec::new();
    for index in 0..AFTER {
        let torque_nm = at(index, late_nm)?;
        late_nm += step_s / f64::from(drivetrain.creep_s) * (torque_nm - late_nm);
        found.push(Block {
            counts: (first + index) * turn,
            torque_nm,
        });
        if torque_nm > TOP_NM {
            break;
        }
    }
    Some(found)
}

/// What the library and the reference assume before a contact of which this much is known.
fn assumed(known: &Knowledge) -> (Prior<Cable>, Priors) {
    let of = &known.calibration;
    let prior = Prior {
        place: AssumedPlace::Anywhere,
        half_thickness_m: HALF_THICKNESS_M as f32,
        friction: [0.1, 0.1],
        joint_nm: [0.2e-3, 0.4e-3],
        onset_rad: [0.0, 0.03],
        weight: [0.0; 2],
        held_nm: 0.0,
        preload_nm: 0.0,
        give_m_per_n: 0.0,
        force_scale: None,
        calibration: *of,
        leverage_sigma: 0.0,
        noise: NOISE,
        series: PhantomData,
    };
    let both = |mean: f32, sigma: f32| [f64::from(mean), f64::from(sigma)];
    let priors = Priors {
        onset_rad: [ONSET_RAD, 0.03],
        friction: prior.friction.map(f64::from),
        factor: both(of.torque_factor, of.torque_factor * of.torque_factor_sigma),
        joint_nm: prior.joint_nm.map(f64::from),
        cable_rad_per_nm: both(of.cable_rad_per_nm, of.cable_sigma_rad_per_nm),
        stiffening_per_nm: both(of.stiffening_per_nm, of.stiffening_sigma_per_nm),
        half_thickness_m: HALF_THICKNESS_M,
        object_m: known.objects.radii_m(),
    };
    (prior, priors)
}

/// The points of a curve from its blocks, whose origin is that of the detected onset. `noisy` scales all noise but a block's own.
fn measured(blocks: &[Block], origin: i32, noisy: f64, random: &mut Pcg64Mcg) -> Bins {
    let drivetrain = drivetrain();
    let turn = drivetrain.counts_per_turn as i32;
    let rad = f64::from(drivetrain.rad_per_count);
    let opening_rad = f64::from(drivetrain.closing_rad(0));
    let noise = &REFERENCE_NOISE;
    let step_s = rad * f64::from(turn) / f64::from(NOISE.speed_rad_per_s);
    let step_turns = f64::from(turn) / f64::from(drivetrain.counts_per_worm_turn);
    let (level, trend) = (
        noise.level_nm * normal(random),
        noise.trend_nm_per_s * normal(random),
    );
    let (cosine, sine) = (normal(random), normal(random));
    let mut wander = noise.wander_nm * normal(random);
    let mut rest = noise.rest[0] * normal(random);
    let mut bins = Bins::new(origin);
    let mut late_nm = 0.0;
    for (index, block) in blocks.iter().enumerate() {
        wander = next(
            wander,
            (-step_s / noise.wander_s).exp(),
            noise.wander_nm,
            random,
        );
        rest = next(
            rest,
            (-step_turns / noise.rest[1]).exp(),
            noise.rest[0],
            random,
        );
        let time_s = f64::from((block.counts - origin) / turn) * step_s;
        let phase = std::f64::consts::TAU * step_turns * index as f64;
        let wave = noise.wave * 0.5_f64.sqrt() * (cosine * phase.cos() + sine * phase.sin());
        let efficiency = noisy * (wave + rest + noise.white * normal(random));
        let past_rad = opening_rad + rad * f64::from(block.counts + turn / 2) - ONSET_RAD;
        // Of the block in which the contact begins, only the later part bounces.
        let share = (past_rad / (rad * f64::from(turn))).clamp(0.0, 1.0);
        let bounce = share * noise.impact[0] * (-past_rad / noise.impact[1]).exp();
        let added_nm = level + trend * time_s + wander + (WHITE_NM + bounce) * normal(random);
        let excess_nm = block.torque_nm * (1.0 + efficiency) + noisy * added_nm;
        let mut point = Point {
            time_s: time_s as f32,
            excess_nm: excess_nm as f32,
            variance_nm2: (WHITE_NM * WHITE_NM) as f32,
            width_counts: turn as f32,
            ..Point::EMPTY
        };
        if block.counts < origin {
            bins.push_before(index, (BEFORE - LEAD) as usize, block.counts, point);
        } else {
            late_nm += step_s / f64::from(drivetrain.creep_s) * (excess_nm - late_nm);
            point.late_nm = late_nm as f32;
            bins.push(block.counts, point);
        }
    }
    bins
}

/// A contact anywhere on the distal phalanx, on a cylinder, felt by a finger of which this much is known. `None` where the
/// contact slides off before the torque has risen.
#[must_use]
pub fn contact(rolling: &Rolling, known: &Knowledge, random: &mut Pcg64Mcg) -> Option<Drawn> {
    let noisy = match known.truths {
        Truths::Assumed => 1.0,
        Truths::Ideal => 0.0,
    };
    let drivetrain = drivetrain();
    let (prior, mut priors) = assumed(known);
    priors.onset_rad[0] += noisy * DETECTED_RAD * normal(random);
    let truth = Place {
        k_m: rolling.distal_m * random.random_range(SHARES[0]..SHARES[1]),
        object_m: known.objects.drawn_m(random),
    };
    let mut values = match known.truths {
        Truths::Assumed => priors.drawn(|| normal(random)),
        Truths::Ideal => [
            0.0,
            0.0,
            priors.factor[0],
            0.0,
            priors.cable_rad_per_nm[0],
            priors.stiffening_per_nm[0],
        ],
    };
    values[0] = ONSET_RAD;

    let turn = drivetrain.counts_per_turn as i32;
    let rad = f64::from(drivetrain.rad_per_count);
    let opening_rad = f64::from(drivetrain.closing_rad(0));
    let detected = ((priors.onset_rad[0] - opening_rad) / rad / f64::from(turn)).round() as i32;
    let blocks = blocks(rolling, truth, &values, detected - BEFORE)?;
    if blocks.last()?.torque_nm < 0.3 * TOP_NM {
        return None;
    }
    let origin = (detected - LEAD) * turn;
    let bins = measured(&blocks, origin, noisy, random);
    let origin_rad = f64::from(drivetrain.closing_rad(origin));
    let samples = (bins.points().iter())
        .filter(|point| point.blocks > 0)
        .map(|point| Sample {
            angle_rad: origin_rad + rad * f64::from(point.counts),
            time_s: point.time_s.into(),
            excess_nm: point.excess_nm.into(),
            late_nm: point.late_nm.into(),
            variance_nm2: point.variance_nm2.into(),
            width_rad: rad * f64::from(point.width_counts),
            blocks: point.blocks.into(),
            worm_turns: f64::from(point.counts) / f64::from(drivetrain.counts_per_worm_turn),
        })
        .collect();
    priors.onset_rad[0] = opening_rad + rad * f64::from(detected * turn);
    Some(Drawn {
        truth,
        values,
        bins,
        curve: Curve {
            samples,
            creep: f64::from(drivetrain.creep),
        },
        prior: Prior {
            onset_rad: priors.onset_rad.map(|value| value as f32),
            ..prior
        },
        priors,
    })
}
