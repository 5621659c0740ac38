//! Periods of the PWM, divided at their edges, and the decays of each part. Recent ones are cached: a current loop's duty wanders among
//! some timer counts, and each period has twelve exponentials.

use super::samples::{INSTANTS, Samples};
use super::{Circuit, Path, RESOLUTION_S, Winding};
use std::sync::{Arc, OnceLock};

/// Number of slots.
const SLOTS: usize = 64;
/// Neighbouring duties of a timer that counts to some hundreds have slots of their own.
const SLOTS_PER_DUTY: f64 = 1024.0;

/// A part of the period between two edges.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    pub path: Path,
    pub start_s: f64,
    pub end_s: f64,
    /// What is left after it of a deviation of the current and of the pin's voltage.
    pub decay: Decay,
}

/// What is left of deviations after a time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Decay {
    pub current: f64,
    pub pin: f64,
}

impl Decay {
    pub fn over(length_s: f64, circuit: &Circuit) -> Self {
        if length_s == 0.0 {
            return Self {
                current: 1.0,
                pin: 1.0,
            };
        }
        Self {
            current: left_after(length_s * circuit.constants.per_time_constant),
            pin: left_after(length_s * circuit.constants.per_lag),
        }
    }
}

/// exp(-x) for x of zero or more. Between two samples of a converter x is small, and its series takes half the time: the first term
/// left out is 3e-17 there.
pub(super) fn left_after(x: f64) -> f64 {
    if x >= 0.1 {
        return (-x).exp();
    }
    let mut series = 1.0;
    for n in (1..10).rev() {
        series = 1.0 - x * SHARES[n] * series;
    }
    series
}

/// 1/n, at n.
const SHARES: [f64; 10] = {
    let mut shares = [0.0; 10];
    let mut n = 1;
    while n < 10 {
        shares[n] = 1.0 / n as f64;
        n += 1;
    }
    shares
};

/// A period of the PWM from the middle of the on-time, where the timer counts zero.
#[derive(Clone, Debug)]
pub(crate) struct Period {
    pub(super) parts: [Part; 6],
    /// What the parts' decays were computed for.
    key: [f64; 5],
    /// For the instants in each half that were asked for first.
    samples: [OnceLock<Option<Samples>>; 2],
}

impl Period {
    /// Each switch closes a dead time after the other was told to open; one whose turn is shorter never closes.
    pub fn new(duty: f64, period_s: f64, dead_s: f64, circuit: &Circuit) -> Self {
        let half_on = 0.5 * duty * period_s;
        let (off_at, on_at) = (half_on, period_s - half_on);
        let ends = if duty >= 1.0 {
            [(Path::Drive, period_s); 6]
        } else if duty <= 0.0 {
            [(Path::Brake, period_s); 6]
        } else {
            [
                (Path::Dead, (dead_s - half_on).clamp(0.0, half_on)),
                (Path::Drive, half_on),
                (Path::Dead, (off_at + dead_s).min(on_at)),
                (Path::Brake, on_at),
                (Path::Dead, (on_at + dead_s).min(period_s)),
                (Path::Drive, period_s),
            ]
        };
        let mut start_s = 0.0;
        let parts = ends.map(|(path, end_s)| {
            let part = Part {
                path,
                start_s,
                end_s,
                decay: Decay::over(end_s - start_s, circuit),
            };
            start_s = end_s;
            part
        });
        Self {
            parts,
            key: Self::key(duty, period_s, dead_s, circuit),
            samples: Default::default(),
        }
    }

    /// Finds the pin at equally distant instants from the middle of the on-time, without a step from one to the next; `false` where
    /// that is not possible.
    pub fn try_fill(
        &self,
        circuit: &Circuit,
        winding: &Winding,
        at_s: [f64; 2],
        volts: &mut [f64; INSTANTS],
    ) -> bool {
        self.samples[usize::from(self.is_late(at_s[0]))]
            .get_or_init(|| Samples::new(circuit, self, at_s))
            .as_ref()
            .is_some_and(|samples| samples.is_at(at_s) && samples.try_fill(circuit, winding, volts))
    }

    /// Whether a time is beyond the first half.
    pub fn is_late(&self, at_s: f64) -> bool {
        let [.., last] = &self.parts;
        at_s > 0.5 * last.end_s
    }

    fn duty(&self) -> f64 {
        self.key[0]
    }

    fn key(duty: f64, period_s: f64, dead_s: f64, circuit: &Circuit) -> [f64; 5] {
        let constants = &circuit.constants;
        [
            duty,
            period_s,
            dead_s,
            constants.time_constant_s,
            constants.lag_s,
        ]
    }

    /// How many whole periods a time is; `None` where there are fewer than two, or something is left.
    pub(super) fn whole_in(&self, dt: f64) -> Option<u32> {
        let [.., last] = &self.parts;
        let count = (dt / last.end_s).round();
        let whole = (2.0..1e6).contains(&count) && (dt - count * last.end_s).abs() < RESOLUTION_S;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked"
        )]
        whole.then_some(count as u32)
    }

    /// Whether [`Period::new`] would make the same again.
    fn is_of(&self, duty: f64, period_s: f64, dead_s: f64, circuit: &Circuit) -> bool {
        self.key == Self::key(duty, period_s, dead_s, circuit)
    }
}

/// Recent periods, each in a slot that its duty gives.
#[derive(Clone, Debug)]
pub(crate) struct Periods(Box<[Option<Arc<Period>>; SLOTS]>);

impl Default for Periods {
    fn default() -> Self {
        Self(Box::new([const { None }; SLOTS]))
    }
}

impl Periods {
    fn slot(duty: f64) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a duty is 0 to 1"
        )]
        let slot = (duty * SLOTS_PER_DUTY) as usize;
        slot % SLOTS
    }

    /// What [`Period::new`] makes.
    pub fn of(&self, duty: f64, period_s: f64, dead_s: f64, circuit: &Circuit) -> Arc<Period> {
        match &self.0[Self::slot(duty)] {
            Some(period) if period.is_of(duty, period_s, dead_s, circuit) => Arc::clone(period),
            _ => Arc::new(Period::new(duty, period_s, dead_s, circuit)),
        }
    }

    /// Keeps one for the next time.
    pub fn keep(&mut self, period: &Arc<Period>) {
        self.0[Self::slot(period.duty())] = Some(Arc::clone(period));
    }
}
