//! Rotor, gearhead and worm: inertia, friction, backlash.
//!
//! The rotor is the only mass. The worm turns only where a flank of the gearhead's backlash pushes it (its friction
//! holds it otherwise), and pushes the wheel only across its own backlash; wheel and cable have no mass. The friction
//! without load wanders and warms up; that under load has a ripple once a turn of the worm.

use crate::last::Last;
use crate::parameters::{Friction, Parameters, Worm};
use crate::transmission::Transmission;
use crate::wander::Wander;
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// Static and running friction of the worm at a sliding speed (metre per second).
fn worm_friction(worm: &Worm, speed: f64) -> f64 {
    let running = worm.friction_running
        * (-worm.friction_speed_factor * speed.powf(worm.friction_speed_exponent)).exp();
    let stuck = worm.friction_static - worm.friction_running;
    // Underflows at some tens of Stribeck speeds, which is correct.
    if speed > 30.0 * worm.stribeck_speed_m_per_s {
        running
    } else {
        running + stuck * (-speed / worm.stribeck_speed_m_per_s).exp()
    }
}

/// Torque at the worm that moves a wheel torque `load` (positive: against closing) in direction `way` (1 or -1), from the
/// screw's inclined plane.
fn screw(worm: &Worm, tan_lead: f64, load: f64, way: f64, friction: f64) -> f64 {
    let along = way * load.signum() * friction;
    // tan(lead + atan(along)) / tan(lead)
    load / worm.ratio * (tan_lead + along) / ((1.0 - tan_lead * along) * tan_lead)
}

/// Efficiency of the worm while closing against a load, at a speed of the wheel; for checks of parameters.
#[must_use]
pub fn worm_efficiency(parameters: &Parameters, wheel_rad_per_s: f64) -> f64 {
    let worm = &parameters.worm;
    let lead = worm.lead_angle_deg.to_radians();
    let slip = wheel_rad_per_s.abs() * worm.ratio * worm.pitch_radius_m / lead.cos();
    1.0 / (worm.ratio * screw(worm, lead.tan(), 1.0, 1.0, worm_friction(worm, slip)))
}

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct Drivetrain {
    worm: Worm,
    inertia: f64,
    drag: f64,
    viscous: f64,
    gear_ratio: f64,
    gear_efficiency: f64,
    /// Half the gearhead's backlash at its output, radian.
    gear_play: f64,
    tan_lead: f64,
    slip_per_rad: f64,
    worm_phase: f64,
    wheel_phase: f64,
    ripple_phase: f64,
    friction: Friction,
    wander: Wander,
    /// Warm-up by running, 0 to 1.
    warmth: f64,
    transmission: Transmission,
    /// At the worm's angle: its uneven drag, the ripple of its friction, the transmission's periodic error. At the motor's speed: the
    /// worm's friction.
    uneven: Last,
    ripple: Last,
    error: Last,
    worm_friction: Last,
    /// Motor shaft, radian, from where it stood at power-on.
    pub rotor: f64,
    /// Motor speed, radian per second.
    pub speed: f64,
    /// Worm, radian.
    worm_angle: f64,
}

impl Drivetrain {
    /// `play` in -1 to 1: where the worm rests in the gearhead's backlash.
    pub fn new(parameters: &Parameters, play: f64, random: &mut Pcg64Mcg) -> Self {
        let Parameters {
            motor,
            gearhead,
            worm,
            friction,
            ..
        } = parameters;
        let lead = worm.lead_angle_deg.to_radians();
        let gear_play = 0.5 * gearhead.backlash_counts / parameters.counts_per_rad() * worm.ratio;
        Self {
            worm: *worm,
            inertia: motor.rotor_inertia_kg_m2,
            drag: motor.coulomb_nm + gearhead.drag_nm,
            viscous: motor.viscous_nm_s_per_rad,
            gear_ratio: gearhead.ratio,
            gear_efficiency: gearhead.efficiency,
            gear_play,
            tan_lead: lead.tan(),
            slip_per_rad: worm.pitch_radius_m / (lead.cos() * gearhead.ratio),
            worm_phase: worm.eccentric_phase_deg.to_radians(),
            wheel_phase: worm.wheel_eccentric_phase_deg.to_radians(),
            ripple_phase: worm.friction_ripple_phase_deg.to_radians(),
            friction: *friction,
            wander: Wander::new(friction.wander_share, friction.wander_time_s, random),
            warmth: 0.0,
            transmission: Transmission::new(&parameters.transmission, random),
            uneven: Last::new(),
            ripple: Last::new(),
            error: Last::new(),
            worm_friction: Last::new(),
            rotor: 0.0,
            speed: 0.0,
            worm_angle: play * gear_play,
        }
    }

    /// Wheel angle that corresponds to the worm, without its backlash, radian.
    fn wheel(&self) -> f64 {
        self.worm_angle / self.worm.ratio
    }

    /// The same with the transmission's errors: position of the cable's end.
    pub fn output(&mut self) -> f64 {
        let (worm, wheel) = (self.worm_angle, self.wheel());
        let periodic = self
            .error
            .of(worm, || self.transmission.periodic_error(worm, wheel));
        wheel + self.transmission.error(periodic)
    }

    /// Kinetic energy, joule.
    pub fn energy(&self) -> f64 {
        0.5 * self.inertia * self.speed * self.speed
    }

    /// Torque at the rotor that is needed against a load at the wheel in direction `way`, and whether the load drives the worm
    /// (only one that is not self-locking).
    fn reflected(&self, load: f64, way: f64, friction: f64) -> (f64, bool) {
        let at_worm = screw(&self.worm, self.tan_lead, load, way, friction) / self.gear_ratio;
        if at_worm * way < 0.0 {
            return (at_worm * self.gear_efficiency, true);
        }
        let slack = self.rotor / self.gear_ratio - self.worm_angle;
        let engaged = slack * way >= self.gear_play * (1.0 - 1e-9) - 1e-12;
        (
            if engaged {
                at_worm / self.gear_efficiency
            } else {
                0.0
            },
            false,
        )
    }

    /// One step: `torque` of the motor (mean over the step), `load` at the wheel, positive against closing.
    pub fn step(&mut self, torque: f64, load: f64, dt: f64, random: &mut Pcg64Mcg) {
        let running = if self.speed == 0.0 { 0.0 } else { 1.0 };
        self.warmth += dt / self.friction.warm_up_time_s * (running - self.warmth);
        self.wander.advance(dt, random);
        let before = self.worm_angle;
        self.turn(torque, self.transmission.loaded(load), dt);
        let way = self.worm_angle - before;
        self.transmission
            .advance(way, way / self.worm.ratio, random);
    }

    fn turn(&mut self, torque: f64, load: f64, dt: f64) {
        let (worm, wheel) = (&self.worm, self.wheel());
        let uneven = self.uneven.of(self.worm_angle, || {
            worm.eccentric_drag_nm * (self.worm_angle - self.worm_phase).cos()
                + worm.wheel_eccentric_drag_nm * (wheel - self.wheel_phase).cos()
        });
        let share = 1.0 + self.wander.value() + self.friction.warm_up_share * self.warmth;
        let drag = ((self.drag + uneven) * share).max(0.0);
        let ripple = self.ripple.of(self.worm_angle, || {
            1.0 + worm.friction_ripple * (self.worm_angle - self.ripple_phase).cos()
        });
        let slip = self.speed.abs() * self.slip_per_rad;
        let friction = ripple * self.worm_friction.of(slip, || worm_friction(worm, slip));
        let way = if self.speed != 0.0 {
            self.speed.signum()
        } else if torque > self.reflected(load, 1.0, friction).0 + drag {
            1.0
        } else if torque < self.reflected(load, -1.0, friction).0 - drag {
            -1.0
        } else {
            return;
        };
        let (reflected, driven) = self.reflected(load, way, friction);
        let resisting = reflected + way * drag;
        let speed = (self.speed + dt / self.inertia * (torque - resisting))
            / (1.0 + dt * self.viscous / self.inertia);
        // Friction stops the rotor but does not reverse it.
        self.speed = if speed * way < 0.0 { 0.0 } else { speed };
        let change = self.speed * dt;
        self.rotor += change;
        let output = self.rotor / self.gear_ratio;
        if driven {
            self.worm_angle += change / self.gear_ratio;
        }
        self.worm_angle = self
            .worm_angle
            .clamp(output - self.gear_play, output + self.gear_play);
    }

    /// Motor angle in turns, for periodic disturbances.
    pub fn phase(&self) -> f64 {
        self.rotor.rem_euclid(TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn worm_efficiency_is_the_data_sheets() {
        let p = Parameters::default();
        // Wheel speeds of a closing finger; docs/HARDWARE.md#plant-parameters: 0.42-0.48 running, 0.33 at breakaway.
        for speed in [0.2, 0.3, 0.5, 0.7] {
            let eta = worm_efficiency(&p, speed);
            assert!((0.42..=0.48).contains(&eta), "{eta} at {speed} rad/s");
        }
        let breakaway = worm_efficiency(&p, 0.0);
        assert!((0.32..=0.345).contains(&breakaway), "{breakaway}");
    }

    #[test]
    fn load_does_not_turn_a_self_locking_worm_but_turns_a_steep_one() {
        let mut p = Parameters::default();
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut locked = Drivetrain::new(&p, 1.0, &mut random);
        for _ in 0..2000 {
            locked.step(0.0, 5.0, 50e-6, &mut random);
        }
        assert_eq!(locked.rotor, 0.0);
        p.worm.lead_angle_deg = 30.0;
        let mut steep = Drivetrain::new(&p, -1.0, &mut random);
        for _ in 0..2000 {
            steep.step(0.0, 5.0, 50e-6, &mut random);
        }
        assert!(steep.rotor < -1.0);
    }

    /// Torque that keeps the motor at a steady speed, mean over a stretch of `from` to `to` seconds.
    fn drag(p: &Parameters, from: usize, to: usize) -> f64 {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let mut drivetrain = Drivetrain::new(p, 1.0, &mut random);
        let (mut sum, mut count) = (0.0, 0.0);
        for step in 0..20_000 * to {
            drivetrain.speed = 380.0;
            let before = drivetrain.speed;
            drivetrain.step(0.0, 0.0, 50e-6, &mut random);
            if step >= 20_000 * from {
                sum += (before - drivetrain.speed) / 50e-6 * p.motor.rotor_inertia_kg_m2;
                count += 1.0;
            }
        }
        sum / count
    }

    #[test]
    fn friction_wanders_and_warms_up() {
        let mut ideal = Parameters::default();
        ideal.worm.eccentric_drag_nm = 0.0;
        ideal.worm.wheel_eccentric_drag_nm = 0.0;
        let viscous = ideal.motor.viscous_nm_s_per_rad * 380.0;
        let plain = drag(&ideal, 0, 4) - viscous;
        let expected = ideal.motor.coulomb_nm + ideal.gearhead.drag_nm;
        assert!((plain / expected - 1.0).abs() < 0.02, "{plain} {expected}");
        let mut warm = ideal.clone();
        warm.friction.warm_up_share = -0.05;
        warm.friction.warm_up_time_s = 1.0;
        let change = (drag(&warm, 6, 8) - drag(&ideal, 6, 8)) / plain;
        assert!((change + 0.05).abs() < 0.002, "{change}");
        let mut wandering = ideal.clone();
        wandering.friction.wander_share = 0.03;
        wandering.friction.wander_time_s = 1.0;
        let seconds = (0..16).map(|s| drag(&wandering, s, s + 1) / drag(&ideal, s, s + 1) - 1.0);
        let squares: f64 = seconds.map(|change| change * change).sum();
        let rms = (squares / 16.0).sqrt();
        assert!((0.01..0.05).contains(&rms), "{rms}");
    }
}
