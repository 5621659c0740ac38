//! Worlds drawn from the spreads of the data: the hidden values that a calibration has to estimate.

use super::Parameters;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// How far a joint may be from where its own motor should hold it, degree (chosen: the homing of that motor and its gears).
const HELD_DEG: f64 = 0.5;
/// Stiffness that no cable reaches and every shaft exceeds, newton per metre.
const STIFFEST_N_PER_M: f64 = 1e5;
/// Changes the seed for what shows between the edges of the PWM.
const EDGES: u64 = 0x6564_6765_735f_5f5f;
/// The same of the generator for the sensor of joint 2.
const MAGNET: u64 = 0x6d61_676e_6574_5f5f;

impl Parameters {
    /// A random plant: every hidden value is drawn from its spread around `self`, reproducibly by the seed.
    ///
    /// Relative, uniform: winding resistance and rotor inertia 20 %, torque constant and springs 10 %, gearhead efficiency 10 %,
    /// worm friction 15 %, motor friction 30 %. Absolute: gearhead drag 0.03-0.15 mNm, cable 1.5-10 kN/m (log-uniform), creep 3-7
    /// %, sense offset 7 mA, drift 1 mA, gain 5 %, phases anywhere. Effects that the ideal world lacks: half to one and a half
    /// times the world's value, and time constants of wander and warm-up a third to three times; warm-up and nonlinearity of
    /// either sign; gravity in any direction; lengths by up to the world's `geometry_m`. Of joints that other motors hold:
    /// backlash 30 %, and where they are held 0.5 degrees.
    /// Of the sensor of joint 2: 0.05 rad and 5 %.
    /// With edges: L/R 50 %, the choke 20 %, diodes 20 %, hold capacitor 30 %.
    #[must_use]
    pub fn randomised(&self, seed: u64) -> Self {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut p = self.clone();
        let mut around = |value: &mut f64, relative: f64| {
            *value *= 1.0 + random.random_range(-relative..=relative)
        };
        around(&mut p.motor.resistance_ohm, 0.20);
        around(&mut p.motor.rotor_inertia_kg_m2, 0.20);
        around(&mut p.motor.torque_constant_nm_per_a, 0.10);
        around(&mut p.motor.coulomb_nm, 0.30);
        around(&mut p.motor.viscous_nm_s_per_rad, 0.30);
        around(&mut p.gearhead.efficiency, 0.10);
        p.gearhead.efficiency = p.gearhead.efficiency.min(1.0);
        let mut friction = 1.0;
        around(&mut friction, 0.15);
        p.worm.friction_running *= friction;
        p.worm.friction_static *= friction;
        around(&mut p.worm.eccentric_drag_nm, 0.5);
        around(&mut p.worm.wheel_eccentric_drag_nm, 0.5);
        around(&mut p.gearhead.backlash_counts, 0.3);
        around(&mut p.worm.backlash_counts, 0.3);
        p.gearhead.drag_nm = random.random_range(0.03e-3..=0.15e-3);
        let stiffness_n_per_m = random.random_range(1.5e3f64.ln()..=10e3f64.ln()).exp();
        let creep_fraction = random.random_range(0.03..=0.07);
        // Keep the shaft that stands in for the cable in scenes without one. Draw all the same, so that what follows is as in other scenes.
        if p.cable.stiffness_n_per_m < STIFFEST_N_PER_M {
            p.cable.stiffness_n_per_m = stiffness_n_per_m;
            p.cable.creep_fraction = creep_fraction;
        }
        p.sense.offset_a = random.random_range(-7e-3..=7e-3);
        p.sense.offset_drift_a = random.random_range(-1e-3..=1e-3);
        p.sense.gain_error = random.random_range(-0.05..=0.05);
        p.mechanism.spring_error =
            (1.0 + p.mechanism.spring_error) * (1.0 + random.random_range(-0.1..=0.1)) - 1.0;
        for phase in [
            &mut p.worm.eccentric_phase_deg,
            &mut p.worm.wheel_eccentric_phase_deg,
            &mut p.encoder.periodic_phase_deg,
        ] {
            *phase = random.random_range(-180.0..=180.0);
        }
        p.disagree(&mut random);
        for (backlash_deg, rest_deg) in
            (p.finger.held_backlash_deg.iter_mut()).zip(p.finger.rest_deg.iter_mut().skip(1))
        {
            *backlash_deg *= 1.0 + random.random_range(-0.3..=0.3);
            *rest_deg += random.random_range(-HELD_DEG..=HELD_DEG);
        }
        p.switch_unlike(seed);
        p.mount_unlike(seed);
        p
    }

    /// Draws how the sensor of joint 2 is mounted; from a generator of its own, so that nothing else changes.
    fn mount_unlike(&mut self, seed: u64) {
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ MAGNET);
        // A magnet turned by 3 degrees, and 5 % nearer or farther in field (R, chosen).
        self.hall.zero_v +=
            0.05 * self.hall.sensitivity_v_per_rad * random.random_range(-1.0..=1.0);
        self.hall.sensitivity_v_per_rad *= 1.0 + random.random_range(-0.05..=0.05);
    }

    /// Draws what shows between the edges of the PWM; from a generator of its own, so that nothing else changes.
    fn switch_unlike(&mut self, seed: u64) {
        if self.has_edges() {
            let mut random = Pcg64Mcg::seed_from_u64(seed ^ EDGES);
            self.motor.electrical_time_constant_s *= random.random_range(0.5..=1.5);
            self.choke.inductance_h *= random.random_range(0.8..=1.2);
            self.choke.resistance_ohm *= random.random_range(0.8..=1.2);
            self.bridge.diode_v *= random.random_range(0.8..=1.2);
            self.converter.hold_f *= random.random_range(0.7..=1.3);
        }
    }

    /// Draws effects that the ideal world lacks; a value of zero stays zero.
    fn disagree(&mut self, random: &mut Pcg64Mcg) {
        let p = self;
        for value in [
            &mut p.friction.wander_share,
            &mut p.transmission.worm_error_rad,
            &mut p.transmission.wheel_error_rad,
            &mut p.transmission.gear_error_rad,
            &mut p.transmission.random_error_rad,
            &mut p.transmission.hysteresis_share,
            &mut p.worm.friction_ripple,
            &mut p.cable.stiffening_per_nm,
            &mut p.cable.slow_creep_fraction,
            &mut p.encoder.random_error_counts,
            &mut p.motor.magnet_temperature_coefficient_per_k,
            &mut p.sense.settling_s,
            &mut p.bridge.dead_time_s,
            &mut p.contact.friction,
            &mut p.mechanism.preload_deg,
            &mut p.mechanism.joint_friction_nm,
            &mut p.mechanism.capstan_share,
            &mut p.mechanism.linear_density_kg_per_m,
        ] {
            *value *= random.random_range(0.5..=1.5);
        }
        for value in [&mut p.friction.warm_up_share, &mut p.sense.nonlinearity] {
            *value *= random.random_range(-1.0..=1.0);
        }
        for value in [
            &mut p.friction.wander_time_s,
            &mut p.friction.warm_up_time_s,
            &mut p.cable.slow_creep_time_s,
        ] {
            *value *= random.random_range(-1.1f64..=1.1).exp();
        }
        for phase in [
            &mut p.worm.friction_ripple_phase_deg,
            &mut p.transmission.worm_error_phase_deg,
            &mut p.transmission.wheel_error_phase_deg,
            &mut p.mechanism.mounting_deg,
        ] {
            *phase = random.random_range(-180.0..=180.0);
        }
        let off = p.mechanism.geometry_m;
        if off > 0.0 {
            for length in p.finger.lengths_mut() {
                *length += random.random_range(-off..=off);
            }
        }
    }
}
