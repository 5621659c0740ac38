// SPDX-License-Identifier: GPL-2.0-only
//! The flash's error-correcting code: one wrong bit of a double word is corrected, more raise an NMI when it is read.

use std::collections::BTreeMap;

/// Damage to double words, by their offset.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ecc {
    damage: BTreeMap<u32, Damage>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Damage {
    /// This bit is wrong in the cells; reads correct it.
    Corrected(u32),
    /// Several bits are wrong, or the operation that wrote them was interrupted.
    Bad,
}

/// Result of reading a double word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    Good,
    Corrected,
    Bad,
}

impl Ecc {
    /// Whether any double word has a wrong bit.
    pub(crate) fn any(&self) -> bool {
        !self.damage.is_empty()
    }

    /// Flips one cell of a double word, counted from its first bit.
    pub(crate) fn flip(&mut self, double_word: u32, bit: u32) -> Vec<u32> {
        match self.damage.insert(double_word, Damage::Corrected(bit)) {
            None => Vec::new(),
            // Flipping the same bit again repairs it.
            Some(Damage::Corrected(other)) if other == bit => {
                self.damage.remove(&double_word);
                Vec::new()
            }
            Some(Damage::Corrected(other)) => {
                self.spoil(double_word);
                vec![other, bit]
            }
            Some(Damage::Bad) => {
                self.spoil(double_word);
                vec![bit]
            }
        }
    }

    /// Marks a double word whose operation was interrupted.
    pub(crate) fn spoil(&mut self, double_word: u32) {
        self.damage.insert(double_word, Damage::Bad);
    }

    /// Clears the damage of a double word that was completely written or erased.
    pub(crate) fn renew(&mut self, double_word: u32) {
        self.damage.remove(&double_word);
    }

    pub(crate) fn read(&self, double_word: u32) -> Reading {
        match self.damage.get(&double_word) {
            None => Reading::Good,
            Some(Damage::Corrected(_)) => Reading::Corrected,
            Some(Damage::Bad) => Reading::Bad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_bit_is_corrected_two_are_not() {
        let mut ecc = Ecc::default();
        assert_eq!(ecc.flip(64, 3), [0_u32; 0]);
        assert_eq!(ecc.read(64), Reading::Corrected);
        assert_eq!(ecc.flip(64, 3), [0_u32; 0]);
        assert_eq!(ecc.read(64), Reading::Good);
        ecc.flip(64, 3);
        assert_eq!(ecc.flip(64, 40), [3, 40]);
        assert_eq!(ecc.read(64), Reading::Bad);
        assert_eq!(ecc.flip(64, 5), [5]);
        ecc.renew(64);
        assert_eq!(ecc.read(64), Reading::Good);
    }
}
