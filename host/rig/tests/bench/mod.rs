//! A plain speed loop around the plant, for judging sensing by itself: no controller of the library is in it.

use palpate::scene::Scene;
use palpate::sensing::{Calibration, Directive, Drive, Event, Sample, Sensor};
use palpate_plant::{FingerKind, Grasp, Parameters, Pins, Plant};

/// Step of the loop, second.
const DT_S: f64 = 50e-6;
/// Steps a sample.
const STEPS: u32 = 20;

/// Plant, loop and sensor.
pub struct Bench<S: Scene> {
    pub plant: Plant,
    pub sensor: Sensor<S::Finger>,
    pub events: Vec<(u64, Event)>,
    duty_integral: f64,
    reference: f64,
    offset_v: f64,
    zero: i64,
    last_count: i64,
    speed: f64,
    time_us: u64,
    counts_per_rad: f64,
    spent: u32,
    pub trace: Option<Vec<(Sample, f64, f64)>>,
}

impl<S: Scene> Bench<S> {
    pub fn new(
        parameters: &Parameters,
        kind: FingerKind,
        seed: u64,
        calibration: Option<Calibration>,
    ) -> Self {
        let plant = Plant::new(parameters, kind, &Grasp::Free, seed).expect("plant");
        let finger = S::finger().expect("finger");
        let drivetrain = S::drivetrain(&finger);
        let sensor = Sensor::new(
            finger,
            drivetrain,
            S::settings(),
            calibration.unwrap_or(S::UNCALIBRATED),
        );
        let mut bench = Self {
            counts_per_rad: parameters.counts_per_rad(),
            plant,
            sensor,
            events: Vec::new(),
            duty_integral: 0.0,
            reference: 0.0,
            offset_v: 0.0,
            zero: 0,
            last_count: 0,
            speed: 0.0,
            time_us: 0,
            spent: 0,
            trace: None,
        };
        bench.measure_offset();
        bench.time_us = (bench.plant.time_s() * 1e6) as u64;
        bench.home();
        bench
    }

    fn measure_offset(&mut self) {
        let pins = Pins {
            outputs_enabled: true,
            awake: true,
            duty: 0.0,
            closing: true,
        };
        let mut sum = 0.0;
        for step in 0..8000 {
            self.plant.step(&pins, DT_S);
            if step >= 4000 {
                sum += quantised(self.plant.current_sense_v());
            }
        }
        self.offset_v = sum / 4000.0;
    }

    /// Opens until it stands still; that is the opening stop.
    fn home(&mut self) {
        self.zero = self.plant.encoder_count();
        self.last_count = self.zero;
        let mut still = 0;
        for _ in 0..6000 {
            self.millisecond(-0.2, 0.05);
            still = if self.speed.abs() < 0.02 {
                still + 1
            } else {
                0
            };
            if still > 100 {
                break;
            }
        }
        self.zero = self.plant.encoder_count();
        self.last_count = self.zero;
        for _ in 0..50 {
            self.millisecond(0.0, 0.05);
        }
    }

    /// One sample; `wanted` in rad/s at the input link; `limit_a` of the motor current. Returns the current.
    pub fn millisecond(&mut self, wanted: f64, limit_a: f64) -> f64 {
        self.spent += 1;
        assert!(self.spent < 30_000, "the motion does not end: at {} rad, {} rad/s wanted {wanted}", self.angle(), self.speed);
        let step = 5.0 * 1e-3;
        self.reference += (wanted - self.reference).clamp(-step, step);
        let error = self.reference - self.speed;
        let emf = |speed: f64| speed * 1280.0 * 8.9e-3 / 12.0;
        let limit = |current: f64, speed: f64| (current * 35.0) / 12.0 + emf(speed);
        let mut current_v = 0.0;
        let stop = wanted == 0.0;
        let closing = self.reference >= 0.0;
        let low = limit(-limit_a, self.speed);
        let high = limit(limit_a, self.speed);
        self.duty_integral = (self.duty_integral + 0.02 * error).clamp(-1.0, 1.0);
        let raw = emf(self.reference) + 0.6 * error + self.duty_integral;
        let duty = if stop { 0.0 } else { raw.clamp(low, high) };
        self.duty_integral += 0.2 * (duty - raw);
        if stop {
            self.duty_integral = 0.0;
            self.reference = 0.0;
        }
        let forward = duty >= 0.0;
        let pins = Pins {
            outputs_enabled: true,
            awake: true,
            duty: duty.abs().min(0.95),
            closing: forward,
        };
        for _ in 0..STEPS {
            self.plant.step(&pins, DT_S);
            current_v += quantised(self.plant.current_sense_v()) - self.offset_v;
        }
        self.time_us += 1000;
        let count = self.plant.encoder_count();
        let fresh = (count - self.last_count) as f64 / self.counts_per_rad / 1e-3;
        self.speed += 0.5 * (fresh - self.speed);
        self.last_count = count;
        let current_a = current_v / f64::from(STEPS) / 6.8 * if forward { 1.0 } else { -1.0 };
        let drive = if stop || forward != closing {
            Drive::Idle
        } else if closing {
            Drive::Closing
        } else {
            Drive::Opening
        };
        let sample = Sample {
            time_us: self.time_us,
            position_counts: (count - self.zero) as i32,
            current_a: current_a as f32,
            drive,
        };
        if let Some(trace) = &mut self.trace {
            let truth = self.plant.truth();
            trace.push((sample, truth.theta_a_rad, truth.torque_nm));
        }
        if let Some(event) = self.sensor.update(&sample) {
            self.events.push((self.time_us, event));
        }
        current_a
    }

    pub fn angle(&self) -> f64 {
        (self.last_count - self.zero) as f64 / self.counts_per_rad
    }

    /// Free closing and opening, recorded.
    pub fn record(&mut self, passes: usize) {
        self.sensor.direct(Directive::RecordFriction);
        let travel = f64::from(S::TRAVEL_RAD);
        for _ in 0..passes {
            while self.angle() < travel {
                self.millisecond(0.3, 0.12);
            }
            self.rest(100);
            self.open(0.3);
        }
        self.sensor.direct(Directive::Rest);
        self.rest(20);
    }

    pub fn rest(&mut self, milliseconds: u32) {
        for _ in 0..milliseconds {
            self.millisecond(0.0, 0.12);
        }
    }

    pub fn open(&mut self, speed: f64) {
        self.spent = 0;
        while self.angle() > 0.03 {
            self.millisecond(-speed, 0.12);
        }
        self.rest(100);
    }

    /// Closes under a directive until what was found is settled, the torque is spent, or the travel ends.
    pub fn close(&mut self, directive: Directive, grasp: &Grasp) {
        self.events.clear();
        self.spent = 0;
        self.plant.place(grasp).expect("place");
        self.sensor.direct(directive);
        let press = directive == Directive::CalibrateCable;
        let travel = f64::from(S::TRAVEL_RAD) + if press { 0.8 } else { 0.0 };
        let mut touched: Option<f64> = None;
        let mut stalled = 0;
        loop {
            let current = self.millisecond(0.3, 0.12);
            let mut over = false;
            for (_, event) in &self.events {
                match event {
                    Event::Touch { .. } if touched.is_none() => touched = Some(self.angle()),
                    Event::Located { settled: true, .. }
                    | Event::Ambiguous { settled: true, .. }
                    | Event::NotLocated { .. }
                    | Event::Unusual { .. } => over = true,
                    _ => {}
                }
            }
            stalled = if self.speed < 0.1 && self.reference > 0.25 {
                stalled + 1
            } else {
                0
            };
            let end = match touched {
                Some(from) => self.angle() > from + 1.0,
                None => self.angle() > travel,
            };
            if over || end || stalled > 20 || (touched.is_some() && current > 0.108) {
                break;
            }
        }
        self.sensor.direct(Directive::Rest);
        self.rest(220);
    }

    pub fn back(&mut self) {
        self.open(0.6);
        self.plant.place(&Grasp::Free).expect("nothing");
    }
}

fn quantised(volt: f64) -> f64 {
    (volt / 3.3 * 4096.0).floor().clamp(0.0, 4095.0) * 3.3 / 4096.0
}
