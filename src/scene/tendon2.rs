//! Table I of the paper cut to two phalanges: tendon on pulleys, springs at both joints.

use core::f32::consts::FRAC_PI_6;

use crate::finger::{Finger, Parameters, Tendon};
use crate::scene::{Scene, valid};
use crate::sensing::{Cable, NoHall};

/// Two phalanges of 90 and 67.5 mm.
#[derive(Clone, Copy, Debug)]
pub struct Tendon2;

impl Scene for Tendon2 {
    const NAME: &'static str = "tendon2";
    type Finger = Finger<2, Tendon<2>>;
    type Joint = NoHall;
    type Series = Cable;
    const PHALANGES: u8 = 2;
    // The closing stop is at 2.2 rad.
    const TRAVEL_RAD: f32 = 2.1;

    const MECHANISM: Self::Finger = valid(<Self::Finger>::constant(
        Parameters {
            lengths_m: [0.090, 0.0675],
            stiffness_nm_per_rad: [0.1, 0.1],
            rest_rad: [FRAC_PI_6, FRAC_PI_6],
            range_rad: [[-0.5, 2.6], [-0.5, 2.0]],
        },
        [0.009, 0.0072],
    ));
}
