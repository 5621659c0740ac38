//! The torque constant from synthetic blocks of motors that are off.

use super::drivetrain;
use super::friction;
use crate::sensing::block::Block;
use crate::sensing::torque_constant::{
    BRIDGE_SIGMA_V, ConstantShift, IMPLAUSIBLE, RESISTANCE_SIGMA, TorqueConstant,
};
use crate::sensing::{Drive, Drivetrain};
use proptest::prelude::*;

/// What is off in a motor: constant and resistance as shares, the bridge in volt.
#[derive(Clone, Copy, Debug)]
struct Off {
    constant: f32,
    resistance: f32,
    bridge_v: f32,
}

/// A block of a motor that differs from the nominal one.
fn block(drive: Drive, rad_per_s: f32, current_a: f32, off: Off) -> Block {
    let sign = if drive == Drive::Opening { -1.0 } else { 1.0 };
    let width_counts = drivetrain().counts_per_turn;
    let nominal_v = drivetrain().torque_per_ampere_nm * rad_per_s;
    let emf_v = nominal_v * (1.0 + off.constant)
        + off.resistance * drivetrain().resistance_ohm * current_a
        + off.bridge_v;
    Block {
        drive,
        width_counts,
        duration_s: width_counts as f32 * drivetrain().rad_per_count / rad_per_s,
        drive_torque_nm: sign * drivetrain().torque_per_ampere_nm * current_a,
        emf_v: sign * emf_v,
        ..friction::block(drive, 0, 0.0)
    }
}

/// Closes with a friction that takes 15 mA, up to a current; opens twice as fast before, or not.
fn closing(off: Off, top_a: f32, opens: bool) -> ConstantShift {
    let mut constant = TorqueConstant::default();
    for _ in 0..300 {
        if opens {
            constant.push(&block(Drive::Opening, 0.6, 0.017, off), &drivetrain());
        }
        constant.push(&block(Drive::Closing, 0.3, 0.015, off), &drivetrain());
    }
    for step in 0..60 {
        let current_a = 0.015 + (top_a - 0.015) * step as f32 / 60.0;
        constant.push(&block(Drive::Closing, 0.3, current_a, off), &drivetrain());
    }
    constant.shift(&drivetrain())
}

#[test]
fn two_speeds_and_a_rise_tell_it() {
    for constant in [-0.1, -0.03, 0.0, 0.08] {
        let off = Off {
            constant,
            resistance: 0.2,
            bridge_v: -0.4,
        };
        let found = closing(off, 0.12, true);
        assert!((found.share - constant).abs() < 3e-3, "{off:?} {found:?}");
        assert!(found.variance > 0.98 * drivetrain().torque_constant_sigma.powi(2));
    }
}

/// Hundreds of grasps, closing as fast as opening, where sums without end were their own rounding.
#[test]
fn hundreds_of_grasps_tell_no_less_than_some() {
    let off = Off {
        constant: 0.04,
        resistance: 0.1,
        bridge_v: -0.1,
    };
    let mut constant = TorqueConstant::default();
    let mut state = 1u32;
    let mut push = |constant: &mut TorqueConstant, drive: Drive, current_a: f32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (state >> 8) as f32 / (1 << 24) as f32 - 0.5;
        let mut block = block(drive, 0.6, current_a, off);
        block.emf_v *= 1.0 + 0.06 * noise;
        constant.push(&block, &drivetrain());
    };
    let mut after = |grasps: usize| {
        for _ in 0..grasps {
            for _ in 0..300 {
                push(&mut constant, Drive::Opening, 0.017);
                push(&mut constant, Drive::Closing, 0.015);
            }
            for step in 0..30 {
                push(
                    &mut constant,
                    Drive::Closing,
                    0.015 + 0.1 * step as f32 / 30.0,
                );
            }
        }
        constant.shift(&drivetrain())
    };
    let (some, many) = (after(8), after(400));
    assert!((many.share - some.share).abs() < 3e-3, "{some:?} {many:?}");
    assert!(many.variance > 0.98 * some.variance, "{some:?} {many:?}");
}

#[test]
fn its_deviation_is_honest_whatever_has_been_seen() {
    let mut state = 1u32;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // One deviation of a uniform spread is 1.
        (state >> 8) as f32 / (1 << 24) as f32 * 3.464 - 1.732
    };
    for (top_a, opens) in [(0.015, false), (0.12, false), (0.015, true), (0.12, true)] {
        let prior = drivetrain().torque_constant_sigma * drivetrain().torque_constant_sigma;
        let (mut z2, mut left) = (0.0, 0.0);
        for _ in 0..500 {
            let off = Off {
                constant: uniform() * drivetrain().torque_constant_sigma,
                resistance: uniform() * RESISTANCE_SIGMA,
                bridge_v: uniform() * BRIDGE_SIGMA_V,
            };
            let found = closing(off, top_a, opens);
            // What the blocks' own noise, none here, would add is little.
            let variance = prior - found.variance;
            z2 += (found.share - off.constant).powi(2) / variance / 500.0;
            left += (variance / prior) / 500.0;
        }
        println!("up to {top_a} A, opening {opens}: mean z^2 {z2:.2}, variance left {left:.3}");
        assert!(z2 < 1.15, "{z2}");
        assert!(opens || z2 > 0.85, "{z2}");
        // One speed leaves half of the variance, two next to nothing.
        assert!(left < if opens { 0.05 } else { 0.5 }, "{left}");
    }
}

#[test]
fn what_tells_nothing_changes_nothing() {
    let off = Off {
        constant: 0.05,
        resistance: 0.0,
        bridge_v: 0.0,
    };
    let mut constant = TorqueConstant::default();
    assert_eq!(constant.shift(&drivetrain()), ConstantShift::default());
    let mut unknown = block(Drive::Closing, 0.3, 0.015, off);
    unknown.emf_v = f32::NAN;
    constant.push(&unknown, &drivetrain());
    assert_eq!(constant.shift(&drivetrain()), ConstantShift::default());
    // An encoder of another resolution, say: no motor is off by half.
    let absurd = Off {
        constant: 0.5,
        ..off
    };
    assert_eq!(closing(absurd, 0.12, true), ConstantShift::default());
    // A constant that was measured stays.
    let known = Drivetrain {
        torque_constant_sigma: 0.0,
        ..drivetrain()
    };
    constant.push(&block(Drive::Closing, 0.3, 0.015, off), &known);
    assert_eq!(constant.shift(&known), ConstantShift::default());
}

proptest! {
    #[test]
    fn any_blocks_leave_it_within_the_prior(bits in proptest::collection::vec(any::<[u32; 3]>(), 0..40)) {
        let mut constant = TorqueConstant::default();
        for [emf, torque, duration] in bits {
            let [emf_v, drive_torque_nm, duration_s] = [emf, torque, duration].map(f32::from_bits);
            let off = Off { constant: 0.0, resistance: 0.0, bridge_v: 0.0 };
            let any = Block { emf_v, drive_torque_nm, duration_s, ..block(Drive::Closing, 0.3, 0.0, off) };
            constant.push(&any, &drivetrain());
        }
        let found = constant.shift(&drivetrain());
        let prior = drivetrain().torque_constant_sigma * drivetrain().torque_constant_sigma;
        prop_assert!((0.0..=prior).contains(&found.variance), "{:?}", found);
        prop_assert!(found.share.abs() <= IMPLAUSIBLE * drivetrain().torque_constant_sigma, "{:?}", found);
    }
}
