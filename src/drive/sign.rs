//! Sign of the motor current behind the bridge's mirror, which shows a magnitude.
//!
//! While the bridge drives, the mirror shows nothing of a current that opposes the drive; in the off-time it shows all of it
//! (docs/HARDWARE.md#bridge). The mean over a period is then `|i|` times the off-time's share, and the two halves of the period differ:
//! the pin's capacitor delays the off-time's pulse by a quarter of a period, from the middle of the period into its second half. A
//! current along the drive is shown all the time, and its ripple, delayed by another quarter, is the same in both halves. So the second
//! half's excess over the first tells the sign, without a sample that has to fit into the on-time.
//!
//! Part of the control interrupt: see [`controller`](super::controller) on what may not be called here.

use super::average::PERIODS_PER_SAMPLE;
use super::convert::Scale;
use super::io::DEAD_SHARE;
use crate::numeric::Bounded;

/// Low-pass of the excess' zero and noise, while the bridge brakes: 64 samples.
const REST_GAIN: f32 = 1.0 / 64.0;
/// Mean magnitude of the noise of a sample's excess before it is known, ampere: that of simulated sums, whose mean has 0.5 mA a period.
const NOISE_A: f32 = 0.18e-3;
/// Least excess, ampere, that shows an opposing current where the reference asks for one: what a chip has besides noise is not known.
const LEAST_A: f32 = 0.45e-3;
/// The same as a multiple of the noise: two deviations.
const PER_NOISE: f32 = 2.5;
/// Where the reference asks for a current along the drive it takes so many times as much: six deviations.
const UNEXPECTED: f32 = 3.0;
/// What is added, as a share of the reading: the converter's own capacitor, charged by the other channel, gives less of an
/// excess the more the pin carries.
const SHARE: f32 = 0.02;
/// Least share of the off-time that a reading is divided by.
const LEAST_OFF: f32 = 0.1;

/// What the sense's reading is of the current along the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Current along the drive, as a multiple of the reading.
    pub gain: f32,
    /// It opposes the drive.
    pub opposes: bool,
}

impl Flow {
    /// Along the drive.
    pub const ALONG: Self = Self {
        gain: 1.0,
        opposes: false,
    };

    /// What the sense shows while nothing drives: in brake the motor's own voltage drives a current against its motion, and all of it
    /// is shown; of a bridge that sleeps it shows none. `speed` is closing positive, in any unit.
    #[inline(always)]
    pub fn braking(awake: bool, speed: f32) -> Self {
        let gain = match (awake, speed > 0.0) {
            (true, true) => -1.0,
            (true, false) => 1.0,
            (false, _) => 0.0,
        };
        Self {
            gain,
            opposes: true,
        }
    }
}

/// A drive in the period in which its current is judged.
#[derive(Clone, Copy, Debug)]
pub struct Driven {
    /// Reading without its offset, ampere.
    pub reading_a: f32,
    /// Duty, 0 to 1; 0 in brake.
    pub duty: f32,
    /// The reference asks for a current that opposes the drive.
    pub reference_opposes: bool,
}

/// Excess of the second half of a period over the first, added up over a sample, and what it tells of the next.
#[derive(Clone, Debug)]
pub struct CurrentSign {
    a_per_sum: f32,
    sum: i32,
    zero_a: f32,
    noise_a: f32,
    flow: Flow,
}

impl CurrentSign {
    /// For a board with these scales.
    pub fn new(scale: &Scale) -> Self {
        Self {
            a_per_sum: scale.a_per_excess() / f32::from(PERIODS_PER_SAMPLE),
            sum: 0,
            zero_a: 0.0,
            noise_a: NOISE_A,
            flow: Flow::ALONG,
        }
    }

    /// Takes a period's excess, in codes.
    #[inline(always)]
    pub fn add(&mut self, late_excess: i16) {
        self.sum = self.sum.wrapping_add(i32::from(late_excess));
    }

    /// What the last sample told.
    #[inline(always)]
    pub fn flow(&self) -> Flow {
        self.flow
    }

    /// Judges the excess of the last [`PERIODS_PER_SAMPLE`] periods; `None` where the bridge was off.
    pub fn judge(&mut self, driven: Option<Driven>) {
        let excess_a = core::mem::take(&mut self.sum) as f32 * self.a_per_sum - self.zero_a;
        let Some(driven) = driven else {
            // No current flows any more that the next drive begins with.
            self.flow = Flow::ALONG;
            return;
        };
        if driven.duty == 0.0 {
            // Nothing switches: this is what the converter makes of a steady pin.
            self.zero_a += REST_GAIN * excess_a;
            self.noise_a += REST_GAIN * (excess_a.abs() - self.noise_a);
            return;
        }
        let mut least_a = (PER_NOISE * self.noise_a).at_least(LEAST_A);
        if !driven.reference_opposes {
            least_a *= UNEXPECTED;
        }
        self.flow = if excess_a > least_a + SHARE * driven.reading_a {
            let off = 1.0 - DEAD_SHARE - driven.duty;
            Flow {
                gain: -1.0 / off.at_least(LEAST_OFF),
                opposes: true,
            }
        } else {
            Flow::ALONG
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::config::tests::p70;

    /// After many samples of brake with one excess and one of driving with another.
    fn judged(excess_a: f32, zero_a: f32, driven: Driven) -> Flow {
        let scale = Scale::of(&p70());
        let mut sign = CurrentSign::new(&scale);
        let sample = |sign: &mut CurrentSign, a: f32, driven: Driven| {
            for _ in 0..PERIODS_PER_SAMPLE {
                sign.add((a / scale.a_per_excess()).round() as i16);
            }
            sign.judge(Some(driven));
        };
        for _ in 0..1000 {
            sample(
                &mut sign,
                zero_a,
                Driven {
                    duty: 0.0,
                    ..driven
                },
            );
        }
        sample(&mut sign, excess_a, driven);
        sign.flow()
    }

    #[test]
    fn an_excess_beyond_its_zero_is_an_opposing_current() {
        // 10 mA against a drive of 20.8 % with the choke show 7.6 mA, and 1.35 mA of excess.
        let driven = Driven {
            reading_a: 7.6e-3,
            duty: 0.208,
            reference_opposes: true,
        };
        for zero_a in [-0.6e-3, 0.0, 0.3e-3] {
            let flow = judged(zero_a + 1.35e-3, zero_a, driven);
            assert!(flow.opposes, "{flow:?}");
            assert!((flow.gain * driven.reading_a + 10e-3).abs() < 0.1e-3);
            assert_eq!(judged(zero_a, zero_a, driven), Flow::ALONG);
        }
    }

    #[test]
    fn what_is_not_asked_for_needs_more_evidence() {
        let opposes = |reference_opposes| {
            let driven = Driven {
                reading_a: 5e-3,
                duty: 0.2,
                reference_opposes,
            };
            judged(0.8e-3, 0.0, driven).opposes
        };
        assert!(opposes(true));
        assert!(!opposes(false));
    }

    #[test]
    fn a_noisy_sense_takes_more_evidence() {
        let scale = Scale::of(&p70());
        let mut sign = CurrentSign::new(&scale);
        let sample = |sign: &mut CurrentSign, a: f32, duty| {
            for _ in 0..PERIODS_PER_SAMPLE {
                sign.add((a / scale.a_per_excess()).round() as i16);
            }
            sign.judge(Some(Driven {
                reading_a: 10e-3,
                duty,
                reference_opposes: false,
            }));
        };
        for n in 0..1000 {
            sample(&mut sign, if n % 2 == 0 { 0.8e-3 } else { -0.8e-3 }, 0.0);
        }
        sample(&mut sign, 4e-3, 0.3);
        assert_eq!(sign.flow(), Flow::ALONG);
        sample(&mut sign, 7e-3, 0.3);
        assert!(sign.flow().opposes);
    }

    #[test]
    fn no_duty_and_no_excess_makes_a_current_that_is_none() {
        for excess in [i16::MIN, -1, 0, 1, i16::MAX] {
            for duty in [0.0, 0.5, 0.95, 1.0, f32::NAN] {
                let mut sign = CurrentSign::new(&Scale::of(&p70()));
                for _ in 0..100_000 {
                    sign.add(excess);
                }
                sign.judge(Some(Driven {
                    reading_a: 0.485,
                    duty,
                    reference_opposes: true,
                }));
                assert!(sign.flow().gain.abs() <= 10.0, "{sign:?}");
            }
        }
    }

    #[test]
    fn a_bridge_that_is_off_tells_nothing() {
        let mut sign = CurrentSign::new(&Scale::of(&p70()));
        sign.add(i16::MAX);
        sign.judge(Some(Driven {
            reading_a: 10e-3,
            duty: 0.3,
            reference_opposes: true,
        }));
        assert!(sign.flow().opposes);
        sign.add(i16::MAX);
        sign.judge(None);
        assert_eq!((sign.sum, sign.zero_a, sign.flow()), (0, 0.0, Flow::ALONG));
    }
}
