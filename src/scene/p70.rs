//! The paper's prototype: two phalanges, linkage, no spring at the base.

use crate::finger::{Assembly, Finger, Levers, Linkage, Parameters, Springless};
use crate::scene::{Scene, valid};
use crate::sensing::{Cable, NoHall};

/// Two phalanges of 90 and 70 mm. The paper's table of the linkage does not close; these levers are a plausible
/// prototype (docs/MECHANICS.md#prototype).
#[derive(Clone, Copy, Debug)]
pub struct P70;

impl Scene for P70 {
    const NAME: &'static str = "p70";
    type Finger = Finger<2, Linkage<1>, Springless>;
    type Joint = NoHall;
    type Series = Cable;
    const PHALANGES: u8 = 2;
    // The closing stop is at 1.6 rad.
    const TRAVEL_RAD: f32 = 1.5;

    const MECHANISM: Self::Finger = valid(<Self::Finger>::constant(
        Parameters {
            lengths_m: [0.090, 0.070],
            // No spring at joint 1: while nothing is touched, all torque is friction. K_2 is chosen with the cable
            // in mind (docs/MANUAL.md#scenes).
            stiffness_nm_per_rad: [0.0, 0.05],
            rest_rad: [0.0, 0.0],
            range_rad: [[-0.5, 2.6], [0.0, 2.0]],
        },
        [Levers {
            driving_m: 0.060,
            coupler_m: 0.104,
            driven_m: 0.030,
            offset_rad: 120.0_f32.to_radians(),
            assembly: Assembly::Clockwise,
        }],
    ));
}
