//! Three phalanges with a linkage of two stages, springs at all joints.

use crate::finger::{Assembly, Finger, Levers, Linkage, Parameters};
use crate::scene::{Scene, valid};
use crate::sensing::{Cable, NoHall};

/// Three phalanges of 90, 67.5 and 45 mm.
#[derive(Clone, Copy, Debug)]
pub struct Linkage3;

impl Scene for Linkage3 {
    const NAME: &'static str = "linkage3";
    type Finger = Finger<3, Linkage<2>>;
    type Joint = NoHall;
    type Series = Cable;
    const PHALANGES: u8 = 3;
    // The closing stop is at 1.8 rad.
    const TRAVEL_RAD: f32 = 1.7;

    const MECHANISM: Self::Finger = valid(<Self::Finger>::constant(
        Parameters {
            lengths_m: [0.090, 0.0675, 0.045],
            stiffness_nm_per_rad: [0.1; 3],
            rest_rad: [0.3, 0.1, 0.1],
            range_rad: [[-0.5, 2.6], [-0.5, 1.7], [-0.5, 1.7]],
        },
        [
            Levers {
                driving_m: 0.0585,
                coupler_m: 0.1035,
                driven_m: 0.0297,
                offset_rad: 2.0,
                assembly: Assembly::Clockwise,
            },
            Levers {
                driving_m: 0.045,
                coupler_m: 0.0774,
                driven_m: 0.0225,
                offset_rad: 2.0,
                assembly: Assembly::Clockwise,
            },
        ],
    ));
}
