//! What the friction record is off by when a contact begins.

use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::Sensor;
use crate::sensing::block::Block;
use crate::sensing::location::SeriesElement;

/// A block of a closing above the friction record, at the input link, newton metre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Above {
    pub(super) torque_nm: f32,
    /// Standard deviation of its noise.
    pub(super) sigma_nm: f32,
}

impl Above {
    /// Of a block; `None` too far beyond the record.
    pub(super) fn of<F: Mechanics, H: JointSensor, X: SeriesElement>(
        sensor: &Sensor<F, H, X>,
        block: &Block,
    ) -> Option<Self> {
        let residual = sensor.residual(block)?;
        let efficiency = sensor.drivetrain().efficiency;
        Some(Self {
            torque_nm: efficiency * residual.torque_nm,
            sigma_nm: efficiency * sqrt(residual.variance_nm2),
        })
    }
}

/// Torque above the record in the last two blocks of a closing, newton metre at the input link.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level([f32; 2]);

impl Default for Level {
    fn default() -> Self {
        Self([f32::NAN; 2])
    }
}

impl Level {
    /// Takes a block.
    pub(super) fn push(&mut self, above_nm: f32) {
        let [_, last_nm] = self.0;
        self.0 = [last_nm, above_nm];
    }

    /// What the record is off by, newton metre, once the sensor has told a contact with this torque above friction: that was the
    /// torque of the block before the last.
    pub(super) fn at_touch(&self, torque_nm: f32) -> f32 {
        let [before_nm, _] = self.0;
        before_nm - torque_nm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A touch is told with the torque of the block before the last.
    #[test]
    fn the_level_is_that_of_the_block_that_touched() {
        let mut level = Level::default();
        level.push(0.02);
        assert!(level.at_touch(0.01).is_nan(), "one block tells nothing");
        for above_nm in [0.03, 0.05, 0.08] {
            level.push(above_nm);
        }
        assert!((level.at_touch(0.045) - 0.005).abs() < 1e-6);
    }
}
