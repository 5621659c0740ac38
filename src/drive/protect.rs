//! Fault detection: compares what was applied in the last control period with what was measured.
//!
//! Every limit below stands with the reason why no healthy motion reaches it. Electrical limits trip on one reading: each
//! is the mean of 16 conversions over a whole PWM period, which one disturbed conversion cannot push past them.
//!
//! What endangers something within a millisecond is judged in every period. What takes many periods to be told from healthy
//! motion has a slot of its own, one of [`SLOTS`] periods, so that no period pays for all of it.

use super::config::Config;
use super::convert::Scale;
use super::fault::Fault;
use super::io::{ADC_FULL, AdcCode, Inputs};

/// A reading this close to full scale is no measurement any more: 485 mA, twice the over-current trip.
const SATURATED: AdcCode = AdcCode(ADC_FULL - 16 * 8);
/// Periods in which every slow detector runs once.
pub const SLOTS: u8 = 4;
/// The slot of the detector that takes the fewest instructions.
pub const OFFSET_SLOT: u8 = 2;
/// The slot without a detector: the controller completes its sample in it.
pub const FREE_SLOT: u8 = 3;
/// The very same sum of 16 conversions in so many successive checks (2 ms), while the motor turns. The sense has 0.1 mA rms of
/// noise before averaging, 3 codes after: 10 equal readings by chance have a probability of 6e-11, which the motor would take a month of
/// turning to meet.
const SAME_READINGS: u16 = 10;
/// Slowest motion, counts a period, that counts as turning: 0.05 rad/s at the prototype's input link.
const TURNING: f32 = 0.5;
/// Checks (10 ms) that the back-EMF may contradict the encoder. A blow stops the rotor faster than the observer (1 ms)
/// follows, and settles within 5 ms.
const CONTRADICTION_CHECKS: u16 = 50;
/// Voltage the model may be off without a contradiction: 1 V for bridge, offset and sudden motion; 30 % of the resistive
/// part (20 % spread, and warmth); 20 % of the back-EMF (10 % spread).
const SLACK_V: f32 = 1.0;
const SLACK_RESISTIVE: f32 = 0.3;
const SLACK_EMF: f32 = 0.2;
/// Current that must flow before a reading of nothing is suspicious, ampere: offset (7 mA at most) and a little.
const EXPECTED_A: f32 = 10e-3;
/// A reading of nothing, ampere.
const NOTHING_A: f32 = 2e-3;
/// Checks (0.2 s) for which a driven, turning motor may show no current at all: only while it slows down, which the
/// limited acceleration makes shorter than that. Otherwise friction alone takes several times `NOTHING_A`.
const NOTHING_CHECKS: u16 = 1000;
/// Reading at rest that is no offset, ampere: the amplifier's 7 mA, drift, and a margin as large.
pub const OFFSET_LIMIT_A: f32 = 15e-3;
/// Checks (20 ms) at rest before its reading is judged, and that it must persist: winding currents die in microseconds,
/// the rotor stops within its mechanical time constant of 4 ms.
const REST_CHECKS: u16 = 100;

/// Counts how long a condition persists.
#[derive(Clone, Copy, Debug, Default)]
struct Persistence(u16);

impl Persistence {
    /// `true` from the moment the condition has held for more than `limit` checks; a check where it does not hold takes one off. No more
    /// are counted than that: what was mended is seen at once, however long it was wrong.
    fn update(&mut self, holds: bool, limit: u16) -> bool {
        self.0 = if holds {
            self.0.saturating_add(1).min(limit.saturating_add(1))
        } else {
            self.0.saturating_sub(1)
        };
        self.0 > limit
    }
}

/// What the bridge did in a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BridgeState {
    /// Off.
    Asleep,
    /// Waking up, outputs off: its fault pin says nothing yet.
    Waking,
    /// Driven or braking, or about to be.
    Awake,
}

/// What the controller knows about the period that just ended.
#[derive(Clone, Copy, Debug)]
pub struct PeriodState {
    /// What the bridge did.
    pub state: BridgeState,
    /// Motor voltage applied, closing positive; 0 in brake.
    pub applied_v: f32,
    /// Current reference it was applied for; 0 when not driving.
    pub reference_a: f32,
    /// Reading of the current sense without its offset: a magnitude, or along the voltage where the sense is signed.
    pub reading_a: f32,
    /// Supply, volt.
    pub supply_v: f32,
    /// Speed by the encoder, counts a period.
    pub speed: f32,
    /// The encoder's last step is one that a motor can make.
    pub encoder_plausible: bool,
    /// Counts beyond the limits of the travel, 0 within or before homing.
    pub beyond_counts: i32,
    /// Winding beyond its temperature.
    pub hot: bool,
}

impl PeriodState {
    /// Whether the reference asks for a current along the voltage. However small the reference is, the sense tells as much as its
    /// offset allows: with an offset of -7 mA, which an unsigned converter cannot even see, free motion may read as little as
    /// 3 mA.
    #[inline(always)]
    pub fn asks_along(&self) -> bool {
        self.reference_a * self.applied_v > 0.0
    }
}

/// The detectors' state.
#[derive(Clone, Debug)]
pub struct Protection {
    trip_a: f32,
    /// Readings below this are at the lower end of the converter; a magnitude may well be there.
    lowest: AdcCode,
    supply_min_v: f32,
    supply_max_v: f32,
    resistance_ohm: f32,
    emf_v_per_speed: f32,
    braking_a_per_speed: f32,
    overtravel_counts: i32,
    last_code: AdcCode,
    same_readings: u16,
    nothing: Persistence,
    idle_reading: Persistence,
    contradiction: Persistence,
    rest: u16,
    offset: Persistence,
    /// By the last check of its slot.
    offset_is_wrong: bool,
}

impl Protection {
    /// Detectors for a configuration.
    pub fn new(config: &Config, scale: &Scale) -> Self {
        Self {
            trip_a: config.limits.current_trip_a,
            lowest: if config.sense.signed {
                AdcCode(ADC_FULL - SATURATED.0)
            } else {
                AdcCode(0)
            },
            supply_min_v: config.limits.supply_min_v,
            supply_max_v: config.limits.supply_max_v,
            resistance_ohm: config.motor.circuit_ohm(),
            emf_v_per_speed: scale.emf_v_per_count_per_period(),
            braking_a_per_speed: scale.emf_v_per_count_per_period() / config.motor.circuit_ohm(),
            overtravel_counts: scale.counts(config.limits.overtravel_rad),
            last_code: AdcCode(0),
            same_readings: 0,
            nothing: Persistence::default(),
            idle_reading: Persistence::default(),
            contradiction: Persistence::default(),
            rest: 0,
            offset: Persistence::default(),
            offset_is_wrong: false,
        }
    }

    /// Forgets what led to a fault.
    pub fn clear(&mut self) {
        self.same_readings = 0;
        self.nothing = Persistence::default();
        self.idle_reading = Persistence::default();
        self.contradiction = Persistence::default();
        self.rest = 0;
        self.offset = Persistence::default();
        self.offset_is_wrong = false;
    }

    /// The most severe fault of this period. `slot` counts the periods, modulo [`SLOTS`].
    pub fn check(&mut self, inputs: &Inputs, observed: &PeriodState, slot: u8) -> Option<Fault> {
        let slow = match slot {
            0 => self.sense_stuck(inputs.current, observed),
            1 => self.contradiction(observed),
            OFFSET_SLOT => {
                self.offset_is_wrong = self.offset_is_wrong(observed);
                None
            }
            _ => None,
        };
        if observed.state == BridgeState::Awake && inputs.bridge_fault {
            return Some(Fault::Bridge);
        }
        if observed.state != BridgeState::Asleep {
            // While the bridge is off a late interrupt endangers nothing, and storing records delays it.
            if inputs.overrun {
                return Some(Fault::Overrun);
            }
            if observed.supply_v < self.supply_min_v {
                return Some(Fault::SupplyLow);
            }
            if !observed.encoder_plausible {
                return Some(Fault::EncoderJump);
            }
            if observed.beyond_counts > self.overtravel_counts {
                return Some(Fault::TravelLimit);
            }
        }
        if observed.supply_v > self.supply_max_v {
            return Some(Fault::SupplyHigh);
        }
        if inputs.current >= SATURATED || inputs.current < self.lowest {
            return Some(Fault::SenseSaturated);
        }
        // Braking, the motor's own voltage drives a current that its resistance alone limits: 0.26 A from 0.8 rad/s. It heats
        // the winding, which the thermal model sees, but is no short.
        let braking_a = if observed.applied_v == 0.0 {
            self.braking_a_per_speed * observed.speed.abs()
        } else {
            0.0
        };
        if observed.reading_a.abs() > self.trip_a + braking_a {
            return Some(Fault::OverCurrent);
        }
        if observed.hot {
            return Some(Fault::WindingHot);
        }
        if self.offset_is_wrong {
            // Report it in every period, not in its slot alone: `clear` asks in any period whether it is still there.
            return Some(Fault::OffsetOutOfRange);
        }
        slow
    }

    /// Returns the latched fault if its cause still shows while the bridge sleeps, when [`check`](Self::check) does not judge it. A low
    /// supply counts after `supply-low` alone: with the motor's supply off, other faults can be cleared.
    #[inline(always)]
    pub fn lasting(&self, latched: Option<Fault>, inputs: &Inputs, supply_v: f32) -> Option<Fault> {
        let lasts = match latched {
            Some(Fault::SupplyLow) => supply_v < self.supply_min_v,
            Some(Fault::Bridge) => inputs.bridge_fault,
            _ => false,
        };
        if lasts { latched } else { None }
    }

    /// Driven with a current that the sense must show: reference and voltage point the same way.
    fn must_flow(observed: &PeriodState) -> bool {
        observed.reference_a.abs() > EXPECTED_A && observed.reference_a * observed.applied_v > 0.0
    }

    /// A reading that does not move, or that shows nothing of a current that must flow.
    fn sense_stuck(&mut self, code: AdcCode, observed: &PeriodState) -> Option<Fault> {
        self.same_readings = if code == self.last_code {
            self.same_readings.saturating_add(1)
        } else {
            0
        };
        self.last_code = code;
        let turning = observed.speed.abs() > TURNING && Self::must_flow(observed);
        let same = self.same_readings > SAME_READINGS && turning && code.0 != 0;
        let nothing = observed.reading_a < NOTHING_A;
        let missing = self
            .nothing
            .update(nothing && Self::must_flow(observed), CONTRADICTION_CHECKS);
        // The loops work round a dead sense: the reference itself may come to ask for nothing.
        let driven = observed.applied_v * observed.speed > 0.0 && observed.speed.abs() > TURNING;
        let idle = self.idle_reading.update(nothing && driven, NOTHING_CHECKS);
        (missing || idle || same).then_some(Fault::SenseStuck)
    }

    /// The motor's voltage balance, V = R i + k_e w, against the encoder's speed w.
    fn contradiction(&mut self, observed: &PeriodState) -> Option<Fault> {
        // A sense that shows nothing is a matter of its own; so is a current against the voltage, which it cannot show.
        let tells = Self::must_flow(observed) && observed.reading_a >= NOTHING_A;
        let resistive_v = self.resistance_ohm * observed.reading_a;
        let emf_v = self.emf_v_per_speed * observed.speed;
        let signed_resistive_v = if observed.applied_v < 0.0 {
            -resistive_v
        } else {
            resistive_v
        };
        let excess_v = observed.applied_v - signed_resistive_v - emf_v;
        let slack_v = SLACK_V + SLACK_RESISTIVE * resistive_v + SLACK_EMF * emf_v.abs();
        let contradicts = tells && excess_v.abs() > slack_v;
        if !self.contradiction.update(contradicts, CONTRADICTION_CHECKS) {
            return None;
        }
        // The motor's own EMF, and which way the encoder counts.
        let against =
            (excess_v + emf_v) * observed.speed < 0.0 && observed.speed.abs() > 0.1 * TURNING;
        Some(if against {
            Fault::EncoderReversed
        } else {
            Fault::EncoderStuck
        })
    }

    /// Whether the reading at rest is no offset.
    fn offset_is_wrong(&mut self, observed: &PeriodState) -> bool {
        let at_rest = observed.applied_v == 0.0 && observed.speed.abs() < 0.1 * TURNING;
        self.rest = if at_rest {
            self.rest.saturating_add(1)
        } else {
            0
        };
        let wrong = self.rest > REST_CHECKS && observed.reading_a.abs() > OFFSET_LIMIT_A;
        self.offset.update(wrong, REST_CHECKS)
    }
}

#[cfg(test)]
mod tests;
