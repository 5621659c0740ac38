//! What studies of drawn fingers share: how they are calibrated, and how places that were told are summed up.

use crate::{Error, Outcome, Simulated, Simulation};
use palpate_plant::{Grasp, Parameters, Shape, World};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use std::ops::Range;

/// Pins of a calibration on the last phalanx, as shares of its length: one where the finger is soft, for the torque factor, and one where
/// it is stiff, for the cable.
pub const PIN_SHARES: [f64; 2] = [0.3, 0.75];
/// Angle of joint 1 at which they are met, radian.
pub const PIN_RAD: f64 = 0.8;

/// Places of contacts on the last phalanx, as shares of its length, and diameters of the cylinders there, metre.
const PLACES: Range<f64> = 0.15..0.9;
const DIAMETERS_M: Range<f64> = 0.006..0.03;

/// A drawn finger of a world, prepared and calibrated on pins at these shares of its last phalanx; its parameters, and the length of that
/// phalanx, metre.
///
/// # Errors
/// The world does not suit the scene; the sequence refused.
pub fn calibrated<S: Simulated>(
    world: &World,
    seed: u64,
    pins: [f64; 2],
) -> Result<(Simulation<S>, Parameters, f64), Error> {
    let parameters = world.of(S::NAME)?.randomised(seed);
    let length_m = parameters.finger.length_m[usize::from(S::PHALANGES) - 1];
    let mut simulation = Simulation::<S>::new(&parameters, seed)?;
    simulation.prepare()?;
    simulation.calibrate_on_pins(length_m, pins, PIN_RAD)?;
    Ok((simulation, parameters, length_m))
}

/// A contact of a study: a cylinder on the last phalanx, met with joint 1 at an angle of this range.
pub(crate) fn drawn<S: Simulated>(
    length_m: f64,
    theta_1_rad: Range<f64>,
    random: &mut Pcg64Mcg,
) -> Grasp {
    let k_m = length_m * random.random_range(PLACES);
    let diameter_m = random.random_range(DIAMETERS_M);
    let theta_1_rad = random.random_range(theta_1_rad);
    Grasp::touching(
        S::PHALANGES,
        k_m,
        theta_1_rad,
        Shape::Cylinder { diameter_m },
    )
}

/// The prepared finger for a closing of its own, with noise of its own.
pub(crate) fn anew<S: Simulated>(
    simulation: &Simulation<S>,
    seed: u64,
    index: usize,
) -> Simulation<S> {
    let mut simulation = simulation.clone();
    simulation.reseed(seed.wrapping_mul(1_000_003) + index as u64);
    simulation
}

/// What came of a closing; `None` where the object does not fit between the open finger and its place.
///
/// # Errors
/// Any other that the closing had.
pub(crate) fn fitting(closed: Result<Outcome, Error>) -> Result<Option<Outcome>, Error> {
    match closed {
        Ok(outcome) => Ok(Some(outcome)),
        Err(Error::Plant(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Deviations within which the truth should be in 95 of 100.
const HONEST: f64 = 2.0;

/// Mean of the errors without sign, and the share within two deviations, percent; NaN of none. Of each: told less true, with the
/// deviation told.
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "a count")]
pub fn summary(found: &[[f64; 2]]) -> [f64; 2] {
    let mean =
        |of: &dyn Fn(&[f64; 2]) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
    [
        mean(&|[error, _]| error.abs()),
        mean(&|[error, sigma]| 100.0 * f64::from(error.abs() <= HONEST * sigma)),
    ]
}
