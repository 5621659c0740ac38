//! A torque that fades while the finger closes on a contact (docs/SECOND_CONTACTS.md#held-contacts): the object gives way, but too slowly
//! for a [jump](super::jump).

use crate::numeric::Bounded;
use crate::sensing::sensor::FADED_SHARE;

/// What efficiency that ripples may do between two blocks, as a share of the torque: 1 % (docs/BOUNDS.md#estimation-from-recordings)
/// either way.
pub(super) const RIPPLE_SHARE: f32 = 0.02;
/// Blocks in a row that say the same.
const BLOCKS: u8 = 2;

/// Follows the largest torque, block by block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fade {
    top_nm: f32,
    /// What was left of the torque at the last change, if nothing was said of it since.
    left_nm: Option<f32>,
    /// Blocks in a row far below it.
    fallen: u8,
}

impl Fade {
    /// A torque that has just changed, to this one.
    pub(super) fn after(torque_nm: f32) -> Self {
        Self {
            left_nm: Some(torque_nm),
            ..Self::default()
        }
    }

    /// The largest torque above friction since the last change, newton metre; 0 before there is more than nothing.
    pub(super) fn top_nm(&self) -> f32 {
        self.top_nm
    }

    /// Takes a block: torque above friction, what its noise may be at most, and the torque below which nothing is held, newton metre.
    /// The torque that it faded from, once that is sure.
    pub(super) fn push(&mut self, torque_nm: f32, noise_nm: f32, nothing_nm: f32) -> Option<f32> {
        if self.top_nm <= 0.0 && torque_nm <= nothing_nm {
            // After a change there may be nothing left.
            let left_nm = self.left_nm?;
            self.fallen += 1;
            if self.fallen < BLOCKS {
                return None;
            }
            self.left_nm = None;
            return Some(left_nm);
        }
        let noise_nm = noise_nm + RIPPLE_SHARE * self.top_nm;
        if torque_nm >= (1.0 - FADED_SHARE) * self.top_nm - noise_nm {
            self.top_nm = self.top_nm.at_least(torque_nm);
            self.fallen = 0;
            return None;
        }
        self.fallen += 1;
        if self.fallen < BLOCKS {
            return None;
        }
        let from_nm = self.top_nm;
        *self = Self::after(torque_nm);
        Some(from_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The blocks at which a curve is told, with the torque it faded from.
    fn told(torques_nm: impl IntoIterator<Item = f32>) -> Vec<(usize, f32)> {
        let mut fade = Fade::default();
        let blocks = torques_nm.into_iter().enumerate();
        blocks
            .filter_map(|(index, torque_nm)| Some((index, fade.push(torque_nm, 3e-3, 0.01)?)))
            .collect()
    }

    #[test]
    fn what_rises_or_stays_does_not_fade() {
        let noise = |block: i32| if block % 3 == 0 { 1e-3 } else { -0.5e-3 };
        assert_eq!(told((0..100).map(|b| 2e-3 * b as f32 + noise(b))), []);
        assert_eq!(told((0..100).map(|b| 0.2 + noise(b))), []);
        assert_eq!(told((0..100).map(|b| 5e-3 + noise(b))), []);
    }

    #[test]
    fn a_slow_decrease_is_told_once_it_is_a_tenth() {
        let fading = (0..60).map(|block| 0.1 - 0.5e-3 * (block as f32 - 20.0).max(0.0));
        // A tenth of 0.1, and 5e-3 of noise: 30 blocks, and two to be sure.
        assert_eq!(told(fading), [(52, 0.1)]);
    }

    #[test]
    fn what_is_gone_after_a_change_is_told_once() {
        let mut fade = Fade::after(0.04);
        let told: Vec<_> = (0..9).map(|_| fade.push(2e-3, 3e-3, 0.01)).collect();
        assert_eq!(told.iter().flatten().collect::<Vec<_>>(), [&0.04]);
        assert_eq!(told[1], Some(0.04));
    }

    #[test]
    fn one_block_alone_tells_nothing() {
        assert_eq!(told((0..60).map(|b| if b == 30 { 0.05 } else { 0.1 })), []);
    }
}
