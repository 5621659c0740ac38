use super::Noise;
use super::free::{BLOCKS, FIRST, assess, curve, geared};
use crate::sensing::block::Block;
use crate::sensing::friction::{Assessment, Friction, HARMONICS, Pass};
use crate::sensing::{Drive, sensor};

pub(super) const TRAVEL: i32 = 312_890;

pub(super) fn block(drive: Drive, counts: i32, torque_nm: f32) -> Block {
    Block {
        emf_v: f32::NAN,
        time_us: 0,
        drive,
        counts,
        width_counts: 1024,
        way_counts: i32::MAX,
        duration_s: 0.0164,
        drive_torque_nm: torque_nm,
        inertia_nm: 0.0,
        overspeed: 0.0,
    }
}

/// Blocks of a pass as a function of the position has them.
fn pass_of(record: &Friction, drive: Drive, torque_nm: impl Fn(f64) -> f64) -> Pass {
    let mut pass = Pass::new(drive);
    for index in FIRST..FIRST + BLOCKS {
        let counts = 1024 * index + 512;
        let torque_nm = torque_nm(f64::from(counts)) as f32;
        // What is recorded is the closing's.
        let known = record.at(counts).filter(|_| drive == Drive::Closing);
        let known = known.map_or(0.0, |known| known.torque_nm);
        pass.push(record, counts, &block(drive, counts, torque_nm), known);
    }
    pass
}

pub(super) fn record(sigma: f64, seed: u64) -> Friction {
    let mut record = Friction::empty(TRAVEL, &geared());
    let noise = std::cell::RefCell::new(Noise(seed));
    let torque = |counts: f64| curve(counts) + sigma * f64::from(noise.borrow_mut().normal());
    let pass = pass_of(&record, Drive::Closing, torque);
    assess(pass, &mut record);
    record
}

#[test]
fn what_closing_takes_more_than_opening_is_found() {
    let mut record = Friction::empty(TRAVEL, &geared());
    let rad_per_count = f64::from(record.rad_per_count);
    let rad = |counts: f64| counts * rad_per_count;
    let more = |counts: f64| 0.02 * rad(counts).cos() - 0.03 * rad(counts).sin();
    let closing = pass_of(&record, Drive::Closing, |counts| {
        curve(counts) + more(counts)
    });
    assess(closing, &mut record);
    // What opens the finger is measured against the motion.
    let opening = pass_of(&record, Drive::Opening, |counts| -curve(counts));
    assess(opening, &mut record);
    for counts in middles() {
        let error = f64::from(record.asymmetry(counts)[0]) - more(f64::from(counts));
        assert!(error.abs() < 3e-4, "{counts}: {error}");
    }
}

fn middles() -> impl Iterator<Item = i32> {
    (1024 * (FIRST + 2)..1024 * (FIRST + BLOCKS - 4)).step_by(333)
}

#[test]
fn a_record_follows_the_friction() {
    let friction = record(0.0, 1);
    for counts in middles() {
        let error = f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 2e-4, "{counts}: {error}");
    }
    assert_eq!(friction.at(-1), None);
    assert_eq!(friction.at(TRAVEL), None);
    assert!(friction.is_valid());
    let speed = 1024.0 * geared().rad_per_count / 0.0164;
    assert!((friction.speed_rad_per_s / speed - 1.0).abs() < 1e-3);
}

/// Digits of the adjugate cancel most at the ends, where all bins lie on one side of the place.
#[test]
fn a_quadratic_is_kept_to_the_ends() {
    let mut record = Friction::empty(TRAVEL, &geared());
    (record.speed_rad_per_s, record.white_nm2_s) = (0.3, 1e-8);
    let bin = f64::from(record.bin_counts);
    let quadratic = |counts: f64| {
        let x = counts / f64::from(TRAVEL);
        0.055 + 0.03 * x - 0.1 * x * x
    };
    for index in 5..100 {
        record.closing_nm.mean[index] = quadratic((index as f64 + 0.5) * bin) as f32;
        record.closing_nm.count[index] = 3;
    }
    for counts in ((5.5 * bin) as i32 + 1..(99.5 * bin) as i32).step_by(37) {
        let found = f64::from(record.at(counts).unwrap().torque_nm);
        let off = found - quadratic(f64::from(counts));
        assert!(off.abs() < 1e-5 * 0.055, "{counts}: {off}");
    }
    // Two bins only have a mean, one its own value.
    record.closing_nm.count[7..].fill(0);
    let middle = record.at((6.0 * bin) as i32).unwrap().torque_nm;
    assert!((middle - 0.5 * (record.closing_nm.mean[5] + record.closing_nm.mean[6])).abs() < 1e-6);
    record.closing_nm.count[6] = 0;
    let alone = record.at((5.5 * bin) as i32).unwrap().torque_nm;
    assert!((alone - record.closing_nm.mean[5]).abs() < 1e-8);
}

#[test]
fn its_deviation_is_told_truly() {
    let (mut square, mut count, mut told) = (0.0, 0.0, 0.0);
    for seed in 0..60 {
        let friction = record(1.4e-3, 100 + seed);
        for counts in middles().step_by(40) {
            let known = friction.at(counts).unwrap();
            let error = f64::from(known.torque_nm) - curve(f64::from(counts));
            square += error * error / f64::from(known.variance_nm2);
            told += f64::from(known.variance_nm2);
            count += 1.0;
        }
    }
    // The curve itself bends within the smoothing; the record is four times as sharp as a block.
    let rms = (square / count).sqrt();
    assert!((0.75..1.25).contains(&rms), "{rms}");
    assert!((told / count).sqrt() < 1.4e-3 / 3.0);
}

#[test]
fn beyond_its_end_friction_goes_on_with_the_worm() {
    let friction = record(0.0, 1);
    for counts in (TRAVEL..TRAVEL + 40_000).step_by(1000) {
        let found = friction.beyond(counts).unwrap();
        assert!(found.beyond_counts > 0.0);
        let error = f64::from(found.torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 2e-3, "{counts}: {error}");
    }
    // A spring of the finger pulls on beyond.
    let spring = |counts: f64| curve(counts) + 1e-6 * counts;
    let mut sprung = Friction::empty(TRAVEL, &geared());
    assess(pass_of(&sprung, Drive::Closing, spring), &mut sprung);
    for counts in (TRAVEL..TRAVEL + 40_000).step_by(1000) {
        let error = f64::from(sprung.beyond(counts).unwrap().torque_nm) - spring(f64::from(counts));
        assert!(error.abs() < 2e-3, "{counts}: {error}");
    }
    // Before its beginning nothing was steady.
    assert_eq!(friction.beyond(5000), None);
    assert_eq!(Friction::empty(TRAVEL, &geared()).beyond(1000), None);
}

#[test]
fn what_is_not_free_is_left_out() {
    let mut friction = record(1e-3, 1);
    let before = friction.clone();
    // Slowing down in the last two blocks.
    let stop = f64::from(1024 * (FIRST + BLOCKS - 2));
    let slowing = |counts: f64| curve(counts) * if counts > stop { 0.0 } else { 1.0 };
    assess(pass_of(&before, Drive::Closing, slowing), &mut friction);
    // A contact that begins at 200,000 counts, cut off in time.
    let contact = |counts: f64| curve(counts) + 3e-6 * (counts - 200_000.0).max(0.0);
    let mut pass = pass_of(&friction, Drive::Closing, contact);
    pass.cut(&friction, 198_000);
    assess(pass, &mut friction);
    // Nonsense.
    let pass = pass_of(&friction, Drive::Closing, |_| f64::NAN);
    assert!(Assessment::new(pass, &friction).is_none());
    for counts in middles() {
        let error = f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 8e-4, "{counts}: {error}");
    }
    assert_eq!(friction.passes(), 3);
}

#[test]
fn a_pass_that_ends_early_leaves_no_step() {
    let mut friction = record(0.0, 1);
    // Friction has risen by 5 %, and the closing ends half way.
    let mut pass = pass_of(&friction, Drive::Closing, |counts| curve(counts) + 8e-3);
    pass.cut(&friction, 190_000);
    assess(pass, &mut friction);
    let shift =
        |counts: i32| f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
    for counts in middles() {
        assert!(
            (shift(counts) - 4e-3).abs() < 2e-4,
            "{counts}: {}",
            shift(counts)
        );
    }
}

/// The recording has a gap, by an interruption; later closings cover it.
#[test]
fn a_gap_in_the_recording_is_not_filled_with_a_difference() {
    let mut friction = Friction::empty(TRAVEL, &geared());
    let gap = 150_000.0..165_000.0;
    let broken = |counts: f64| {
        if gap.contains(&counts) {
            f64::NAN
        } else {
            curve(counts)
        }
    };
    assess(pass_of(&friction, Drive::Closing, broken), &mut friction);
    for _ in 0..2 {
        assess(pass_of(&friction, Drive::Closing, curve), &mut friction);
    }
    for counts in middles() {
        let error = f64::from(friction.at(counts).unwrap().torque_nm) - curve(f64::from(counts));
        assert!(error.abs() < 3e-3, "{counts}: {error}");
    }
}

#[test]
fn a_pass_that_is_too_short_teaches_nothing() {
    let friction = record(1e-3, 1);
    let mut pass = pass_of(&friction, Drive::Closing, curve);
    pass.cut(&friction, 60_000);
    assert!(Assessment::new(pass, &friction).is_none());
    assert!(Assessment::new(Pass::new(Drive::Closing), &friction).is_none());
}

#[test]
fn a_record_with_nonsense_in_it_is_not_valid() {
    let friction = record(1e-3, 9);
    assert!(friction.is_valid());
    let damages: [fn(&mut Friction); 6] = [
        |friction| friction.closing_nm.mean[3] = f32::NAN,
        |friction| friction.white_nm2_s = -1.0,
        |friction| friction.worm_nm[2 * HARMONICS - 1] = f32::INFINITY,
        |friction| friction.evidence.ln_likelihood[0] = f32::NAN,
        |friction| friction.speed_rad_per_s = 0.0,
        |friction| friction.bin_counts = 0,
    ];
    for damage in damages {
        let mut damaged = friction.clone();
        damage(&mut damaged);
        assert!(!damaged.is_valid());
    }
    assert!(
        size_of::<sensor::Sensor<crate::finger::Finger<2, crate::finger::Tendon<2>>>>() < 10_240
    );
}
