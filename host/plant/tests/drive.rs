//! Motor, bridge, sensors and cable against the data that they were made from.

mod support;

use palpate_plant::{Grasp, Parameters, Pins, Plant};
use support::{STEP, cylinder, drive, quiet, run, scene};

/// The motor alone, as its data sheet measures it.
fn bare_motor() -> Parameters {
    let mut p = quiet();
    p.gearhead.drag_nm = 0.0;
    p.worm.eccentric_drag_nm = 0.0;
    p.worm.wheel_eccentric_drag_nm = 0.0;
    p.motor.commutation_ripple = 0.0;
    p.bridge.on_resistance_ohm = 0.0;
    p.choke.resistance_ohm = 0.0;
    p.supply.internal_resistance_ohm = 0.0;
    p.motor.copper_temperature_coefficient_per_k = 0.0;
    p
}

#[test]
fn motor_is_the_data_sheets() {
    let p = bare_motor();
    let mut plant = Plant::new(&p, &Grasp::Free, 1).unwrap();
    run(&mut plant, &drive(1.0), 0.5);
    let truth = plant.truth();
    let rpm = truth.motor_speed_rad_per_s * 30.0 / std::f64::consts::PI;
    assert!((rpm / 12_500.0 - 1.0).abs() < 0.01, "{rpm} rpm");
    assert!(
        (truth.motor_current_a / 9e-3 - 1.0).abs() < 0.05,
        "{} A",
        truth.motor_current_a
    );
    assert!((plant.current_sense_v() / 6.8 - truth.motor_current_a).abs() < 1e-9);
    assert!((plant.supply_sense_v() / 0.18 - 12.0).abs() < 1e-9);
    plant.faults.rotor_locked = true;
    run(&mut plant, &drive(1.0), 0.01);
    assert!(
        (plant.truth().motor_current_a / 0.347 - 1.0).abs() < 0.02,
        "{} A",
        plant.truth().motor_current_a
    );
}

/// Resistance and torque constant are stated for 25 degrees; a workshop in summer is warmer.
#[test]
fn a_warm_room_warms_winding_and_magnets() {
    const COPPER_PER_K: f64 = 3.93e-3;
    const MAGNETS_PER_K: f64 = -2e-3;
    let told = |ambient_c: f64| {
        let mut p = bare_motor();
        p.motor.copper_temperature_coefficient_per_k = COPPER_PER_K;
        p.motor.magnet_temperature_coefficient_per_k = MAGNETS_PER_K;
        p.motor.ambient_c = ambient_c;
        let mut plant = Plant::new(&p, &Grasp::Free, 1).unwrap();
        run(&mut plant, &drive(1.0), 0.5);
        let speed_rad_per_s = plant.truth().motor_speed_rad_per_s;
        plant.faults.rotor_locked = true;
        run(&mut plant, &drive(1.0), 0.01);
        (speed_rad_per_s, plant.truth().motor_current_a)
    };
    let (speed_rad_per_s, current_a) = told(25.0);
    for ambient_c in [5.0, 45.0, 65.0] {
        let (speed, current) = told(ambient_c);
        let above_k = ambient_c - 25.0;
        let resistance = current_a / current;
        assert!(
            (resistance - 1.0 - COPPER_PER_K * above_k).abs() < 0.01,
            "{ambient_c}: {resistance}"
        );
        // The load, a fortieth of the voltage, is all that makes it differ from the reciprocal.
        let constant = speed_rad_per_s / speed;
        assert!(
            (constant - 1.0 - MAGNETS_PER_K * above_k).abs() < 0.01,
            "{ambient_c}: {constant}"
        );
    }
}

#[test]
fn locked_winding_heats_to_its_data() {
    let rise = |p: &Parameters, seconds: f64| {
        let mut plant = Plant::new(p, &Grasp::Free, 1).unwrap();
        plant.faults.rotor_locked = true;
        run(&mut plant, &drive(0.1 * 35.0 / 12.0), seconds);
        plant.winding_c() - 25.0
    };
    let mut p = bare_motor();
    // 0.35 W into 4 s / (12 K/W) at first.
    let early = rise(&p, 0.201);
    assert!(
        (early / (0.35 * 0.2 * 12.0 / 4.0) - 1.0).abs() < 0.05,
        "{early} K"
    );
    // 42 K/W in the end, here sooner.
    p.motor.winding_thermal_time_constant_s = 0.1;
    p.motor.housing_thermal_time_constant_s = 1.0;
    let late = rise(&p, 10.0);
    assert!((late / (0.35 * 42.0) - 1.0).abs() < 0.01, "{late} K");
}

#[test]
fn mechanical_time_constant_is_the_data_sheets() {
    let p = bare_motor();
    let mut plant = Plant::new(&p, &Grasp::Free, 1).unwrap();
    run(&mut plant, &drive(1.0), p.bridge.wake_s);
    let mut time = 0.0;
    while plant.truth().motor_speed_rad_per_s < 0.632 * 1305.0 {
        run(&mut plant, &drive(1.0), STEP);
        time += STEP;
    }
    assert!((time / 4.3e-3 - 1.0).abs() < 0.1, "{time} s");
}

/// Whatever is stored was put in by the motor's torque; with the motor off, nothing grows.
#[test]
fn energy_comes_from_the_motor_alone() {
    for name in ["p70", "tendon2", "tendon3", "linkage3"] {
        for friction in [0.0, 0.3] {
            let mut p = scene(name);
            p.motor.commutation_ripple = 0.0;
            p.contact.friction = friction;
            let grasp = Grasp::touching(2, 0.03, 0.8, cylinder(0.02));
            let mut plant = Plant::new(&p, &grasp, 3).unwrap();
            let start = plant.truth().stored_energy_j;
            let mut work = 0.0;
            for i in 0..60_000u32 {
                // Close, open a little, close again.
                let duty = if (30_000..34_000).contains(&i) {
                    -0.4
                } else {
                    0.5
                };
                let before = plant.truth();
                plant.step(&drive(duty), STEP);
                let after = plant.truth();
                // A quasi-static current: the mean over the step lies between its ends.
                let current = before.motor_current_a.max(after.motor_current_a);
                let turned = after.motor_angle_rad - before.motor_angle_rad;
                let current = if turned < 0.0 {
                    before.motor_current_a.min(after.motor_current_a)
                } else {
                    current
                };
                work += p.motor.torque_constant_nm_per_a * current * turned;
                let stored = after.stored_energy_j - start;
                assert!(
                    stored <= work + 1e-6,
                    "{name} step {i}: stored {stored} of {work} J"
                );
            }
            assert!(plant.truth().stored_energy_j > 1e-3, "{name} never loaded");
            let mut last = plant.truth().stored_energy_j;
            for _ in 0..4000 {
                plant.step(&Pins::default(), STEP);
                let now = plant.truth().stored_energy_j;
                assert!(
                    now <= last + 1e-9,
                    "{name}: {last} to {now} J without a motor"
                );
                last = now;
            }
        }
    }
}

#[test]
fn cable_creeps_under_load() {
    let grasp = Grasp::touching(1, 0.06, 0.5, cylinder(0.02));
    let mut plant = Plant::new(&quiet(), &grasp, 3).unwrap();
    // Onto the closing stop, which holds the input link.
    plant.place(&Grasp::Free).unwrap();
    run(&mut plant, &drive(0.5), 4.0);
    run(&mut plant, &Pins::default(), 0.1);
    let early = plant.truth().torque_nm;
    run(&mut plant, &Pins::default(), 20.0);
    let late = plant.truth().torque_nm;
    assert!(
        (0.93..0.99).contains(&(late / early)),
        "{early} to {late} N m"
    );
    assert!((plant.truth().theta_a_rad - plant.truth().closing_stop_rad).abs() < 0.01);
}

/// Motor counts between the last motion of the loaded input link while closing and its first while opening.
#[test]
fn backlash_has_the_width_of_the_data() {
    let mut p = quiet();
    p.encoder.periodic_error_counts = 0.0;
    p.cable.stiffness_n_per_m = 1e7;
    p.cable.creep_fraction = 0.0;
    let mut plant = Plant::new(&p, &Grasp::Free, 5).unwrap();
    run(&mut plant, &drive(0.3), 1.0);
    run(&mut plant, &drive(0.0), 0.1);
    let (turned, angle) = (plant.encoder_count(), plant.truth().theta_a_rad);
    while angle - plant.truth().theta_a_rad < 1e-6 {
        plant.step(&drive(-0.2), STEP);
    }
    let backlash = turned - plant.encoder_count();
    assert!((backlash - (364 + 1092)).abs() < 20, "{backlash} counts");
}

#[test]
fn sense_is_unsigned_and_sees_a_reversed_current_in_the_off_time_only() {
    let mut plant = Plant::new(&quiet(), &Grasp::Free, 3).unwrap();
    run(&mut plant, &drive(0.5), 0.3);
    assert!(plant.current_sense_v() > 0.05);
    // Asleep: no current, no reading.
    plant.step(
        &Pins {
            awake: false,
            ..drive(0.5)
        },
        STEP,
    );
    assert_eq!(
        (plant.current_sense_v(), plant.truth().motor_current_a),
        (0.0, 0.0)
    );
    run(&mut plant, &drive(0.5), 0.3);
    // Less drive than back-EMF: the current opposes the drive.
    run(&mut plant, &drive(0.05), 1e-3);
    let reversed_a = plant.truth().motor_current_a;
    assert!(reversed_a < 0.0);
    let seen_a = plant.current_sense_v() / 6.8;
    assert!(
        (seen_a / (-0.95 * reversed_a) - 1.0).abs() < 0.05,
        "{seen_a} {reversed_a}"
    );
    // Opening at speed reads positive too.
    run(&mut plant, &drive(-0.5), 0.2);
    assert!(plant.truth().motor_current_a < 0.0 && plant.current_sense_v() > 0.05);
}

#[test]
fn bridge_needs_time_to_wake_and_voltage_to_stay() {
    let mut plant = Plant::new(&quiet(), &Grasp::Free, 3).unwrap();
    run(&mut plant, &drive(1.0), 0.9e-3);
    assert_eq!(plant.truth().motor_current_a, 0.0);
    run(&mut plant, &drive(1.0), 0.5e-3);
    assert!(plant.truth().motor_current_a > 0.0);
    plant.faults.supply_v = Some(3.0);
    run(&mut plant, &drive(1.0), 0.2e-3);
    assert!(plant.fault_pin_low() && plant.truth().motor_current_a == 0.0);
    plant.faults.supply_v = None;
    plant.faults.rotor_locked = true;
    plant.faults.winding_left = 0.05;
    run(&mut plant, &drive(1.0), 2e-3);
    assert!(plant.fault_pin_low());
    assert!((plant.truth().motor_current_a - 0.485).abs() < 1e-9);
}

#[test]
fn broken_encoder_wires_miscount() {
    let counts = |set: fn(&mut palpate_plant::EncoderFault)| {
        let mut plant = Plant::new(&quiet(), &Grasp::Free, 3).unwrap();
        set(&mut plant.faults.encoder);
        run(&mut plant, &drive(0.5), 0.5);
        plant.encoder_count()
    };
    let healthy = counts(|_| {});
    assert!(healthy > 10_000);
    assert!(counts(|f| f.a_cut = true).abs() <= 2);
    assert!(counts(|f| f.b_cut = true).abs() <= 2);
    assert!(counts(|f| (f.a_cut, f.b_cut) = (true, true)).abs() <= 2);
    assert!((counts(|f| f.swapped = true) + healthy).abs() <= 4);
    let storm = counts(|f| f.storm_edges_per_s = 1e5);
    assert!((storm - healthy).abs() > 1000, "{storm} {healthy}");
}

#[test]
fn phases_go_with_the_count() {
    let mut plant = Plant::new(&quiet(), &Grasp::Free, 3).unwrap();
    let (mut last, mut phases) = (plant.encoder_count(), plant.encoder_phases());
    let mut single = 0;
    for _ in 0..4000 {
        plant.step(&drive(0.15), 10e-6);
        let (now, levels) = (plant.encoder_count(), plant.encoder_phases());
        if (now - last).abs() == 1 {
            single += 1;
            let changed = u8::from(phases.0 != levels.0) + u8::from(phases.1 != levels.1);
            assert_eq!(changed, 1);
            // A leads while closing: B copies A on its own edge, A becomes the opposite of B on its own.
            let a_changed = phases.0 != levels.0;
            assert_eq!((now > last) == a_changed, levels.0 != levels.1);
        }
        (last, phases) = (now, levels);
    }
    assert!(single > 100, "{single}");
}

/// A quiet plant whose current follows the edges of the PWM.
fn edged() -> Parameters {
    let mut p = bare_motor();
    p.bridge.edges = 1.0;
    p.bridge.dead_time_s = 300e-9;
    p.converter.hold_f = 5e-12;
    p
}

#[test]
fn with_edges_the_mean_of_a_period_is_read_and_an_instant_is_not() {
    let p = edged();
    let mut plant = Plant::new(&p, &Grasp::Free, 1).unwrap();
    plant.faults.rotor_locked = true;
    run(&mut plant, &drive(0.3), 0.01);
    // Dead time takes 30 ns a microsecond of the supply and twice the diode's drop.
    let mean_a = (0.3 * 12.0 - 0.03 * (12.0 + 1.8)) / 35.0;
    let read_a = plant.current_sense_v() / 6.8;
    assert!((read_a / mean_a - 1.0).abs() < 2e-3, "{read_a} {mean_a}");
    let mut probe = plant.current_probe(&drive(0.3));
    let volts: Vec<f64> = (0..100)
        .map(|part| probe.volts(f64::from(part) * 1e-7) / 6.8)
        .collect();
    let [least, most] = [f64::min, f64::max].map(|of| volts.iter().copied().reduce(of).unwrap());
    // 35 mA of ripple through 6.8 us of the pin's capacitor.
    assert!((3e-3..15e-3).contains(&(most - least)), "{least} {most}");
}

#[test]
fn with_edges_the_sense_is_blind_to_an_opposing_current_in_the_on_time_only() {
    let mut p = edged();
    // No capacitor: the pin follows at once.
    p.sense.pin_f = 0.0;
    p.sense.offset_a = -2e-3;
    let mut plant = Plant::new(&p, &Grasp::Free, 1).unwrap();
    run(&mut plant, &drive(0.8), 0.1);
    // Much less drive than back-EMF.
    run(&mut plant, &drive(0.4), 1e-3);
    let reversed_a = plant.truth().motor_current_a;
    assert!(reversed_a < -0.05, "{reversed_a}");
    let mut probe = plant.current_probe(&drive(0.4));
    // On for 4 us about 0 and 10 us, off between; dead for 0.3 us.
    for (at_us, seen) in [
        (1.0, false),
        (1.9, false),
        (2.5, true),
        (5.0, true),
        (7.9, true),
        (8.5, false),
    ] {
        let volts = probe.volts(at_us * 1e-6);
        assert_eq!(volts > 0.3, seen, "{at_us} us: {volts} V");
        assert!(seen || volts < 1e-6, "{at_us} us: {volts} V");
    }
}

/// Highest voltage at the bridge when a fast motor is slowed down to half, with a capacitor there.
fn highest_v(bulk_f: f64) -> f64 {
    let mut p = edged();
    p.supply.bulk_f = bulk_f;
    p.supply.internal_resistance_ohm = 0.2;
    let mut plant = Plant::new(&p, &Grasp::Free, 1).unwrap();
    run(&mut plant, &drive(0.9), 0.1);
    let mut highest_v = 0.0f64;
    for _ in 0..400 {
        plant.step(&drive(0.5), STEP);
        highest_v = highest_v.max(plant.truth().supply_v);
    }
    highest_v
}

/// Of some 5 mJ of the rotor most heats the winding.
#[test]
fn what_braking_returns_stays_in_the_capacitor() {
    assert!(highest_v(0.0) < 12.1, "{}", highest_v(0.0));
    let [small, fitted] = [100e-6, 330e-6].map(highest_v);
    assert!((12.1..13.0).contains(&fitted), "{fitted} V");
    assert!(small > fitted + 0.2, "{small} V");
}
