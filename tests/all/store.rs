//! The record in flash, with the power cut at every operation, bits flipped, and thousands of saves.

use crate::flash::{Bench, Cut, Flash, Random, StoredRecord};
use palpate::app::storage::store::{PAGE, PAGES, RECORD_MAX, StoreError, WORD};

/// Length of a record with a friction table, and of one without.
const LONG: usize = 1310;
const SHORT: usize = 60;
/// Outcomes tried of each operation that is cut short.
const OUTCOMES: u64 = 6;

/// The `n`th record: no two are alike.
fn record(n: u64, length: usize) -> Vec<u8> {
    let mut random = Random(n);
    let mut bytes: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
    bytes[..8].copy_from_slice(&n.to_le_bytes());
    bytes
}

/// Flash after some saves.
fn filled(saves: u64, length: usize) -> Flash {
    let mut bench = Bench::new(Flash::blank());
    for n in 0..saves {
        bench.save(&record(n, length)).unwrap();
    }
    let mut flash = bench.flash();
    flash.power_on();
    flash
}

/// Every way of cutting an action short at each of its operations, until it ends by itself.
fn every_cut(flash: &Flash, mut action: impl FnMut(Flash) -> bool) -> usize {
    for operation in 0.. {
        let cuts = (0..OUTCOMES).map(|seed| Cut::During(Random(seed << 32 | operation as u64)));
        let mut ended = false;
        for cut in std::iter::once(Cut::Before).chain(cuts) {
            ended = action(flash.clone().cut_at(operation, cut));
        }
        if ended {
            return operation;
        }
    }
    unreachable!()
}

/// What a power cut during a save may leave: the old record or the new one. Then the next save must succeed.
fn old_or_new(mut flash: Flash, old: &StoredRecord, new: &[u8], length: usize) -> bool {
    flash.power_on();
    let mut bench = Bench::new(flash);
    let found = bench.load();
    assert_eq!(bench.flash().operations, 0, "looking changes nothing");
    let is_new = found == StoredRecord::Record(new.to_vec(), true);
    let is_old = match (old, &found) {
        (StoredRecord::Record(old, _), StoredRecord::Record(found, _)) => old == found,
        (StoredRecord::Nothing, StoredRecord::Nothing | StoredRecord::Unreadable) => true,
        _ => false,
    };
    assert!(is_new || is_old, "{found:?}");
    let next = record(u64::MAX, length);
    bench.save(&next).unwrap();
    assert_eq!(bench.load(), StoredRecord::Record(next, true));
    is_new
}

#[test]
fn a_power_cut_at_any_operation_of_a_save_leaves_the_old_record_or_the_new() {
    let mut cuts = 0;
    for length in [SHORT, LONG] {
        // Blank, the first page, the ring begun and gone round, the last page and the first.
        for saves in [0, 1, 2, 3, 4, 5, 8, 9, 200] {
            let flash = filled(saves, length);
            let old = Bench::new(flash.clone()).load();
            let new = record(saves, length);
            let (mut olds, mut news) = (0, 0);
            cuts += every_cut(&flash, |flash| {
                let mut bench = Bench::new(flash);
                let saved = bench.save(&new).is_ok();
                let is_new = old_or_new(bench.flash(), &old, &new, length);
                assert!(is_new || !saved, "said to be saved, and is not");
                *(if is_new { &mut news } else { &mut olds }) += 1;
                saved
            });
            assert!(olds > 30 && news > 0);
        }
    }
    println!("{cuts} operations cut, each {} ways", OUTCOMES + 1);
    assert!(cuts > 1500);
}

#[test]
fn a_power_cut_in_the_save_after_one_that_was_cut_short_loses_nothing_either() {
    let old = StoredRecord::Record(record(8, SHORT), true);
    let (first, second) = (record(9, SHORT), record(10, SHORT));
    every_cut(&filled(9, SHORT), |flash| {
        let mut bench = Bench::new(flash);
        let saved = bench.save(&first).is_ok();
        let mut torn = bench.flash();
        torn.power_on();
        let before = Bench::new(torn.clone()).load();
        assert!(
            before == StoredRecord::Record(first.clone(), true)
                || matches!((&before, &old), (StoredRecord::Record(found, _), StoredRecord::Record(old, _)) if found == old)
        );
        every_cut(&torn, |flash| {
            let mut bench = Bench::new(flash);
            let saved = bench.save(&second).is_ok();
            old_or_new(bench.flash(), &before, &second, SHORT);
            saved
        });
        saved
    });
}

#[test]
fn a_thousand_saves_with_the_power_cut_at_random() {
    let mut random = Random(42);
    let mut flash = Flash::blank();
    let mut last = StoredRecord::Nothing;
    let mut cuts = 0;
    for n in 0..1000 {
        let length = if random.next().is_multiple_of(3) {
            SHORT
        } else {
            LONG
        };
        let new = record(n, length);
        // Now and then so late that the save is over.
        let cut = match random.next() % 4 {
            0 => Cut::Before,
            _ => Cut::During(Random(random.next())),
        };
        flash = flash.cut_at(random.below(200), cut);
        let mut bench = Bench::new(flash);
        let saved = bench.save(&new).is_ok();
        cuts += u32::from(!saved);
        flash = bench.flash();
        flash.power_on();
        let mut bench = Bench::new(flash);
        let found = bench.load();
        let is_new = matches!(&found, StoredRecord::Record(bytes, _) if *bytes == new);
        let is_old = match (&last, &found) {
            (StoredRecord::Record(old, _), StoredRecord::Record(bytes, _)) => old == bytes,
            (StoredRecord::Nothing, StoredRecord::Nothing | StoredRecord::Unreadable) => true,
            _ => false,
        };
        assert!(is_new || (is_old && !saved), "save {n}: {found:?}");
        if is_new {
            last = found;
        }
        flash = bench.flash();
    }
    assert!((300..1000).contains(&cuts), "{cuts}");
}

#[test]
fn a_power_cut_while_forgetting_leaves_the_record_or_nothing() {
    for saves in [1, 2, 8, 20] {
        for length in [SHORT, LONG] {
            let flash = filled(saves, length);
            let old = record(saves - 1, length);
            let (mut kept, mut gone) = (0, 0);
            every_cut(&flash, |flash| {
                let mut bench = Bench::new(flash);
                let forgot = bench.forget().is_ok();
                let mut flash = bench.flash();
                flash.power_on();
                let mut bench = Bench::new(flash);
                match bench.load() {
                    StoredRecord::Nothing => gone += 1,
                    StoredRecord::Record(bytes, _) if bytes == old && !forgot => kept += 1,
                    other => panic!("{other:?}"),
                }
                bench.save(&old).unwrap();
                assert_eq!(bench.load(), StoredRecord::Record(old.clone(), true));
                forgot
            });
            assert!(kept > 0 && gone > 0);
        }
    }
}

#[test]
fn a_single_flipped_bit_is_never_used() {
    let flash = filled(2, LONG);
    let (last, before) = (record(1, LONG), record(0, LONG));
    let mut older = 0;
    // The page of the last record, the one before it and the blank one behind.
    for bit in 0..3 * PAGE * 8 {
        let mut damaged = flash.clone();
        damaged.flip(bit);
        match Bench::new(damaged).load() {
            StoredRecord::Record(bytes, true) => assert_eq!(bytes, last, "bit {bit}"),
            StoredRecord::Record(bytes, false) if bytes == before => older += 1,
            // Behind the record something seems to have begun.
            StoredRecord::Record(bytes, false) => {
                assert!(bytes == last && bit >= 2 * PAGE * 8, "bit {bit}");
            }
            other => panic!("bit {bit}: {other:?}"),
        }
    }
    // Every bit of number, record, length and checksum.
    assert_eq!(older, (4 + LONG + WORD) * 8);
}

#[test]
fn whatever_bits_are_flipped_a_record_is_whole_or_reported_and_the_next_save_works() {
    let mut random = Random(7);
    let (mut last, mut older, mut unreadable) = (0, 0, 0);
    for run in 0..3000 {
        let saves = 1 + random.next() % 12;
        let length = [SHORT, LONG][run % 2];
        let mut flash = filled(saves, length);
        // From one bit to one in six.
        let flips = 1 << (random.next() % 15);
        for _ in 0..flips {
            let bit = random.below(PAGES * PAGE * 8);
            flash.flip(bit);
        }
        let mut bench = Bench::new(flash);
        match bench.load() {
            StoredRecord::Record(bytes, newest) => {
                let n = u64::from_le_bytes(bytes[..8].try_into().unwrap());
                assert!(n < saves && bytes == record(n, length), "run {run}");
                assert!(!newest || n == saves - 1, "run {run}, {flips} bits");
                *(if newest { &mut last } else { &mut older }) += 1;
            }
            StoredRecord::Nothing => panic!("run {run}"),
            StoredRecord::Unreadable => unreadable += 1,
        }
        let next = record(u64::MAX, length);
        bench.save(&next).unwrap();
        assert_eq!(bench.load(), StoredRecord::Record(next, true), "run {run}");
    }
    println!("last {last}, older {older}, unreadable {unreadable}");
    assert!(last > 100 && older > 100 && unreadable > 100);
}

#[test]
fn a_word_that_reads_as_erased_and_is_not_does_not_stop_a_save() {
    for length in [SHORT, LONG] {
        let flash = filled(3, length);
        let blank: Vec<usize> = (0..PAGES * PAGE / WORD)
            .filter(|&word| flash.is_blank(word))
            .collect();
        for word in blank {
            let mut weak = flash.clone();
            weak.touch(word);
            let mut bench = Bench::new(weak);
            let new = record(3, length);
            bench.save(&new).unwrap();
            assert_eq!(bench.load(), StoredRecord::Record(new, true), "word {word}");
        }
    }
}

#[test]
fn wear_is_level() {
    for length in [SHORT, LONG] {
        let mut bench = Bench::new(Flash::blank());
        for n in 0..4000 {
            bench.save(&record(n, length)).unwrap();
        }
        let erases = bench.flash().erases;
        let (least, most) = (erases.iter().min().unwrap(), erases.iter().max().unwrap());
        println!("{length} bytes: {erases:?} erases in 4000 saves");
        assert!(most - least <= 1, "{erases:?}");
    }
}

#[test]
fn what_does_not_fit_is_said_and_harms_nothing() {
    let mut bench = Bench::new(filled(4, LONG));
    let last = StoredRecord::Record(record(3, LONG), true);
    for length in [RECORD_MAX + 1, PAGE, 5000] {
        assert_eq!(
            bench.save(&vec![1; length]),
            Err(StoreError::TooLong),
            "{length}"
        );
        assert_eq!(bench.load(), last);
    }
    let longest = vec![1; RECORD_MAX];
    bench.save(&longest).unwrap();
    assert_eq!(bench.load(), StoredRecord::Record(longest, true));
    assert_eq!(
        Bench::new(Flash::blank()).load(),
        StoredRecord::Nothing,
        "never saved"
    );
}

#[test]
fn a_page_that_is_worn_out_is_passed_over() {
    for (worn, is_told) in (0..PAGES).flat_map(|page| [(page, false), (page, true)]) {
        // Whether it holds the last record, the one before, or is where the next save would go.
        let mut flash = filled(2, LONG);
        if is_told {
            flash.refused = Some(worn);
        } else {
            flash.stuck = Some(worn);
        }
        let mut bench = Bench::new(flash);
        for n in 2..30 {
            bench.save(&record(n, LONG)).unwrap();
            match bench.load() {
                StoredRecord::Record(bytes, _) => assert_eq!(bytes, record(n, LONG)),
                other => panic!("page {worn}, save {n}: {other:?}"),
            }
        }
    }
}

#[test]
fn a_power_cut_beside_a_page_that_is_worn_out_leaves_the_old_record_or_the_new() {
    for stuck in 0..PAGES {
        let mut flash = filled(2, SHORT);
        flash.stuck = Some(stuck);
        let mut bench = Bench::new(flash);
        // Gone round the ring.
        for n in 2..8 {
            bench.save(&record(n, SHORT)).unwrap();
        }
        let mut flash = bench.flash();
        flash.power_on();
        let bytes = |flash: &mut Flash| {
            flash.power_on();
            match Bench::new(flash.clone()).load() {
                StoredRecord::Record(bytes, _) => bytes,
                other => panic!("page {stuck}: {other:?}"),
            }
        };
        let (old, new, next) = (record(7, SHORT), record(8, SHORT), record(9, SHORT));
        every_cut(&flash, |flash| {
            let mut bench = Bench::new(flash);
            let saved = bench.save(&new).is_ok();
            let mut flash = bench.flash();
            let found = bytes(&mut flash);
            assert!(found == new || found == old && !saved, "page {stuck}");
            let mut bench = Bench::new(flash);
            bench.save(&next).unwrap();
            assert_eq!(bytes(&mut bench.flash()), next, "page {stuck}");
            saved
        });
    }
}

#[test]
fn forgetting_passes_over_a_page_that_is_worn_out() {
    for stuck in 0..PAGES {
        let mut flash = filled(3, LONG);
        flash.stuck = Some(stuck);
        let mut bench = Bench::new(flash);
        bench.forget().unwrap();
        assert_eq!(bench.load(), StoredRecord::Nothing, "page {stuck}");
    }
}

/// Cut short again and again, while erasing more often than not, so that pages without a whole record go round the ring.
#[test]
fn saves_that_never_end_lose_nothing() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let saves = 2 + seed % 9;
        let mut flash = filled(saves, LONG);
        let mut last = record(saves - 1, LONG);
        for n in 1000..1300 {
            let new = record(n, LONG);
            let mut rehearsal = Bench::new(flash.clone());
            rehearsal.save(&new).unwrap();
            let rehearsed = rehearsal.flash();
            let erasing = &rehearsed.erasing;
            let operation = if erasing.is_empty() || random.next().is_multiple_of(3) {
                random.below(rehearsed.operations)
            } else {
                erasing[random.below(erasing.len())]
            };
            // Then the erasing of the next try, too.
            for operation in [operation, 0] {
                flash = flash.cut_at(operation, Cut::During(Random(random.next())));
                let mut bench = Bench::new(flash);
                let _ = bench.save(&new);
                flash = bench.flash();
            }
            flash.power_on();
            let mut bench = Bench::new(flash);
            match bench.load() {
                StoredRecord::Record(bytes, _) if bytes == new || bytes == last => last = bytes,
                other => panic!("seed {seed}, save {n}: {other:?}"),
            }
            flash = bench.flash();
            flash.power_on();
        }
    }
}
