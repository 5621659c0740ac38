//! The whole world, stepped with the levels on the pins.

use crate::bridge::Bridge;
use crate::cable::Cable;
use crate::drivetrain::Drivetrain;
use crate::encoder::QuadratureEncoder;
use crate::last::Last;
use crate::mechanics::{CableEnd, Mechanics, Quasistatic};
use crate::object::Grasp;
use crate::parameters::{Object, Parameters};
use crate::supply;
use crate::{Error, Faults, FirstContact, Pins, Truth};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

mod readings;

/// Longest integration step, second; longer ones are divided into equal parts.
pub const MAX_STEP_S: f64 = 50e-6;
/// Changes the seed for the generator of wander.
const WANDERING: u64 = 0x0077_616e_6465_7273;

/// Finger, drivetrain, bridge, sensors and object.
#[derive(Clone, Debug)]
pub struct Plant {
    parameters: Parameters,
    mechanics: Box<dyn Mechanics>,
    drivetrain: Drivetrain,
    bridge: Bridge,
    encoder: QuadratureEncoder,
    random: Pcg64Mcg,
    /// Wander has a separate generator, so that it does not change other noise.
    wandering: Pcg64Mcg,
    /// Faults to inject.
    pub faults: Faults,
    time: f64,
    /// Input-link angle at the drivetrain's zero.
    origin: f64,
    half_backlash: f64,
    cable: Cable,
    ripple_phase: f64,
    pins: Pins,
    drawn: f64,
    /// Drift of the current sense's offset at a time.
    drift_a: Last,
    /// Of the current sense at this instant: noise in either half of a period of the PWM, and the voltage where the bridge is off or its
    /// current has no edges.
    sense_noise_v: [f64; 2],
    sense_v: f64,
    supply_v: f64,
    supply_sense_v: f64,
    hall_v: f64,
    bridge_fault: bool,
    first: Option<FirstContact>,
}

impl Plant {
    /// A world at rest, the input link a little above its opening stop. The same arguments give the same world and the
    /// same noise.
    ///
    /// # Errors
    /// A parameter out of range, a four-bar that does not close, an object that cannot be where it is wanted, or that is free.
    pub fn new(parameters: &Parameters, grasp: &Grasp, seed: u64) -> Result<Self, Error> {
        parameters.validate()?;
        let mechanics = Quasistatic::new(parameters)?;
        Self::with_mechanics(parameters, Box::new(mechanics), grasp, seed)
    }

    /// The same with another engine for finger and object; it stands at its rest pose.
    ///
    /// # Errors
    /// A parameter out of range, an object that cannot be where it is wanted.
    pub fn with_mechanics(
        parameters: &Parameters,
        mut mechanics: Box<dyn Mechanics>,
        grasp: &Grasp,
        seed: u64,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut signed = || random.random_range(-1.0..=1.0f64);
        let (gear_play, worm_play, ripple_phase) =
            (signed(), signed(), signed() * std::f64::consts::PI);
        let [opening, closing] = mechanics.state().stops_rad;
        let start = opening
            + parameters
                .mechanism
                .start_above_stop_rad
                .min(closing - opening);
        let stiffness = parameters.cable_stiffness_nm_per_rad();
        mechanics.settle(&CableEnd {
            low_rad: start,
            high_rad: start,
            stiffness_nm_per_rad: stiffness,
        });
        let half_backlash = 0.5 * parameters.worm.backlash_counts / parameters.counts_per_rad();
        let mut wandering = Pcg64Mcg::seed_from_u64(seed ^ WANDERING);
        let mut drivetrain = Drivetrain::new(parameters, gear_play, &mut wandering);
        // A finger with a spring at joint 1 rests on the closing flank, one without anywhere between the flanks.
        let finger = mechanics.state();
        let sprung = finger.torque_nm > 1e-9;
        let flank = if sprung {
            half_backlash
        } else {
            worm_play * half_backlash
        };
        let hanging = if sprung { start } else { finger.theta_a_rad };
        let mut plant = Self {
            origin: hanging + flank - drivetrain.output(),
            mechanics,
            drivetrain,
            bridge: Bridge::new(parameters),
            encoder: QuadratureEncoder::new(&parameters.encoder, &mut wandering),
            random,
            wandering,
            faults: Faults::default(),
            time: 0.0,
            half_backlash,
            cable: Cable::new(parameters),
            ripple_phase,
            pins: Pins::default(),
            drawn: 0.0,
            drift_a: Last::new(),
            sense_noise_v: [0.0; 2],
            sense_v: 0.0,
            supply_v: parameters.supply.voltage_v,
            supply_sense_v: 0.0,
            hall_v: 0.0,
            bridge_fault: false,
            first: None,
            parameters: parameters.clone(),
        };
        plant.place(grasp)?;
        plant.measure();
        Ok(plant)
    }

    /// Replaces or removes ([`Grasp::Free`]) the object and forgets the first contact.
    ///
    /// # Errors
    /// The object cannot be there, or overlaps the finger; the previous one then stays.
    pub fn place(&mut self, grasp: &Grasp) -> Result<(), Error> {
        self.mechanics.place(grasp)?;
        self.first = None;
        Ok(())
    }

    /// Holds what is placed from now on as this says.
    ///
    /// # Errors
    /// The engine has no such mount.
    pub fn mount(&mut self, object: &Object) -> Result<(), Error> {
        self.mechanics.mount(object)?;
        self.parameters.object = *object;
        Ok(())
    }

    /// Moves the object, in contact or not: it gives way, or presses the finger.
    ///
    /// # Errors
    /// The engine cannot have it there.
    pub fn shift(&mut self, by_m: [f64; 2]) -> Result<(), Error> {
        self.mechanics.shift(by_m)
    }

    /// Restarts the noise from another seed; nothing else changes.
    pub fn reseed(&mut self, seed: u64) {
        self.random = Pcg64Mcg::seed_from_u64(seed);
        self.wandering = Pcg64Mcg::seed_from_u64(seed ^ WANDERING);
    }

    /// Steps by `dt_s` seconds with these levels on the pins.
    pub fn step(&mut self, pins: &Pins, dt_s: f64) {
        self.pins = *pins;
        self.bridge_fault = false;
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        let parts = if dt_s <= MAX_STEP_S {
            1.0
        } else {
            (dt_s / MAX_STEP_S - 1e-9).ceil().max(1.0)
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least one"
        )]
        for _ in 0..parts as u64 {
            self.advance(dt_s / parts);
        }
        self.measure();
    }

    fn advance(&mut self, dt: f64) {
        let offset_a = self.sense_offset_a();
        let Parameters { motor, supply, .. } = &self.parameters;
        let load = self.mechanics.state().torque_nm;
        let open_circuit = self.faults.supply_v.unwrap_or(supply.voltage_v);
        let forced = self.faults.supply_v.is_some();
        self.supply_v = supply::after(supply, self.supply_v, open_circuit, forced, self.drawn, dt);
        let ripple = motor.commutation_per_rev * self.drivetrain.phase() + self.ripple_phase;
        let constant = motor.torque_constant_nm_per_a
            * self.bridge.magnets()
            * (1.0 + 0.5 * motor.commutation_ripple * ripple.cos());
        let emf = constant * self.drivetrain.speed;
        let short = self.faults.winding_left.clamp(1e-3, 1.0);
        let voltages = [self.supply_v, emf];
        let electric = self.bridge.step(&self.pins, voltages, short, offset_a, dt);
        self.drawn = electric.drawn_a;
        self.bridge_fault |= electric.fault;
        if self.faults.rotor_locked {
            self.drivetrain.speed = 0.0;
        } else {
            let torque = constant * electric.mean_a;
            self.drivetrain.step(torque, load, dt, &mut self.wandering);
        }
        self.cable.creep(load, dt);
        let middle = self.origin + self.drivetrain.output();
        let end = self.cable.end(middle, self.half_backlash, load);
        self.mechanics.break_stops(self.faults.stops_missing);
        self.mechanics
            .weaken_springs(self.faults.springs_left.clamp(0.0, 1.0));
        self.mechanics.step(&end, dt);
        self.encoder
            .wander(self.drivetrain.rotor, &mut self.wandering);
        self.encoder.turn(
            self.drivetrain.rotor,
            &self.faults.encoder,
            &mut self.random,
            dt,
        );
        self.time += dt;
        let finger = self.mechanics.state();
        if self.first.is_none()
            && let Some(contact) = finger.contacts.first()
        {
            self.first = Some(FirstContact {
                time_s: self.time,
                contact: *contact,
                joint_rad: finger.joint_rad,
                theta_a_rad: finger.theta_a_rad,
                torque_nm: finger.torque_nm,
            });
        }
    }

    /// Offset of the current sense, ampere. A shunt's does not drift.
    fn sense_offset_a(&mut self) -> f64 {
        let sense = &self.parameters.sense;
        let drift = if sense.is_shunt() {
            0.0
        } else {
            self.drift_a.of(self.time, || {
                sense.offset_drift_a * (1.0 - (-self.time / sense.offset_drift_time_s).exp())
            })
        };
        sense.offset_a + drift + self.faults.sense_offset_a
    }

    /// Draws the noise of this instant once, so that repeated reads agree.
    fn measure(&mut self) {
        let offset_a = self.sense_offset_a();
        let mut noise = |rms: f64| -> f64 {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            rms * normal
        };
        let Parameters {
            sense,
            supply,
            hall,
            ..
        } = &self.parameters;
        let current_noise = noise(sense.noise_rms_a);
        // White noise: of the mean of both halves, and as large of half their difference.
        let uneven = noise(sense.noise_rms_a);
        let gain = 1.0 + sense.gain_error;
        let seen_a = if sense.is_shunt() {
            self.bridge.current_a() * gain + offset_a
        } else if self.bridge.senses(self.supply_v) {
            self.bridge.sensed_a(&self.pins, self.supply_v) * gain + offset_a
        } else {
            0.0
        };
        let (zero_v, volt_per_a) = (sense.zero_v(), sense.volt_per_a());
        self.sense_noise_v =
            [current_noise - uneven, current_noise + uneven].map(|a| a * volt_per_a);
        self.sense_v =
            (zero_v + (seen_a + current_noise) * volt_per_a).clamp(0.0, sense.full_scale_v);
        let supply_noise = noise(supply.noise_rms_v);
        self.hall_v = hall.zero_v
            + hall.sensitivity_v_per_rad * self.mechanics.state().joint_rad[1]
            + noise(hall.noise_rms_v);
        self.supply_sense_v =
            ((self.supply_v + supply_noise) * supply.divider).clamp(0.0, sense.full_scale_v);
    }

    /// Simulated time since [`Plant::new`], second.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time
    }

    /// Count of a four-edge quadrature counter on the encoder's wires since [`Plant::new`], closing positive.
    #[must_use]
    pub fn encoder_count(&self) -> i64 {
        self.encoder.count
    }

    /// Levels of phases A and B; A leads while closing.
    #[must_use]
    pub fn encoder_phases(&self) -> (bool, bool) {
        self.encoder.phases()
    }

    /// The timer of the PWM counts zero now, the middle of the on-time. It does after every step of whole periods.
    pub fn align_pwm(&mut self) {
        self.bridge.align();
    }

    /// Voltage of the supply's divider.
    #[must_use]
    pub fn supply_sense_v(&self) -> f64 {
        self.supply_sense_v
    }

    /// Voltage of the optional angle sensor at joint 2.
    #[must_use]
    pub fn hall_v(&self) -> f64 {
        self.hall_v
    }

    /// Whether nFAULT was low in the last step: chopping, or a low supply while awake.
    #[must_use]
    pub fn fault_pin_low(&self) -> bool {
        self.bridge_fault
    }

    /// The parameters it was made with.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Winding temperature, degree Celsius.
    #[must_use]
    pub fn winding_c(&self) -> f64 {
        self.bridge.winding_c()
    }

    /// The hidden state.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let finger = self.mechanics.state();
        let cable = self.cable.energy(finger.torque_nm);
        Truth {
            time_s: self.time,
            phalanges: finger.phalanges,
            joint_rad: finger.joint_rad,
            theta_a_rad: finger.theta_a_rad,
            opening_stop_rad: finger.stops_rad[0],
            closing_stop_rad: finger.stops_rad[1],
            torque_nm: finger.torque_nm,
            motor_current_a: self.bridge.current_a(),
            motor_speed_rad_per_s: self.drivetrain.speed,
            motor_angle_rad: self.drivetrain.rotor,
            supply_v: self.supply_v,
            winding_c: self.bridge.winding_c(),
            pins: self.pins,
            contacts: finger.contacts.clone(),
            first_contact: self.first,
            stored_energy_j: self.drivetrain.energy() + self.mechanics.energy_j() + cable,
        }
    }
}
