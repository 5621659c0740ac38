//! A friction record and the encoder's zero, which homing finds somewhat elsewhere.

use super::*;
use crate::app::grasp::sensing::ContactSensing;
use crate::app::storage::record::Record;
use crate::sample::{Drive, Sample};

/// How much later than in the record the same turn of the worm is, radian.
const SHIFT_RAD: f32 = 0.02;

/// A free motion at 0.3 rad/s, and a pause; what the sensing tells.
fn moves(
    sensing: &mut ContactSensing<P70>,
    time_us: &mut u64,
    [from, to]: [f32; 2],
    shift_rad: f32,
) -> Vec<Event> {
    let rad_per_count = sensing.sensor().drivetrain().rad_per_count;
    let sign = (to - from).signum();
    let number = ((to - from).abs() / 0.3e-3) as u32;
    let samples = (0..number + 400).filter_map(|ms| {
        let angle = from + sign * 0.3e-3 * ms.min(number) as f32;
        let turns = ms < number;
        let friction_a = 0.015 + 0.001 * (20.0 * (angle + shift_rad)).cos();
        *time_us += 1000;
        sensing.sample(&Sample {
            emf_v: f32::NAN,
            time_us: *time_us,
            position_counts: (angle / rad_per_count) as i32,
            current_a: if turns { sign * friction_a } else { 0.0 },
            drive: match (turns, sign > 0.0) {
                (false, _) => Drive::Idle,
                (true, true) => Drive::Closing,
                (true, false) => Drive::Opening,
            },
            joint: (),
        })
    });
    samples.collect()
}

/// Whether a free closing whose zero has moved tells nothing but its stiffness.
fn is_aligned(sensing: &mut ContactSensing<P70>, time_us: &mut u64) -> bool {
    sensing.request(SensingRequest::Direct(Directive::Watch));
    let told = moves(sensing, time_us, [0.0, 1.4], SHIFT_RAD);
    matches!(told[..], [Event::Stiffness { .. }])
}

/// After a restart, and where counts were lost, the first closing aligns the record; a record of the same zero is not aligned, and does
/// not fit then.
#[test]
fn a_record_of_another_zero_is_aligned_by_the_next_closing() {
    let (mut sensing, mut time_us) = (ContactSensing::<P70>::new(), 0);
    sensing.request(SensingRequest::Direct(Directive::RecordFriction));
    moves(&mut sensing, &mut time_us, [0.0, 1.5], 0.0);
    moves(&mut sensing, &mut time_us, [1.5, 0.0], 0.0);
    sensing.request(SensingRequest::Direct(Directive::Watch));
    let told = moves(&mut sensing, &mut time_us, [0.0, 0.05], 0.0);
    assert!(
        matches!(told[..], [Event::FrictionRecorded { .. }]),
        "{told:?}"
    );
    let mut restarted = ContactSensing::<P70>::new();
    let notice = restarted.restore(&Record {
        overrides: &Overrides::default(),
        calibration: sensing.calibration(),
        friction: sensing.sensor().friction(),
        identified: None,
    });
    assert_eq!(notice, Notice::FrictionKnown);
    let mut moved = sensing.clone();
    moved.request(SensingRequest::Realign);
    assert!(is_aligned(&mut restarted, &mut time_us));
    assert!(is_aligned(&mut moved, &mut time_us));
    assert!(!is_aligned(&mut sensing, &mut time_us));
}
