//! What a function uses: functions that it calls or jumps to at fixed places, and statics that it names.

use std::collections::BTreeSet;

use crate::image::FLASH;
use crate::thumb::{self, Flow};
use crate::{Image, Symbol};

/// Everything that is used from the function at `address`, itself included. Calls through pointers are not followed.
pub fn from(image: &Image, address: u32) -> Vec<&Symbol> {
    let mut found = BTreeSet::new();
    let mut open = vec![address & !1];
    while let Some(symbol) = open.pop().and_then(|address| image.symbol_at(address)) {
        if found.insert(symbol.address) && symbol.is_code {
            open.extend(
                references(symbol.address, image.code(symbol))
                    .into_iter()
                    .filter(|&to| image.symbol_at(to).is_some()),
            );
        }
    }
    let symbol = |address: &u32| image.symbol_at(*address);
    found.iter().filter_map(symbol).collect()
}

/// Addresses that a function's code names: BL and B.W, MOVW with MOVT, and words (literals).
pub fn references(start: u32, code: &[u8]) -> Vec<u32> {
    let half = |at: usize| -> u32 {
        code.get(at..at + 2)
            .map_or(0, |two| u32::from(u16::from_le_bytes([two[0], two[1]])))
    };
    let mut found = Vec::new();
    // Lower halves that MOVW has put into registers.
    let mut low = [0u32; 16];
    let mut at = 0;
    while at + 1 < code.len() {
        let first = half(at);
        if thumb::length(first as u16) == 2 {
            at += 2;
            continue;
        }
        let second = half(at + 2);
        let immediate16 =
            (first & 0xF) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xFF;
        let register = (second >> 8 & 0xF) as usize;
        if first & 0xF800 == 0xF000 && second & 0x9000 == 0x9000 {
            // BL and B.W.
            if let Flow::To(target) = thumb::flow32(first as u16, second as u16, start + at as u32)
            {
                found.push(target);
            }
        } else if first & 0xFBF0 == 0xF240 && second & 0x8000 == 0 {
            low[register] = immediate16;
        } else if first & 0xFBF0 == 0xF2C0 && second & 0x8000 == 0 {
            found.push((immediate16 << 16 | low[register]) & !1);
        }
        at += 4;
    }
    // Literal pools: words that are addresses in flash. A misread instruction pair is no address of a symbol's start.
    for word in code.chunks_exact(4) {
        let value = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        if FLASH.contains(&value) {
            found.push(value & !1);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::references;

    #[test]
    fn calls_forwards_and_backwards() {
        // bl +0x100 at 0x0800_0000: offset 0xFC after the pipeline's 4.
        let forwards = [0x00, 0xF0, 0x7E, 0xF8];
        assert_eq!(references(0x0800_0000, &forwards), [0x0800_0100]);
        // b.w to itself: offset -4.
        let itself = [0xFF, 0xF7, 0xFE, 0xBF];
        assert_eq!(references(0x0800_0200, &itself), [0x0800_0200]);
    }

    #[test]
    fn an_address_in_two_halves() {
        // movw r0, #0x1234; movt r0, #0x0800
        let code = [0x41, 0xF2, 0x34, 0x20, 0xC0, 0xF6, 0x00, 0x00];
        assert_eq!(references(0x0800_0000, &code), [0x0800_1234]);
    }
}
