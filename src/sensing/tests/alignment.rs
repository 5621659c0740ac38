use super::Noise;
use super::free::{FIRST, Life, WORLDS, curve, geared};
use super::friction::{TRAVEL, block, record};
use crate::sensing::Drive;
use crate::sensing::friction::{Aligned, Alignment, BINS, Friction, HARMONICS};

/// Blocks of a closing on the scale of another zero, `shift` counts from the record's, until the alignment has an answer.
fn align(friction: &Friction, shift: i32, life: &mut Life, extra: impl Fn(i32) -> f64) -> Aligned {
    let mut alignment = Alignment::default();
    for index in FIRST..200 {
        let mut block = life.block(Drive::Closing, index, extra(1024 * index));
        let counts = f64::from(block.counts);
        block.drive_torque_nm += (curve(counts + f64::from(shift)) - curve(counts)) as f32;
        let told = alignment.push(friction, &block, &geared());
        if told != Aligned::Pending {
            return told;
        }
    }
    Aligned::Pending
}

#[test]
fn a_record_is_found_again_at_any_shift_as_well_as_it_says() {
    let (mut squares, mut count) = (0.0, 0.0);
    for world in WORLDS {
        for (seed, shift) in (0..).zip([-5200, -3000, -1000, -170, 0, 330, 1200, 2500, 5200]) {
            // A level that is off, as after a change of temperature, is no shift.
            for level in [0.0, 0.004, -0.004] {
                let mut life = Life::new(world, seed);
                let friction = life.record();
                let told = align(&friction, shift, &mut life, |_| level);
                let Aligned::By {
                    counts,
                    sigma_counts,
                } = told
                else {
                    panic!("{world:?} {shift}: {told:?}");
                };
                let z = f64::from(counts - shift) / f64::from(sigma_counts);
                assert!(
                    z.abs() < 5.0,
                    "{world:?} {counts} +- {sigma_counts} instead of {shift}"
                );
                squares += z * z;
                count += 1.0;
            }
        }
    }
    let rms: f64 = f64::sqrt(squares / count);
    assert!((0.5..1.6).contains(&rms), "{rms}");
}

#[test]
fn what_is_no_free_motion_fits_nowhere() {
    let mut life = Life::new(WORLDS[1], 3);
    let friction = life.record();
    let pressing = |counts: i32| 0.1 * f64::from((counts - 20_000).max(0)) / 20_000.0;
    let told = align(&friction, 500, &mut life, pressing);
    assert!(
        matches!(told, Aligned::Nowhere { misfit_nm } if misfit_nm > 0.001),
        "{told:?}"
    );
    // A number that is none is no block.
    for nonsense in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let told = align(&friction, 0, &mut life, |_| nonsense);
        assert_eq!(told, Aligned::Pending);
    }
    let spike = |counts: i32| {
        if counts == 1024 * 30 {
            f64::from(f32::MAX)
        } else {
            0.0
        }
    };
    let told = align(&friction, 0, &mut life, spike);
    assert!(
        matches!(told, Aligned::Nowhere { misfit_nm } if misfit_nm.is_finite()),
        "{told:?}"
    );
    // Off the record nothing is compared.
    let empty = Friction::empty(TRAVEL, &geared());
    assert_eq!(align(&empty, 0, &mut life, |_| 0.0), Aligned::Pending);
}

#[test]
fn friction_without_a_ripple_is_taken_as_it_lies() {
    // Nothing tells the shift: what homings differ by usually counts, and the record is not refused.
    let mut friction = record(1e-3, 3);
    friction.closing_nm.mean = [0.17; BINS];
    friction.worm_nm = [0.0; 2 * HARMONICS];
    for shift in [-2000, 0, 2000] {
        let mut alignment = Alignment::default();
        let mut noise = Noise(7);
        let told = (FIRST..200).find_map(|index| {
            let torque_nm = 0.17 + 1e-3 * noise.normal();
            let block = block(Drive::Closing, 1024 * index + shift, torque_nm);
            let told = alignment.push(&friction, &block, &geared());
            (told != Aligned::Pending).then_some(told)
        });
        let Some(Aligned::By { counts: found, .. }) = told else {
            panic!("{shift}: {told:?}");
        };
        // 8 mrad are 1670 counts.
        assert!(found.abs() <= 1670, "{found}");
    }
}
