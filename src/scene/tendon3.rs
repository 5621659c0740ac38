//! Table I of the paper: three phalanges, tendon on pulleys, springs at all joints.

use core::f32::consts::FRAC_PI_6;

use crate::finger::{Finger, Parameters, Tendon};
use crate::scene::{Scene, valid};
use crate::sensing::{Cable, NoHall};

/// Three phalanges of 90, 67.5 and 45 mm.
#[derive(Clone, Copy, Debug)]
pub struct Tendon3;

impl Scene for Tendon3 {
    const NAME: &'static str = "tendon3";
    type Finger = Finger<3, Tendon<3>>;
    type Joint = NoHall;
    type Series = Cable;
    const PHALANGES: u8 = 3;
    // The closing stop is at 2.4 rad.
    const TRAVEL_RAD: f32 = 2.3;

    const MECHANISM: Self::Finger = valid(<Self::Finger>::constant(
        Parameters {
            lengths_m: [0.090, 0.0675, 0.045],
            stiffness_nm_per_rad: [0.1; 3],
            rest_rad: [FRAC_PI_6; 3],
            range_rad: [[-0.5, 2.6], [-0.5, 2.0], [-0.5, 2.0]],
        },
        [0.009, 0.0072, 0.0054, 0.0036],
    ));
}
