//! Jumps of the torque while the finger closes on a contact (docs/MECHANICS.md#held-contacts).
//!
//! The torque of a contact on an object that stands still neither falls nor rises more steeply than the cable alone.

use super::Change;
use crate::numeric::Bounded;

/// What efficiency that ripples may do between two blocks, as a share of the torque: 1 % (docs/MECHANICS.md#estimation-from-recordings)
/// either way.
const RIPPLE_SHARE: f32 = 0.02;
/// A slow decrease is a slip when it comes to this share of the largest torque.
const FADED_SHARE: f32 = 0.1;
/// Blocks in a row that say the same.
const BLOCKS: u8 = 2;

/// A block of a closing in contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct RiseBlock {
    /// Angle of the input link with the cable's twist, radian.
    pub(super) angle_rad: f32,
    /// Torque above friction, newton metre.
    pub(super) torque_nm: f32,
    /// What its noise may be at most, newton metre.
    pub(super) noise_nm: f32,
    /// The steepest rise that the drivetrain allows, newton metre per radian; infinite without a cable.
    pub(super) steepest_nm_per_rad: f32,
    /// Torque below which nothing is held.
    pub(super) nothing_nm: f32,
}

/// A jump: how, and the torques before and after, newton metre.
pub(super) type Jump = (Change, f32, f32);

/// Looks for jumps, block by block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rise {
    /// The last block that was no surprise: angle and torque. `None` before the torque is more than nothing.
    last: Option<[f32; 2]>,
    top_nm: f32,
    /// Blocks in a row that rise, or fall, by too much.
    rising: u8,
    falling: u8,
}

impl Rise {
    /// The largest torque since the last jump, newton metre; 0 before there is any.
    pub(super) fn top_nm(&self) -> f32 {
        self.top_nm
    }

    /// Takes a block; a jump once it is sure.
    pub(super) fn push(&mut self, block: &RiseBlock) -> Option<Jump> {
        let RiseBlock {
            angle_rad,
            torque_nm,
            nothing_nm,
            ..
        } = *block;
        let Some([from_rad, from_nm]) = self.last else {
            if torque_nm > nothing_nm {
                self.go_on(block);
            }
            return None;
        };
        let noise_nm = block.noise_nm + RIPPLE_SHARE * self.top_nm;
        let elastic_nm = block.steepest_nm_per_rad * (angle_rad - from_rad);
        let rises = torque_nm - from_nm > elastic_nm + noise_nm;
        let fades = torque_nm < (1.0 - FADED_SHARE) * self.top_nm - noise_nm;
        let falls = fades || torque_nm < from_nm - noise_nm;
        let counted = |holds: bool, before: u8| if holds { before + 1 } else { 0 };
        (self.rising, self.falling) = (counted(rises, self.rising), counted(falls, self.falling));
        if !(rises || falls) {
            self.go_on(block);
            return None;
        }
        if self.rising.max(self.falling) < BLOCKS {
            return None;
        }
        let jump = if rises {
            (Change::Pushed, from_nm, torque_nm)
        } else if torque_nm < nothing_nm {
            (Change::Lost, self.top_nm, torque_nm)
        } else {
            (Change::Slipped, self.top_nm, torque_nm)
        };
        *self = Self::default();
        self.go_on(block);
        Some(jump)
    }

    fn go_on(&mut self, block: &RiseBlock) {
        self.last = Some([block.angle_rad, block.torque_nm]);
        self.top_nm = self.top_nm.at_least(block.torque_nm);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_RAD: f32 = 5e-3;

    /// What is told of a curve, with the block it is told at.
    fn told(torques_nm: impl IntoIterator<Item = f32>) -> Vec<(usize, Change)> {
        let mut rise = Rise::default();
        let blocks = torques_nm.into_iter().enumerate();
        blocks
            .filter_map(|(index, torque_nm)| {
                let jump = rise.push(&RiseBlock {
                    angle_rad: STEP_RAD * index as f32,
                    torque_nm,
                    noise_nm: 3e-3,
                    steepest_nm_per_rad: 1.5,
                    nothing_nm: 0.01,
                });
                jump.map(|(change, ..)| (index, change))
            })
            .collect()
    }

    /// A contact of 0.3 N m/rad, then the cable of 1.2 alone, and what is added to it from a block on.
    fn curve(from: usize, added_nm: f32) -> impl Iterator<Item = f32> + Clone {
        (0..100).map(move |block| {
            let angle = STEP_RAD * block as f32;
            let own = 0.3 * angle + 0.9 * (angle - 0.35).max(0.0);
            // Noise of a third of what is allowed.
            let noise = if block % 3 == 0 { 1e-3 } else { -0.5e-3 };
            own + noise + if block >= from { added_nm } else { 0.0 }
        })
    }

    #[test]
    fn nothing_is_told_of_a_second_contact() {
        assert_eq!(told(curve(0, 0.0)), []);
    }

    #[test]
    fn a_jump_is_told_with_the_second_block_after_it() {
        assert_eq!(told(curve(60, -0.03)), [(61, Change::Slipped)]);
        assert_eq!(told(curve(60, 0.03)), [(61, Change::Pushed)]);
        let lost = curve(60, 0.0).enumerate();
        let lost = lost.map(|(block, own)| if block < 60 { own } else { 0.002 });
        assert_eq!(told(lost), [(61, Change::Lost)]);
    }

    #[test]
    fn one_block_alone_tells_nothing() {
        let spike = curve(0, 0.0).enumerate();
        for by in [-0.05, 0.05] {
            let spike = spike
                .clone()
                .map(|(block, own)| own + if block == 50 { by } else { 0.0 });
            assert_eq!(told(spike), []);
        }
    }

    #[test]
    fn a_slow_decrease_is_told_once_it_is_a_tenth() {
        let fading = (0..60).map(|block| 0.1 - 0.5e-3 * (block as f32 - 20.0).max(0.0));
        // A tenth of 0.1, and 5e-3 of noise: 30 blocks, and two to be sure.
        assert_eq!(told(fading), [(52, Change::Slipped)]);
    }
}
