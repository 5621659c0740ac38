//! The finger of [`tendon2`](super::tendon2) with a Hall sensor at joint 2.
//!
//! Closed far, this finger has its stiffest place e_2 on the phalanx: two places then explain the same stiffness, and the
//! motor alone often cannot tell them apart. Which way joint 2 turns does (docs/MECHANICS.md#observability).

use crate::finger::Mechanics;
use crate::scene::{Scene, Tendon2};
use crate::sensing::{Cable, Hall};

/// Two phalanges of 90 and 67.5 mm, theta_2 measured.
#[derive(Clone, Copy, Debug)]
pub struct Tendon2Hall;

impl Scene for Tendon2Hall {
    const NAME: &'static str = "tendon2-hall";
    type Finger = <Tendon2 as Scene>::Finger;
    type Joint = Hall;
    type Series = Cable;
    const PHALANGES: u8 = <Self::Finger as Mechanics>::PHALANGES as u8;
    const TRAVEL_RAD: f32 = Tendon2::TRAVEL_RAD;

    const MECHANISM: Self::Finger = Tendon2::MECHANISM;
}
