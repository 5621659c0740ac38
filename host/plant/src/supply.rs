//! Supply and the capacitor beside the bridge.

use crate::parameters::Supply;

/// Voltage at the bridge after a step in which it drew this mean current, ampere; negative where braking returned it.
///
/// A supply gives and takes nothing back, so what is returned stays in the capacitor. One that was set to a voltage by a fault
/// (`forced`) also pulls down. Without a capacitor the voltage follows at once.
pub(crate) fn after(
    supply: &Supply,
    before_v: f64,
    open_circuit_v: f64,
    forced: bool,
    drawn_a: f64,
    dt: f64,
) -> f64 {
    let resistance = supply.internal_resistance_ohm;
    let loaded_v = open_circuit_v - resistance * drawn_a;
    if supply.bulk_f == 0.0 {
        return loaded_v.max(0.0);
    }
    let time_constant = (resistance * supply.bulk_f).max(1e-9);
    let fed_v = loaded_v + (before_v - loaded_v) * (-dt / time_constant).exp();
    let after_v = if forced || before_v.max(fed_v) <= open_circuit_v {
        fed_v
    } else {
        // The supply is out of the circuit while it is exceeded.
        (before_v - drawn_a * dt / supply.bulk_f).max(open_circuit_v)
    };
    after_v.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUPPLY: Supply = Supply {
        voltage_v: 12.0,
        internal_resistance_ohm: 0.2,
        divider: 0.18,
        noise_rms_v: 0.0,
        bulk_f: 330e-6,
        pin_ohm: 14.8e3,
        pin_f: 1e-9,
    };

    /// The same by steps of 10 ns.
    fn stepped(mut volts: f64, drawn_a: f64, seconds: f64) -> f64 {
        for _ in 0..(seconds / 1e-8) as u32 {
            let given_a = ((12.0 - volts) / 0.2).max(0.0);
            volts += 1e-8 * (given_a - drawn_a) / 330e-6;
        }
        volts
    }

    #[test]
    fn sags_under_load_and_keeps_what_comes_back() {
        for (before_v, drawn_a) in [
            (12.0, 0.2),
            (11.9, 0.0),
            (12.5, -0.1),
            (12.0, -0.1),
            (12.5, 0.3),
        ] {
            let mut volts = before_v;
            for _ in 0..20 {
                volts = after(&SUPPLY, volts, 12.0, false, drawn_a, 50e-6);
            }
            let small = stepped(before_v, drawn_a, 1e-3);
            assert!(
                (volts - small).abs() < 2e-3,
                "{before_v} {drawn_a}: {volts} {small}"
            );
        }
        // Half of C (15^2 - 12^2): 13 mJ.
        let mut volts = 12.0;
        for _ in 0..100 {
            volts = after(&SUPPLY, volts, 12.0, false, -0.1, 50e-6);
        }
        assert!((volts - 13.515).abs() < 0.01, "{volts}");
    }

    #[test]
    fn a_forced_supply_pulls_down() {
        assert!((after(&SUPPLY, 12.0, 3.0, true, 0.0, 1e-3) - 3.0).abs() < 1e-3);
        assert!(after(&SUPPLY, 12.0, 3.0, false, 0.01, 1e-3) > 11.9);
    }
}
