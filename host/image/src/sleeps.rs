//! Where an image lets the core sleep, and whether a barrier follows (`src/board/mod.rs` says why one must).

use crate::thumb;
use crate::{Image, Symbol};

/// WFE and WFI.
const SLEEPS: [u16; 2] = [0xBF20, 0xBF30];
/// ISB.
const BARRIER: [u16; 2] = [0xF3BF, 0x8F6F];

/// Sleeps of an image: their number, and the functions with one that no barrier follows.
#[derive(Clone, Debug, Default)]
pub struct Sleeps {
    /// All.
    pub number: usize,
    /// Those without a barrier.
    pub bare: Vec<Symbol>,
}

impl Sleeps {
    pub(crate) fn of(image: &Image) -> Self {
        let mut found = Self::default();
        for function in image.symbols().filter(|symbol| symbol.is_code) {
            let instructions = sleeps(image.code(function))
                .into_iter()
                .filter(|(offset, _)| image.is_code(function.address + offset));
            for (_, follows) in instructions {
                found.number += 1;
                if !follows {
                    found.bare.push(function.clone());
                }
            }
        }
        found
    }
}

/// Offset of each sleep in a function's code, and whether a barrier follows.
fn sleeps(code: &[u8]) -> Vec<(u32, bool)> {
    let halves: Vec<u16> = (code.chunks_exact(2))
        .map(|two| u16::from_le_bytes([two[0], two[1]]))
        .collect();
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(first) = halves.get(at) {
        let offset = 2 * at as u32;
        at += thumb::length(*first) as usize / 2;
        if SLEEPS.contains(first) {
            found.push((offset, halves.get(at..at + 2) == Some(&BARRIER)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::sleeps;

    fn code(halves: &[u16]) -> Vec<u8> {
        halves.iter().flat_map(|half| half.to_le_bytes()).collect()
    }

    #[test]
    fn a_sleep_wants_its_barrier_at_once() {
        // wfe; isb; b .-6
        assert_eq!(
            sleeps(&code(&[0xBF20, 0xF3BF, 0x8F6F, 0xE7FB])),
            [(0, true)]
        );
        // wfi; b .-2; wfe, the last instruction
        assert_eq!(
            sleeps(&code(&[0xBF30, 0xE7FD, 0xBF20])),
            [(0, false), (4, false)]
        );
        // wfi; dsb
        assert_eq!(sleeps(&code(&[0xBF30, 0xF3BF, 0x8F4F])), [(0, false)]);
    }

    #[test]
    fn the_second_half_of_an_instruction_is_no_sleep() {
        // ldr.w r11, [r0, #0xF20]; bx lr
        assert_eq!(sleeps(&code(&[0xF8D0, 0xBF20, 0x4770])), []);
    }
}
