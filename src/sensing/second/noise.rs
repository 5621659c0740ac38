//! What is known of the noise of blocks in which a second contact is looked for.

/// Noise of a block's torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockNoise {
    /// Variance of its white noise, newton metre squared, >= 0.
    pub white_nm2: f32,
    /// By how much the variance of wandering friction grows from block to block, newton metre squared, >= 0.
    pub walk_nm2: f32,
    /// Angle of the input link over a turn of the worm, with which the efficiency changes, radian, > 0.
    pub worm_turn_rad: f32,
    /// Amplitude of the transmission error over that turn, where a scene states one, radian, >= 0.
    pub worm_error_rad: f32,
}

impl BlockNoise {
    /// That of means of so many.
    pub(super) fn of_means(&self, number: f32) -> Self {
        Self {
            white_nm2: self.white_nm2 / number,
            walk_nm2: number * self.walk_nm2,
            ..*self
        }
    }
}
