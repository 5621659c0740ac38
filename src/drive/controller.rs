//! The control interrupt's work as a pure function: inputs and demand to outputs, 20,000 times a second.
//!
//! On the chip it runs from CCM SRAM (`memory.x`) and must call nothing outside: no panic, no copy above 24 bytes (`memcpy`).

mod output;

use super::average::{Average, PERIODS_PER_SAMPLE, Period, SAMPLE_HZ};
use super::config::CheckedConfig;
use super::convert::{self, Scale};
use super::current::CurrentLoop;
use super::demand::{Demand, OffsetState, Setpoint, Status};
use super::encoder::Encoder;
use super::fault::Fault;
use super::io::{CONTROL_HZ, Inputs, Outputs};
use super::limit::Travel;
use super::offset::{OffsetMeter, OffsetReading};
use super::protect::{BridgeState, FREE_SLOT, PeriodState, Protection, SLOTS};
use super::sign::{CurrentSign, Driven, Flow};
use super::speed::{PERIODS_PER_STEP, SpeedLoop};
use super::thermal::{Temperatures, Winding};
use crate::sample::{Drive, Sample};

/// The period of a sample in which the thermal model advances by the sample before: one with no slow detector.
const HEAT_PERIOD: u8 = FREE_SLOT + 1;
/// The one in which the current loop adapts to the resistance that follows from it.
const ADAPT_PERIOD: u8 = HEAT_PERIOD + SLOTS;
/// The one in which the current's sign is judged.
const SIGN_PERIOD: u8 = ADAPT_PERIOD + SLOTS;
/// The one in which the position is compared with the travel.
const TRAVEL_PERIOD: u8 = SIGN_PERIOD + SLOTS;
// At equal distances.
const _: () = assert!(PERIODS_PER_STEP == SLOTS && PERIODS_PER_SAMPLE.is_multiple_of(SLOTS));
// The last period of a sample, which completes it, leaves the slow detectors out.
const _: () = assert!((PERIODS_PER_SAMPLE - 1) % SLOTS == FREE_SLOT);
const SAMPLE_S: f32 = 1.0 / SAMPLE_HZ as f32;
const SAMPLE_US: u64 = 1_000_000 / SAMPLE_HZ as u64;
/// Periods (1.5 ms) between waking the bridge and enabling the outputs: it needs 1 ms.
const WAKE_PERIODS: u8 = 30;
/// A low-pass of 16 periods on the supply: its ripple must not reach the duty, its sag within a millisecond must.
const SUPPLY_GAIN: f32 = 1.0 / 16.0;

/// State of the control loop.
#[derive(Clone, Debug)]
pub struct Controller {
    scale: Scale,
    current_limit_a: f32,
    /// The current sense tells the sign.
    signed: bool,
    sign: CurrentSign,
    travel: Travel,
    encoder: Encoder,
    current: CurrentLoop,
    speed: SpeedLoop,
    winding: Winding,
    protection: Protection,
    meter: OffsetMeter,
    average: Average,
    /// What the bridge did in the period that just ended.
    applied: Outputs,
    /// The same as a fraction of the supply, closing positive.
    applied_fraction: f32,
    /// Counts beyond the limits of the travel: negative on the opening side, 0 within.
    beyond_counts: i32,
    hot: bool,
    reference_a: f32,
    supply_v: f32,
    per_supply_v: f32,
    waking: u8,
    in_speed: bool,
    measuring: bool,
    /// Current of the period that ended, closing positive, where it flowed the way that was asked for.
    measured_a: Option<f32>,
    status: Status,
    /// The last step completed a sample, which has not been taken.
    completed: bool,
    drive: Drive,
    /// Back-EMF at the end of the last sample, volt.
    emf_v: f32,
    /// Mean square of the sample's current, for the thermal model's turn.
    mean_square_a2: f32,
}

impl Controller {
    /// A controller at rest, the motor at ambient temperature.
    pub fn new(drive: &CheckedConfig) -> Self {
        Self::at(drive, Temperatures::ambient(&drive.config().motor))
    }

    /// A controller at rest, the motor at these temperatures.
    pub fn at(drive: &CheckedConfig, temperatures: Temperatures) -> Self {
        let (config, scale) = (drive.config(), *drive.scale());
        let limits = &config.limits;
        Self {
            current_limit_a: limits.current_a,
            signed: config.sense.signed,
            sign: CurrentSign::new(&scale),
            travel: Travel {
                min_counts: scale.counts(limits.position_min_rad),
                max_counts: scale.counts(limits.position_max_rad),
            },
            encoder: Encoder::default(),
            current: CurrentLoop::new(config, scale.emf_v_per_count_per_period()),
            speed: SpeedLoop::new(config, &scale),
            winding: Winding::new(&config.motor, temperatures),
            protection: Protection::new(config, &scale),
            meter: OffsetMeter::default(),
            average: Average::default(),
            applied: Outputs::Off,
            applied_fraction: 0.0,
            beyond_counts: 0,
            hot: false,
            reference_a: 0.0,
            supply_v: 0.0,
            per_supply_v: 0.0,
            waking: WAKE_PERIODS,
            in_speed: false,
            measuring: false,
            measured_a: None,
            status: Status::default(),
            completed: false,
            drive: Drive::Idle,
            emf_v: 0.0,
            mean_square_a2: 0.0,
            scale,
        }
    }

    /// One control period (50 us): what was measured while the last outputs were applied, what is wanted, and what the
    /// bridge shall do.
    pub fn step(&mut self, inputs: &Inputs, demand: &Demand) -> Outputs {
        self.completed = false;
        self.acknowledge(demand);
        let encoder_plausible = self.encoder.update(inputs.encoder);
        self.observe(inputs, encoder_plausible, demand.setpoint);
        self.applied = self.decide(demand.setpoint);
        self.applied_fraction = convert::applied(self.applied);
        self.applied
    }

    /// The 1 ms average completed by the last step, once: every twentieth call of [`step`](Self::step) makes one.
    pub fn sample(&mut self) -> Option<Sample> {
        if !self.completed {
            return None;
        }
        self.completed = false;
        Some(Sample {
            time_us: self.status.time_us,
            position_counts: self.status.position_counts,
            current_a: self.status.current_a,
            emf_v: self.emf_v,
            drive: self.drive,
            joint: (),
        })
    }

    /// Measurements, limits and faults as of the last step.
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// The scales of this board and drivetrain.
    pub fn scale(&self) -> &Scale {
        &self.scale
    }

    /// Answers what the demand requests by a changed number: a new zero, clearing a fault.
    fn acknowledge(&mut self, demand: &Demand) {
        if demand.zero != self.status.zero {
            self.status.zero = demand.zero;
            self.encoder.rezero(demand.zero_at_counts);
            // Whoever sees the echo must not see a position of before it, which the next sample alone would replace.
            self.status.position_counts = self.encoder.position_counts();
            self.status.homed = true;
        }
        if demand.clear != self.status.clear {
            self.status.clear = demand.clear;
            self.status.fault = None;
            // The fault may have lost counts: the zero is found anew.
            self.status.homed = false;
            self.protection.clear();
            self.encoder.settle();
        }
    }

    /// Checks the period that ended for faults and adds it to the sample.
    fn observe(&mut self, inputs: &Inputs, encoder_plausible: bool, setpoint: Setpoint) {
        let raw_a = self.scale.current_a(inputs.current);
        let supply_v = self.scale.supply_v(inputs.supply);
        self.supply_v += SUPPLY_GAIN * (supply_v - self.supply_v);
        let observed = PeriodState {
            state: match self.applied {
                Outputs::Off => {
                    // Nothing is drawn: where the low-pass begins.
                    self.supply_v = supply_v;
                    BridgeState::Asleep
                }
                // In the last period of waking nFAULT must be high: the outputs are enabled next.
                Outputs::Wake if self.waking > 0 => BridgeState::Waking,
                _ => BridgeState::Awake,
            },
            applied_v: self.applied_fraction * self.supply_v,
            reference_a: self.reference_a,
            reading_a: if self.signed && self.applied_fraction < 0.0 {
                self.status.offset_a - raw_a
            } else {
                raw_a - self.status.offset_a
            },
            supply_v,
            speed: self.encoder.speed(),
            encoder_plausible,
            beyond_counts: self.beyond_counts.wrapping_abs(),
            hot: self.hot,
        };
        let mut fault = self
            .protection
            .check(inputs, &observed, self.average.periods() % SLOTS);
        let measured = self.measure_offset(setpoint, raw_a, observed.speed);
        if matches!(measured, OffsetReading::OutOfRange) {
            fault = fault.or(Some(Fault::OffsetOutOfRange));
        }
        if fault.is_some() && self.status.fault.is_none() {
            self.status.fault = fault;
        }
        self.status.present = if fault.is_some() {
            fault
        } else {
            self.protection.lasting(self.status.fault, inputs, supply_v)
        };
        self.sign.add(inputs.late_excess);
        self.accumulate(&observed);
    }

    /// Runs the offset's measurement while it is asked for and the bridge brakes.
    fn measure_offset(&mut self, setpoint: Setpoint, raw_a: f32, speed: f32) -> OffsetReading {
        let asked = matches!(setpoint, Setpoint::MeasureOffset);
        if !asked || !matches!(self.applied, Outputs::Brake) {
            self.measuring = false;
            return OffsetReading::Pending;
        }
        if !self.measuring {
            self.measuring = true;
            self.meter = OffsetMeter::default();
            self.status.offset = OffsetState::Measuring;
        }
        if self.status.offset != OffsetState::Measuring {
            return OffsetReading::Pending;
        }
        let measured = self.meter.update(raw_a, speed);
        match measured {
            OffsetReading::Pending => {}
            OffsetReading::Offset(offset_a) => {
                self.status.offset_a = offset_a;
                self.status.offset = OffsetState::Known;
            }
            OffsetReading::OutOfRange => self.status.offset = OffsetState::Unknown,
        }
        measured
    }

    /// Adds the period that ended to the sample, and completes it with the twentieth.
    fn accumulate(&mut self, observed: &PeriodState) {
        // A sense with a sign needs no judgement.
        let asked_along = self.signed || observed.asks_along();
        let flow = if asked_along || observed.applied_v != 0.0 {
            self.sign.flow()
        } else {
            Flow::braking(observed.state == BridgeState::Awake, observed.speed)
        };
        let closing = observed.applied_v >= 0.0;
        // Current and speed as seen along the voltage.
        let (toward, speed_along) = if closing {
            (flow.gain, observed.speed)
        } else {
            (-flow.gain, -observed.speed)
        };
        let signed_a = toward * observed.reading_a;
        // A current that does not flow the way it was asked to is about to turn, or the sense cannot tell its sign: neither is an
        // error for the loop to integrate.
        self.measured_a = if flow.opposes != asked_along {
            Some(signed_a)
        } else {
            None
        };
        match self.average.add(Period {
            signed_a,
            closing,
            speed_along: if asked_along && observed.applied_v != 0.0 && !flow.opposes {
                speed_along
            } else {
                0.0
            },
        }) {
            HEAT_PERIOD => self.heat(),
            ADAPT_PERIOD => self.current.adapt(
                self.winding.relative_resistance(),
                self.reference_a,
                observed.speed,
            ),
            TRAVEL_PERIOD => self.find_travel(),
            SIGN_PERIOD => self.judge_sign(observed),
            PERIODS_PER_SAMPLE => self.complete_sample(observed.applied_v),
            _ => {}
        }
    }

    /// Once a millisecond: how far the position is beyond the travel, if it is known.
    fn find_travel(&mut self) {
        self.beyond_counts = if self.status.homed {
            self.travel.beyond_counts(self.encoder.position_counts())
        } else {
            0
        };
    }

    /// Once a millisecond: whether the current opposes the drive.
    fn judge_sign(&mut self, observed: &PeriodState) {
        // A sense with a sign says so itself.
        let tells = observed.state == BridgeState::Awake && !self.signed;
        self.sign.judge(tells.then_some(Driven {
            reading_a: observed.reading_a,
            duty: self.applied_fraction.abs(),
            reference_opposes: !observed.asks_along(),
        }));
    }

    /// Once a millisecond, not in the period that has a sample to complete: the winding's temperature, and the supply's
    /// reciprocal.
    fn heat(&mut self) {
        self.winding.advance(self.mean_square_a2, SAMPLE_S);
        self.hot = self.winding.is_hot();
        self.status.winding_c = self.winding.celsius();
        self.status.housing_c = self.winding.housing_c();
        // Not below 1 V, nor NaN.
        self.per_supply_v = if self.supply_v > 1.0 {
            1.0 / self.supply_v
        } else {
            1.0
        };
    }

    /// Completes the sample.
    fn complete_sample(&mut self, applied_v: f32) {
        let average = core::mem::take(&mut self.average);
        let averaged = average.averaged();
        self.drive = averaged.drive;
        self.status.time_us = self.status.time_us.wrapping_add(SAMPLE_US);
        self.status.position_counts = self.encoder.position_counts();
        self.status.speed_counts_per_s = self.encoder.speed() * CONTROL_HZ as f32;
        self.mean_square_a2 = averaged.mean_square_a2;
        self.status.current_a = averaged.current_a;
        self.status.supply_v = self.supply_v;
        self.status.applied_v = applied_v;
        self.emf_v = self.current.emf_v(self.encoder.speed());
        self.status.limited = average.limited;
        self.completed = true;
    }
}
