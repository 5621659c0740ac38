//! Whether the rounds find the minimum: fits from everywhere on the phalanx as oracle.

use super::fit::{Fitted, Hypothesis};
use super::prior::{CABLE, FACTOR, FRICTION, JOINT, K, ONSET, UNKNOWNS};
use super::*;
use crate::scene::{P70, Scene};
use crate::sensing::Cable;
use core::marker::PhantomData;

mod lost;
mod radii;
mod rivals;
mod worm;

const ONSET_RAD: f32 = 0.8;

pub(super) fn prior() -> Prior<Cable> {
    prior_of()
}

pub(super) fn prior_of<X: SeriesElement>() -> Prior<X> {
    Prior {
        place: Place::Anywhere,
        half_thickness_m: 0.006,
        friction: [0.1, 0.1],
        joint_nm: [0.2e-3, 0.4e-3],
        onset_rad: [ONSET_RAD, 0.03],
        weight: [0.0; 2],
        held_nm: 0.0,
        preload_nm: 0.0,
        give_m_per_n: 0.0,
        force_scale: None,
        calibration: Calibration {
            torque_factor: 1.0,
            torque_factor_sigma: 0.02,
            cable_rad_per_nm: 0.7,
            cable_sigma_rad_per_nm: 0.02,
            correlation: 0.2,
            stiffening_per_nm: 0.1,
            stiffening_sigma_per_nm: 0.1,
            joint_nm: 0.0,
            joint_sigma_nm: 0.0,
            joint_correlation: 0.0,
            worm_rad: [0.0; 2],
            contacts: 2,
            presses: 1,
        },
        leverage_sigma: 0.0,
        noise: Noise {
            wander_nm: 0.8e-3,
            wander_s: 2.0,
            level_nm: 5e-3,
            trend_nm_per_s: 3e-4,
            speed_rad_per_s: 0.3,
            worm_error_rad: 0.0,
        },
        series: PhantomData,
    }
}

/// A hypothesis with one fit: its place and deviation in lengths of the phalanx.
pub(super) fn track(
    phalanx: u8,
    length_m: f32,
    [place, sigma]: [f32; 2],
    ln_evidence: f32,
) -> Track {
    let mut x = [0.0; UNKNOWNS];
    x[K] = place;
    let fitted = Fitted {
        x,
        k_sigma_m: sigma * length_m,
        give: [0.0; 2],
        ln_evidence,
        chi_square: 1.0,
        leaves: false,
    };
    Track {
        phalanx,
        length_m,
        candidate: place,
        side: [0.0, 1.0],
        fits: [Some(fitted), None, None, None, None, None],
    }
}

/// A curve of P70.
fn curve(k_m: f32, radius_m: f32, joint_nm: f32, drivetrain: &Drivetrain) -> Vec<Point> {
    curve_of(
        &P70::MECHANISM,
        drivetrain,
        &prior(),
        radius_m,
        &[(K, k_m), (JOINT, joint_nm)],
    )
}

/// A curve of phalanx 2 as the model itself predicts it, with some unevenness that no model knows; `values` are those of some unknowns.
pub(super) fn curve_of<F: Mechanics, X: SeriesElement>(
    finger: &F,
    drivetrain: &Drivetrain,
    prior: &Prior<X>,
    radius_m: f32,
    values: &[(usize, f32)],
) -> Vec<Point> {
    let hold = Hold::Contact {
        phalanx: 2,
        radius_m,
    };
    curve_held(finger, drivetrain, prior, hold, values)
}

/// The same of any kind of contact.
fn curve_held<F: Mechanics, X: SeriesElement>(
    finger: &F,
    drivetrain: &Drivetrain,
    prior: &Prior<X>,
    hold: Hold,
    values: &[(usize, f32)],
) -> Vec<Point> {
    let free = |rad| onset::at::<F, X>(finger, rad, prior, &finger.rest()).unwrap();
    let chosen = values;
    let mut values = [0.0; UNKNOWNS];
    values[ONSET] = ONSET_RAD;
    values[FRICTION] = 0.15;
    values[FACTOR] = 0.98;
    values[CABLE] = 0.69;
    for &(unknown, value) in chosen {
        values[unknown] = value;
    }
    let mut model = Model::<_, X>::new(
        finger,
        (0.0, drivetrain),
        &values,
        prior,
        hold,
        &free(ONSET_RAD),
    )
    .unwrap();
    let mut points = Vec::new();
    let mut torque_nm = 0.0;
    for i in 0..40 {
        let angle_rad = ONSET_RAD - 0.05 + 0.01 * i as f32;
        let mut point = Point {
            counts: angle_rad / drivetrain.rad_per_count,
            time_s: (angle_rad - ONSET_RAD + 0.03) / 0.3,
            excess_nm: torque_nm,
            free_nm: free(angle_rad).torque_nm,
            variance_nm2: 1e-8,
            width_counts: 0.005 / drivetrain.rad_per_count,
            blocks: 1,
            ..Point::EMPTY
        };
        let Some(found) = model.next(finger, &point) else {
            break;
        };
        torque_nm = found.excess_nm;
        point.excess_nm =
            torque_nm * (1.0 + 0.003 * (7.0 * i as f32).sin()) + 2e-4 * (3.0 * i as f32).cos();
        points.push(point);
        if torque_nm > 0.33 {
            break;
        }
    }
    points
}

/// Data of a curve whose angles count from zero.
pub(super) fn data<'a>(points: &'a [Point], drivetrain: &'a Drivetrain) -> Data<'a> {
    Data {
        points,
        origin_rad: 0.0,
        drivetrain,
    }
}

/// A locator after a thorough round on a curve.
pub(super) fn judged<F: Mechanics, X: SeriesElement>(
    finger: &F,
    data: &Data,
    prior: &Prior<X>,
) -> Locator<F, X> {
    let near = finger.rest();
    let mut locator = Locator::default();
    assert!(locator.begin(finger, data, prior, &near, true));
    while !locator.step(finger, data, prior, &near, ()) {}
    locator
}

/// Places and radii of objects, metre.
const CONTACTS: [[f32; 2]; 7] = [
    [0.003, 0.002],
    [0.008, 0.002],
    [0.02, 0.005],
    [0.035, 0.02],
    [0.05, 0.01],
    [0.062, 0.002],
    [0.067, 0.01],
];

#[test]
fn no_start_anywhere_finds_better_than_a_round() {
    compare_with_starts_everywhere(&prior(), 0.0, &CONTACTS);
}

/// Left out are the first place, where a round ends 0.4 mm beside the least cost of 40 with one of 44, and the last, 2.3 mm beside.
#[test]
fn nor_where_the_joints_take_seven_times_what_a_scene_assumes() {
    let mut prior = prior();
    prior.calibration.contacts = 0;
    prior.calibration.torque_factor_sigma = 0.1;
    compare_with_starts_everywhere(&prior, 3e-3, &CONTACTS[1..6]);
}

/// Compares the fits of a thorough round with the best of 39 that start all along the phalanx.
fn compare_with_starts_everywhere(prior: &Prior<Cable>, joint_nm: f32, contacts: &[[f32; 2]]) {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    let near = finger.rest();
    let length_m = finger.phalanx_length_m(2).unwrap();
    for &[k_m, object_m] in contacts {
        let points = curve(
            k_m,
            object_m + prior.half_thickness_m,
            joint_nm,
            &drivetrain,
        );
        let data = data(&points, &drivetrain);
        let locator = judged(&finger, &data, prior);
        let track = locator.tracks.iter().find(|t| t.phalanx == 2).unwrap();
        let best = |fits: &mut dyn Iterator<Item = f32>| fits.fold(f32::NEG_INFINITY, f32::max);
        let most = best(&mut track.fits.iter().flatten().map(|f| f.ln_evidence));
        assert!(most.is_finite());
        for (radius, found) in track.fits.iter().enumerate() {
            let Some(found) = found else { continue };
            if found.ln_evidence < most - 5.0 {
                continue;
            }
            let hypothesis = Hypothesis {
                hold: track.hold(radius, prior),
                length_m,
            };
            // What a fit minimises but for the logarithms of variances: they move by about one with the onset.
            let (mut least, mut place_m) = (f32::INFINITY, f32::NAN);
            for i in 1..40 {
                let mut fit = Fit::new(hypothesis, starts::values(i as f32 / 40.0, prior), false);
                let mut progress = Progress::UnderWay;
                while progress == Progress::UnderWay {
                    progress = fit.step(&finger, &data, prior, &near, ());
                }
                if let (Progress::Converged, Some(fitted)) = (progress, fit.fitted(prior))
                    && fitted.chi_square < least
                {
                    (least, place_m) = (fitted.chi_square, length_m * fitted.x[K]);
                }
            }
            // Near the joint the finger is four times as soft as the cable, so the break-away torque puts a kink at the first point of
            // the curve. A fit may stop on the wrong side of the kink, but at the same place.
            let off_m = (length_m * found.x[K] - place_m).abs();
            let enough = if k_m < 0.005 && off_m < 1e-4 {
                15.0
            } else {
                2.0
            };
            assert!(
                found.chi_square < least + enough,
                "{k_m} {object_m} radius {radius}: {} {least}, {off_m} m apart",
                found.chi_square
            );
        }
    }
}

/// A curve that only unknowns far beyond their priors explain is that of another finger, however small what is left of it.
#[test]
fn what_the_priors_give_way_counts_as_misfit() {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    let points = curve(0.035, 0.011, 3e-3, &drivetrain);
    let data = data(&points, &drivetrain);
    // Joints and cable of the curve take 3 mN m and 0.69 rad per newton metre.
    let explained = |joint_sigma_nm: f32, cable_rad_per_nm: f32| {
        let mut prior = prior();
        prior.joint_nm = [0.2e-3, joint_sigma_nm];
        prior.calibration.cable_rad_per_nm = cable_rad_per_nm;
        let locator = judged(&finger, &data, &prior);
        let best = locator.best_fit().expect("a fit");
        let gave_way: f32 = best.x.iter().skip(1).map(|x| x * x).sum();
        // The residuals alone are as small as their noise.
        assert!(best.chi_square - gave_way < points.len() as f32);
        locator.explains()
    };
    assert!(explained(3e-3, 0.7));
    assert!(!explained(0.4e-3, 0.53));
}

/// What two pins teach a finger that has been pressed on its stop: `joint_nm` is the prior of its joints after a calibration, `judge` fits
/// the curve of each pin.
fn pinned(
    radius_m: f32,
    noise: Noise,
    joint_nm: impl Fn(&mut Calibration) -> [f32; 2],
    judge: impl Fn(&Prior<Cable>, f32) -> Locator<<P70 as Scene>::Finger, Cable>,
) -> Calibration {
    let mut calibration = Calibration {
        torque_factor_sigma: 0.115,
        correlation: 0.0,
        contacts: 0,
        ..prior().calibration
    };
    for k_m in [0.021, 0.052] {
        let mut before = calibration;
        let prior = Prior {
            place: Place::Known {
                phalanx: 2,
                k_m,
                sigma_m: 3e-4,
                radius_m,
            },
            joint_nm: joint_nm(&mut before),
            calibration: before,
            noise,
            ..prior()
        };
        let learned = judge(&prior, k_m).learned(&prior).expect("a fit");
        let taught = calibration.with_contact(&learned.calibration, learned.misfit, learned.strain);
        calibration = taught.expect("a pin where it is said to be");
    }
    calibration
}

/// What pins tell of the joints belongs to what they tell of the torque factor: one without the other misleads.
#[test]
fn a_contact_uses_what_pins_have_told_of_the_joints() {
    let finger = P70::MECHANISM;
    let drivetrain = P70::drivetrain(&finger);
    let assumed = [0.6e-3, 0.6e-3];
    let (joint_nm, radius_m) = (1.6e-3, 0.011);
    let noise = Noise {
        wander_nm: 0.3e-3,
        level_nm: 1e-3,
        ..prior().noise
    };
    let found = |prior: &Prior<Cable>, k_m: f32| {
        let points = curve(k_m, radius_m, joint_nm, &drivetrain);
        let data = data(&points, &drivetrain);
        judged(&finger, &data, prior)
    };
    let calibration = pinned(radius_m, noise, |before| before.joint(assumed), found);
    let told_nm = assumed[0] + calibration.joint_nm;
    assert!(
        (told_nm - joint_nm).abs() < 2.0 * calibration.joint_sigma_nm,
        "{calibration:?}"
    );
    assert!(calibration.joint_correlation.abs() > 0.3, "{calibration:?}");
    for k_m in [0.012, 0.035, 0.045] {
        let located = |mut calibration: Calibration| {
            let prior = Prior {
                joint_nm: calibration.joint(assumed),
                calibration,
                noise,
                ..prior()
            };
            match found(&prior, k_m).verdict(&prior) {
                LocatorResult::At(estimate) => [(estimate.k_m - k_m).abs(), estimate.k_sigma_m],
                other => panic!("{k_m}: {other:?}"),
            }
        };
        let [off_m, sigma_m] = located(calibration);
        let [off_without_m, sigma_without_m] = located(Calibration {
            joint_nm: 0.0,
            joint_sigma_nm: assumed[1],
            joint_correlation: 0.0,
            worm_rad: [0.0; 2],
            ..calibration
        });
        assert!(
            off_m < off_without_m && off_m < sigma_m,
            "{k_m}: {off_m} +- {sigma_m}, without {off_without_m} +- {sigma_without_m}"
        );
    }
}
