//! Closings that are stopped while something of them is still to be said.

use super::sensor::{friction_a, motion, recorded};
use crate::finger::Mechanics;
use crate::scene::{P70, Scene};
use crate::sensing::{Directive, Drive, Event, Sample, Sensor, Settings};

/// Current of a contact from 0.8 rad on, in the middle of the distal phalanx.
fn contact_a(angle: f32) -> f32 {
    let drivetrain = P70::drivetrain(&P70::MECHANISM);
    let per_nm = 1.0 / (drivetrain.torque_per_ampere_nm * drivetrain.efficiency);
    friction_a(angle) + per_nm * 0.6 * (angle - 0.8).max(0.0)
}

/// Closes without a rest at the end; what is told until an event for which `until` is true, at most to 1.3 rad.
fn close<F: Mechanics>(
    sensor: &mut Sensor<F>,
    time_us: &mut u64,
    until: impl Fn(&Event) -> bool,
) -> Vec<Event> {
    let rad_per_count = P70::drivetrain(&P70::MECHANISM).rad_per_count;
    let mut told = Vec::new();
    for i in 0..4333 {
        let angle = 0.3e-3 * i as f32;
        *time_us += 1000;
        let event = sensor.update(&Sample {
            emf_v: f32::NAN,
            time_us: *time_us,
            position_counts: (angle / rad_per_count) as i32,
            current_a: contact_a(angle),
            drive: Drive::Closing,
            joint: (),
        });
        told.extend(event);
        if event.as_ref().is_some_and(&until) {
            break;
        }
    }
    told
}

/// Rests at an angle of the input link for two seconds.
fn rest<F: Mechanics>(sensor: &mut Sensor<F>, time_us: &mut u64, angle: f32) -> Vec<Event> {
    (0..5)
        .flat_map(|_| motion(sensor, time_us, (angle, angle), friction_a))
        .collect()
}

/// Every closing ends with its global stiffness, that of a stop after the last word too.
#[test]
fn a_stop_after_the_last_word_tells_the_stiffness() {
    let (mut sensor, mut time_us) = recorded();
    // The first place that is told is good enough to end with.
    sensor.set_settings(Settings {
        wanted_sigma_m: 0.05,
        ..*sensor.settings()
    });
    sensor.direct(Directive::Watch);
    let last_word = |event: &Event| matches!(event, Event::Located { settled: true, .. });
    let told = close(&mut sensor, &mut time_us, last_word);
    assert!(told.iter().any(last_word), "{told:?}");
    let is_stiffness = |event: &Event| matches!(event, Event::Stiffness { .. });
    assert!(!told.iter().any(is_stiffness), "{told:?}");
    sensor.direct(Directive::Rest);
    let told = rest(&mut sensor, &mut time_us, 1.3);
    assert_eq!(
        told.iter().filter(|event| is_stiffness(event)).count(),
        1,
        "{told:?}"
    );
}

/// What becomes of the sensing while a pin is still judged.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meanwhile {
    Nothing,
    /// A setting that no curve is judged by.
    Sensitivity,
    Forgotten,
    Speed,
    Friction,
}

/// A calibration that is forgotten while a pin is still judged does not come back with that pin, and a pin is not judged by two speeds or
/// two contact frictions.
#[test]
fn a_pin_that_is_still_judged_is_dropped_where_what_it_is_judged_by_changes() {
    use Meanwhile::{Forgotten, Friction, Nothing, Sensitivity, Speed};
    for meanwhile in [Nothing, Sensitivity, Forgotten, Speed, Friction] {
        let (mut sensor, mut time_us) = recorded();
        let before = *sensor.calibration();
        sensor.direct(Directive::Calibrate {
            phalanx: 2,
            k_m: 0.035,
        });
        let told = close(&mut sensor, &mut time_us, |_| false);
        assert!(
            !(told.iter()).any(|event| matches!(event, Event::Calibrated { .. })),
            "{told:?}"
        );
        sensor.direct(Directive::Rest);
        let mut settings = *sensor.settings();
        match meanwhile {
            Nothing => {}
            Sensitivity => settings.false_contacts_per_thousand *= 10.0,
            Forgotten => assert!(sensor.set_calibration(before)),
            Speed => settings.speed_rad_per_s *= 1.2,
            Friction => settings.contact_friction[0] += 0.1,
        }
        sensor.set_settings(settings);
        let told = rest(&mut sensor, &mut time_us, 1.3);
        let is_told = (told.iter()).any(|event| {
            matches!(
                event,
                Event::Calibrated { .. } | Event::CalibrationRefused { .. }
            )
        });
        let stays = matches!(meanwhile, Nothing | Sensitivity);
        assert_eq!(is_told, stays, "{meanwhile:?}: {told:?}");
        if !stays {
            assert_eq!(*sensor.calibration(), before, "{meanwhile:?}");
        }
    }
}
