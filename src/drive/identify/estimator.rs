//! The motor's equations, and what follows from their coefficients (docs/SENSING.md#identification-of-the-motor).

use super::{Estimate, Identified};
use crate::drive::config::CheckedConfig;
use crate::drive::convert::PERIOD_S;
use crate::drive::demand::Status;
use crate::drive::io::PWM_HZ;
use crate::drive::thermal::{COLD_C, COPPER_PER_K};
use crate::numeric::{LeastSquares, sqrt};

/// Gain of the current sense, standard deviation: 5 % (docs/HARDWARE.md#bridge), uniform; 1 % of a shunt and its amplifier.
const MIRROR_GAIN: f32 = 0.029;
const SHUNT_GAIN: f32 = 0.01;
/// Divider of the supply and reference of the converter, standard deviation: two resistors of 1 % (chosen).
const SUPPLY_GAIN: f32 = 0.008;
/// Both switches of the bridge, ohm (docs/HARDWARE.md#bridge, V2), and how far they may be off with warmth and scatter (R).
const SWITCHES_OHM: f32 = 0.7;
const SWITCHES_SIGMA_OHM: f32 = 0.2;
/// Residuals of neighbouring samples are alike, because commutation and gears go round slowly: the variance of a mean is larger by
/// this than that of independent ones (chosen).
const CORRELATED: f32 = 4.0;
/// Friction differs from place to place by this share of itself, standard deviation: eccentric gears, of which the motion sees a
/// part of a turn (I).
const FRICTION_PLACE: f32 = 0.08;
/// Voltage that the sense's late and bent response leaves in the intercept, standard deviation (R).
const INTERCEPT_V: f32 = 0.03;
/// A voltage acts up to a period after it is decided, and is taken half a period early: what is left, standard deviation.
const DELAY_SIGMA_S: f32 = 0.5 * PERIOD_S;

/// What the bridge did throughout a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Drove the motor the way it turns.
    Driven,
    /// Was off.
    Coasting,
}

/// A sample, seen in the direction of motion.
#[derive(Clone, Copy, Debug)]
struct Observed {
    phase: Phase,
    current: f32,
    speed: f32,
    /// At the sample's end.
    voltage: f32,
}

/// Sizes of one: what unknowns and samples are scaled by.
#[derive(Clone, Copy, Debug)]
struct Unit {
    a: f32,
    v: f32,
    rad_per_s: f32,
    rad_per_s2: f32,
}

/// Collects samples.
#[derive(Clone, Debug)]
pub struct Estimator {
    unit: Unit,
    motor_rad_per_count: f32,
    friction_speed: f32,
    choke_ohm: f32,
    ambient_c: f32,
    gain_sigma: f32,
    /// Of the voltage: resistance, torque constant, intercept.
    electrical: LeastSquares<4>,
    /// Of the acceleration: per current, step where the motor is driven, friction, friction by speed.
    mechanical: LeastSquares<4>,
    before: Option<Observed>,
    position_counts: i32,
    time_us: u64,
    winding_c: f32,
    supply_v: f32,
}

impl Estimator {
    /// Nothing seen; friction is told at `friction_rad_per_s` of the input link.
    pub fn new(drive: &CheckedConfig, friction_rad_per_s: f32) -> Self {
        let config = drive.config();
        let (motor, gears) = (&config.motor, &config.drivetrain);
        let rad_per_s = config.limits.speed_rad_per_s * gears.reduction;
        let a = config.limits.current_a;
        Self {
            unit: Unit {
                a,
                v: motor.torque_constant_nm_per_a * rad_per_s,
                rad_per_s,
                rad_per_s2: a * motor.torque_constant_nm_per_a / motor.rotor_inertia_kg_m2,
            },
            motor_rad_per_count: core::f32::consts::TAU / gears.counts_per_motor_rev,
            friction_speed: friction_rad_per_s / config.limits.speed_rad_per_s,
            choke_ohm: motor.choke_ohm,
            ambient_c: motor.thermal.ambient_c,
            gain_sigma: if config.sense.signed {
                SHUNT_GAIN
            } else {
                MIRROR_GAIN
            },
            electrical: LeastSquares::new(),
            mechanical: LeastSquares::new(),
            before: None,
            position_counts: 0,
            time_us: 0,
            winding_c: COLD_C,
            supply_v: 0.0,
        }
    }

    /// Takes the status of a new sample throughout which the bridge did the same; `None` where it did not.
    pub fn take(&mut self, phase: Option<Phase>, status: &Status) {
        let elapsed_us = status.time_us.wrapping_sub(self.time_us);
        let counts = status.position_counts.wrapping_sub(self.position_counts);
        (self.time_us, self.position_counts) = (status.time_us, status.position_counts);
        let before = self.before.take();
        // Averages are those of the last millisecond: the way must be, too.
        if elapsed_us != 1000 {
            return;
        }
        let Some(phase) = phase else { return };
        let sign = if counts < 0 { -1.0 } else { 1.0 };
        let rad_per_s = counts as f32 * (sign * 1e3 * self.motor_rad_per_count);
        let now = Observed {
            phase,
            current: sign * status.current_a / self.unit.a,
            speed: rad_per_s / self.unit.rad_per_s,
            voltage: sign * status.applied_v / self.unit.v,
        };
        if let Some(before) = before.filter(|before| before.phase == phase) {
            let acceleration =
                (now.speed - before.speed) * (1e3 * self.unit.rad_per_s / self.unit.rad_per_s2);
            let (current, driven) = match phase {
                Phase::Driven => {
                    (self.winding_c, self.supply_v) = (status.winding_c, status.supply_v);
                    // The loops let the voltage rise evenly within a sample.
                    let voltage = 0.5 * (now.voltage + before.voltage);
                    self.electrical
                        .add(&[now.current, now.speed, 1.0, 0.0], voltage);
                    (0.5 * (now.current + before.current), 1.0)
                }
                Phase::Coasting => (0.0, 0.0),
            };
            let speed = 0.5 * (now.speed + before.speed);
            self.mechanical
                .add(&[current, driven, -1.0, -speed], acceleration);
        }
        self.before = Some(now);
    }

    /// What follows from all samples.
    pub fn identified(&self) -> Identified {
        let unit = &self.unit;
        let [ohm, emf, intercept, _] = *self.electrical.solution();
        let [per_current, step, still, rising] = *self.mechanical.solution();
        let electrical = |c| CORRELATED * self.electrical.variance(&c);
        let mechanical = |c| CORRELATED * self.mechanical.variance(&c);
        let square = |x: f32| x * x;
        let gain2 = square(self.gain_sigma);

        let k = emf * unit.v / unit.rad_per_s;
        let k_share2 = electrical([0.0, 1.0, 0.0, 0.0]) / square(emf) + square(SUPPLY_GAIN);

        let inertia = k * unit.a / (per_current * unit.rad_per_s2);
        let slope_share2 = mechanical([1.0, 0.0, 0.0, 0.0]) / square(per_current);
        let inertia_share2 = k_share2 + slope_share2 + gain2;

        let slowing = still + rising * self.friction_speed;
        let friction = inertia * unit.rad_per_s2 * slowing;
        let friction_share2 = mechanical([0.0, 0.0, 1.0, self.friction_speed]) / square(slowing)
            + inertia_share2
            + square(FRICTION_PLACE);

        // The acceleration without current, beyond friction's: what the sense leaves out.
        let hidden = step / per_current;
        let hidden2 = mechanical([-hidden, 1.0, 0.0, 0.0]) / square(per_current);
        let total_ohm = ohm * unit.v / unit.a;
        let lost_v = intercept * unit.v - total_ohm * hidden * unit.a;
        let lost_v2 = square(unit.v) * electrical([-hidden, 0.0, 1.0, 0.0])
            + square(total_ohm * unit.a) * hidden2
            + square(INTERCEPT_V);
        let edges_v = self.supply_v * PWM_HZ as f32;

        // After a power cut the thermal model begins warm: the winding is between ambient and what it says.
        let half_k = 0.5 * (self.winding_c - self.ambient_c);
        let growth = 1.0 + COPPER_PER_K * (self.ambient_c + half_k - COLD_C);
        // The choke hardly warms.
        let cold_ohm = (total_ohm - SWITCHES_OHM - self.choke_ohm) / growth + self.choke_ohm;
        let cold_ohm2 = square(unit.v / unit.a) * electrical([1.0, 0.0, 0.0, 0.0])
            + square(SWITCHES_SIGMA_OHM)
            // Speed rises with the current while a voltage waits: that looks like resistance.
            + square(k * DELAY_SIGMA_S * unit.rad_per_s2 * per_current / unit.a)
            + square(cold_ohm) * (gain2 + square(SUPPLY_GAIN) + square(COPPER_PER_K * half_k));

        let estimate = |value, variance| Estimate {
            value,
            sigma: sqrt(variance),
        };
        Identified {
            estimates: [
                estimate(cold_ohm, cold_ohm2),
                estimate(k, square(k) * k_share2),
                estimate(inertia, square(inertia) * inertia_share2),
                estimate(friction, square(friction) * friction_share2),
                estimate(lost_v / edges_v, lost_v2 / square(edges_v)),
            ],
        }
    }
}
