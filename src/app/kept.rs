//! What survives a power cut, as one record.

use super::record::{Keep, scene_mark};
use super::settings::Overrides;
use crate::scene::Scene;
use crate::sensing::{Calibration, Friction};
use serde::{Deserialize, Serialize};

/// Settings, friction record and calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// What the user has set.
    pub overrides: Overrides,
    /// The friction record.
    pub friction: Option<Friction>,
    /// Torque factor and cable.
    pub calibration: Calibration,
}

impl Keep for Kept {
    fn is_plausible(&self) -> bool {
        self.overrides.is_valid()
            && self.calibration.is_valid()
            && self.friction.as_ref().is_none_or(Friction::is_valid)
    }
}

/// Mark of a scene, for [`encode`](super::record::encode) and [`decode`](super::record::decode): what a friction record and a
/// calibration depend on.
pub fn mark<S: Scene>() -> u32 {
    let drive = &S::DRIVE;
    scene_mark(
        S::NAME,
        [
            drive.motor.torque_constant_nm_per_a,
            drive.drivetrain.counts_per_motor_rev,
            drive.drivetrain.reduction,
            drive.sense.volt_per_a,
            drive.sense.reference_v,
            S::TRAVEL_RAD,
        ],
    )
}
