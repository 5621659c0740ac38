// SPDX-License-Identifier: GPL-2.0-only
//! Tests of the flash memory and its controller.

use super::*;

fn unlocked() -> Flash {
    let mut flash = Flash::new(vec![0xFF; FLASH_SIZE], Quirks::default());
    flash.write(KEYR, 0x4567_0123, 0).unwrap();
    flash.write(KEYR, 0xCDEF_89AB, 0).unwrap();
    flash
}

#[test]
fn programs_an_erased_double_word_once() {
    let mut flash = unlocked();
    flash.write(CR, PG, 0).unwrap();
    assert_eq!(flash.store(0x1_C000, 4, 0x1234_5678, 0), 0);
    assert_eq!(flash.store(0x1_C004, 4, 0x9ABC_DEF0, 0), PROGRAM);
    assert_eq!(
        flash.image[0x1_C000..0x1_C008],
        0x9ABC_DEF0_1234_5678_u64.to_le_bytes()
    );
    assert_eq!(flash.read(SR, 1).unwrap(), BSY);
    flash.store(0x1_C000, 4, 0, 2 * PROGRAM);
    flash.store(0x1_C004, 4, 1, 2 * PROGRAM);
    assert_eq!(flash.read(SR, 2 * PROGRAM).unwrap(), PROGERR | OPERR);
    assert_eq!(flash.operations.len(), 1);
    flash.write(SR, PROGERR | OPERR, 2 * PROGRAM).unwrap();
    flash.store(0x1_C000, 4, 0, 2 * PROGRAM);
    flash.store(0x1_C004, 4, 0, 2 * PROGRAM);
    assert_eq!(
        flash.image[0x1_C000..0x1_C008],
        [0; 8],
        "all zero may be written over old data"
    );
}

#[test]
fn refuses_what_the_chip_refuses() {
    let mut locked = Flash::new(vec![0xFF; FLASH_SIZE], Quirks::default());
    locked.store(0, 4, 0, 0);
    assert_ne!(locked.read(SR, 0).unwrap() & PGSERR, 0);
    locked.write(KEYR, 1, 0).unwrap();
    locked.write(KEYR, 0x4567_0123, 0).unwrap();
    locked.write(KEYR, 0xCDEF_89AB, 0).unwrap();
    assert_ne!(
        locked.read(CR, 0).unwrap() & LOCK,
        0,
        "a wrong key locks until reset"
    );
    for (offset, size, flag) in [
        (0x1_C000, 2, SIZERR),
        (0x1_C002, 4, PGAERR),
        (0x1_C004, 4, PGAERR),
    ] {
        let mut flash = unlocked();
        flash.write(CR, PG, 0).unwrap();
        flash.store(offset, size, 0, 0);
        assert_ne!(flash.read(SR, 0).unwrap() & flag, 0, "{offset:#x} {size}");
        assert!(flash.operations.is_empty());
    }
}

#[test]
fn erases_a_page_and_stalls() {
    let mut flash = unlocked();
    flash.image.fill(0x55);
    assert_eq!(flash.write(CR, PER | 60 << 3 | STRT, 0), Ok(ERASE));
    assert!(
        flash.image[60 * PAGE_SIZE..61 * PAGE_SIZE]
            .iter()
            .all(|&b| b == 0xFF)
    );
    assert!(flash.image[61 * PAGE_SIZE..].iter().all(|&b| b == 0x55));
}

#[test]
fn a_bad_double_word_tells_when_it_is_read() {
    let mut flash = unlocked();
    flash.image.fill(0x55);
    flash.flip(64 * 3);
    assert_eq!(flash.image[24], 0x55, "corrected");
    assert!(!flash.load(24));
    assert_eq!(flash.read(ECCR, 0).unwrap(), ECCC | 24);
    flash.write(ECCR, ECCC, 0).unwrap();
    flash.flip(64 * 3 + 9);
    assert!(flash.load(28));
    assert_eq!(flash.read(ECCR, 0).unwrap(), ECCD | 24);
    assert_eq!((flash.image[24], flash.image[25]), (0x54, 0x57));
}

#[test]
fn a_cut_operation_is_undone_half_done_or_done() {
    for (cut, expected) in [
        (PowerCut::Before, Some(0x55)),
        (PowerCut::During, None),
        (PowerCut::After, Some(0xFF)),
    ] {
        let mut flash = unlocked();
        flash.image.fill(0x55);
        flash.cut = Some((0, cut));
        flash.write(CR, PER | 60 << 3 | STRT, 0).unwrap();
        assert!(flash.power_lost);
        let page = &flash.image[60 * PAGE_SIZE..61 * PAGE_SIZE];
        match expected {
            Some(value) => assert!(page.iter().all(|&b| b == value)),
            None => {
                assert!(page.iter().all(|&b| b & 0x55 == 0x55) && page.iter().any(|&b| b != 0x55))
            }
        }
    }
}
