//! The finger of [`p70`](super::p70) with its worm wheel on the input link itself: no cable between them.

use crate::finger::Mechanics;
use crate::scene::{P70, Scene, re10};
use crate::sensing::{Calibration, Drivetrain, NoHall, Rigid};

/// Two phalanges of 90 and 70 mm behind gears alone.
#[derive(Clone, Copy, Debug)]
pub struct P70Rigid;

impl Scene for P70Rigid {
    const NAME: &'static str = "p70-rigid";
    type Finger = <P70 as Scene>::Finger;
    type Joint = NoHall;
    type Series = Rigid;
    const PHALANGES: u8 = P70::PHALANGES;
    const TRAVEL_RAD: f32 = P70::TRAVEL_RAD;
    const UNCALIBRATED: Calibration = Calibration {
        cable_rad_per_nm: 0.0,
        cable_sigma_rad_per_nm: 0.0,
        ..re10::UNCALIBRATED
    };

    const MECHANISM: Self::Finger = P70::MECHANISM;

    fn drivetrain(finger: &Self::Finger) -> Drivetrain {
        Drivetrain {
            creep: [0.0; 2],
            ..re10::drivetrain(finger.input_angle_rad(&finger.rest()))
        }
    }
}
