//! The winding between the edges of the PWM, and what the current sense makes of it at the converter's pin.
//!
//! Between two edges voltage and resistance are constant, so the current is an exponential and everything that follows from it
//! is a formula: no small steps. EN switches one half bridge; the low side of the other conducts all the time. Directions are those
//! of the drive: positive flows along it.

mod periods;
mod samples;
mod whole;

use periods::Decay;
pub(crate) use periods::{Period, Periods};
pub(crate) use samples::INSTANTS;

/// Shorter times are none, second.
const RESOLUTION_S: f64 = 1e-13;

/// What EN has connected the winding to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Path {
    /// The supply.
    Drive,
    /// Neither switch of the half bridge conducts: a diode does, whichever way the current flows.
    Dead,
    /// Itself, through both low sides.
    #[default]
    Brake,
}

/// What the sense shows of the current.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sense {
    /// It has the current's sign (closing positive) and no dead zone: a shunt in the motor's lead.
    pub signed: bool,
    /// Volt per ampere at the pin.
    pub volt_per_a: f64,
    /// Volt at no current. A mirror gives no negative one: its output then has a dead zone.
    pub offset_v: f64,
}

impl Sense {
    /// Volt at the pin in the end, as slope and intercept over the current along the drive, for currents about `current_a`.
    fn law(&self, path: Path, sign: f64, current_a: f64) -> (f64, f64) {
        if self.signed {
            return (sign * self.volt_per_a, self.offset_v);
        }
        // Each low side shows what flows in it from drain to source (SLVSDS7B 7.3.3.1). In brake that is one of the two whichever
        // way the current flows; otherwise only the one at the motor's other lead is on.
        let slope = match path {
            Path::Brake => self.volt_per_a * current_a.signum(),
            _ if current_a > 0.0 => self.volt_per_a,
            _ => 0.0,
        };
        if slope * current_a + self.offset_v > 0.0 {
            (slope, self.offset_v)
        } else {
            (0.0, 0.0)
        }
    }

    /// Highest current along the drive at which the law changes, or none, ampere.
    fn highest_bend_a(&self) -> f64 {
        let finite = self.bends().into_iter().filter(|a| a.is_finite());
        finite.fold(0.0, f64::max)
    }

    /// Currents along the drive at which the law changes.
    fn bends(&self) -> [f64; 2] {
        if self.signed {
            [f64::INFINITY; 2]
        } else if self.offset_v < 0.0 {
            let edge_a = -self.offset_v / self.volt_per_a;
            [-edge_a, edge_a]
        } else {
            [0.0, f64::INFINITY]
        }
    }
}

/// Resistance and time constants, with the quotients that every part of a period needs: they are divided once, because they change
/// with the temperature alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Constants {
    /// Winding, choke and two switches, ohm.
    pub resistance_ohm: f64,
    /// L/R, second.
    pub time_constant_s: f64,
    /// Time constant of mirror and pin together, second.
    lag_s: f64,
    per_ohm: f64,
    per_time_constant: f64,
    per_lag: f64,
    /// Factor on what a current that decays with L/R shows at the pin, because the pin lags: tau / (tau - lag).
    moving: f64,
}

impl Constants {
    /// Resistance, L/R, and the time constant of mirror and pin together, all positive. Equal time constants have a formula of their
    /// own; parted by a millionth they need none.
    pub fn new(resistance_ohm: f64, time_constant_s: f64, mut lag_s: f64) -> Self {
        if (time_constant_s - lag_s).abs() < 1e-6 * time_constant_s {
            lag_s += 1e-6 * time_constant_s;
        }
        Self {
            resistance_ohm,
            time_constant_s,
            lag_s,
            per_ohm: 1.0 / resistance_ohm,
            per_time_constant: 1.0 / time_constant_s,
            per_lag: 1.0 / lag_s,
            moving: time_constant_s / (time_constant_s - lag_s),
        }
    }
}

/// What stays the same over some periods of the PWM.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Circuit {
    /// Direction of the drive, 1 where it closes, otherwise -1.
    pub sign: f64,
    /// Supply, volt.
    pub supply_v: f64,
    /// Back-EMF, volt, closing positive.
    pub back_emf_v: f64,
    /// Resistance and time constants.
    pub constants: Constants,
    /// Drop of a body diode, volt.
    pub diode_v: f64,
    /// Current at which the bridge chops, ampere.
    pub chop_a: f64,
    /// The sense.
    pub sense: Sense,
}

impl Circuit {
    /// Current along the drive that a path would settle at, ampere; the sign of `start_a` decides which diode conducts in the dead time.
    fn target_a(&self, path: Path, start_a: f64) -> f64 {
        let emf_v = self.sign * self.back_emf_v;
        let (low_v, high_v) = (-self.diode_v, self.supply_v + self.diode_v);
        let voltage_v = match path {
            Path::Drive => self.supply_v,
            Path::Brake => 0.0,
            Path::Dead if start_a > 0.0 || (start_a == 0.0 && emf_v < low_v) => low_v,
            Path::Dead if start_a < 0.0 || (start_a == 0.0 && emf_v > high_v) => high_v,
            // Neither diode conducts.
            Path::Dead => emf_v,
        };
        (voltage_v - emf_v) * self.constants.per_ohm
    }
}

/// Integrals over a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Totals {
    /// Of the current, ampere second, closing positive.
    pub charge: f64,
    /// Of the current drawn from the supply.
    pub drawn: f64,
    /// Of the current's square, ampere squared second.
    pub square: f64,
    /// The bridge chopped.
    pub chopped: bool,
}

impl Totals {
    /// Adds a current along the drive that goes from `start_a` to `end_a` towards a target.
    fn add(
        &mut self,
        circuit: &Circuit,
        path: Path,
        target_a: f64,
        length_s: f64,
        [start_a, end_a]: [f64; 2],
    ) {
        let tau = circuit.constants.time_constant_s;
        let (apart_a, left_a) = (start_a - target_a, end_a - target_a);
        let charge = target_a * length_s + (apart_a - left_a) * tau;
        self.charge += circuit.sign * charge;
        self.square += target_a * (target_a * length_s + 2.0 * (apart_a - left_a) * tau)
            + 0.5 * tau * (apart_a * apart_a - left_a * left_a);
        // Through the high side's switch, or back through its diode.
        if path == Path::Drive || (path == Path::Dead && start_a < 0.0) {
            self.drawn += charge;
        }
        self.chopped |= end_a.abs() > circuit.chop_a;
    }
}

/// State of winding and sense.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Winding {
    /// Current, ampere, closing positive.
    pub current_a: f64,
    /// Voltage of the sense at the converter's pin.
    pub pin_v: f64,
    /// Time since the timer counted zero, second.
    pub phase_s: f64,
    /// A length that is no whole part of a period, and its decay: samples of a converter follow at equal distances.
    last: ([f64; 3], Decay),
}

impl Winding {
    /// Lets time pass while the bridge does nothing.
    pub fn idle(&mut self, period_s: f64, dt: f64) {
        (self.current_a, self.pin_v) = (0.0, 0.0);
        self.phase_s = (self.phase_s + dt) % period_s;
        if period_s - self.phase_s < RESOLUTION_S {
            self.phase_s = 0.0;
        }
    }

    /// Lets time pass with the bridge on.
    pub fn advance(&mut self, circuit: &Circuit, period: &Period, dt: f64) -> Totals {
        let whole = period.whole_in(dt).filter(|_| self.phase_s == 0.0);
        whole
            .and_then(|count| self.whole(circuit, period, count))
            .unwrap_or_else(|| {
                let mut totals = Totals::default();
                self.pass_parts(circuit, period, dt, Some(&mut totals));
                totals
            })
    }

    /// The same where nobody asks for the integrals.
    pub fn wait(&mut self, circuit: &Circuit, period: &Period, dt: f64) {
        self.pass_parts(circuit, period, dt, None);
    }

    fn pass_parts(
        &mut self,
        circuit: &Circuit,
        period: &Period,
        dt: f64,
        mut totals: Option<&mut Totals>,
    ) {
        let mut left_s = dt;
        while left_s > RESOLUTION_S {
            for part in &period.parts {
                let rest_s = part.end_s - self.phase_s;
                if rest_s <= RESOLUTION_S {
                    continue;
                }
                if left_s <= RESOLUTION_S {
                    break;
                }
                let ends = left_s + RESOLUTION_S >= rest_s;
                let length_s = if ends { rest_s } else { left_s };
                let decay = if ends && self.phase_s == part.start_s {
                    part.decay
                } else {
                    self.decay(length_s, circuit)
                };
                self.pass(circuit, part.path, length_s, decay, totals.as_deref_mut());
                self.phase_s = if ends {
                    part.end_s
                } else {
                    self.phase_s + length_s
                };
                left_s -= length_s;
            }
            let [.., last] = &period.parts;
            if last.end_s - self.phase_s <= RESOLUTION_S {
                self.phase_s = 0.0;
            }
        }
    }

    fn decay(&mut self, length_s: f64, circuit: &Circuit) -> Decay {
        let Constants {
            time_constant_s,
            lag_s,
            ..
        } = circuit.constants;
        let key = [length_s, time_constant_s, lag_s];
        if self.last.0 != key {
            self.last = (key, Decay::over(length_s, circuit));
        }
        self.last.1
    }

    /// A part of the period, or some of it.
    fn pass(
        &mut self,
        circuit: &Circuit,
        path: Path,
        length_s: f64,
        decay: Decay,
        mut totals: Option<&mut Totals>,
    ) {
        let start_a = circuit.sign * self.current_a;
        let target_a = circuit.target_a(path, start_a);
        let end_a = target_a + (start_a - target_a) * decay.current;
        if path == Path::Dead && start_a * end_a < 0.0 {
            // The diode stops conducting at zero: from there the other one does, or none.
            let first_s =
                circuit.constants.time_constant_s * ((start_a - target_a) / -target_a).ln();
            let first_s = first_s.clamp(0.0, length_s);
            let first = Decay::over(first_s, circuit);
            self.follow(
                circuit,
                path,
                target_a,
                first_s,
                first,
                totals.as_deref_mut(),
            );
            self.current_a = 0.0;
            let rest_s = length_s - first_s;
            let rest = Decay::over(rest_s, circuit);
            self.pass(circuit, path, rest_s, rest, totals);
        } else {
            self.follow(circuit, path, target_a, length_s, decay, totals);
        }
    }

    /// The current goes exponentially towards a target.
    fn follow(
        &mut self,
        circuit: &Circuit,
        path: Path,
        target_a: f64,
        length_s: f64,
        decay: Decay,
        totals: Option<&mut Totals>,
    ) {
        let start_a = circuit.sign * self.current_a;
        let end_a = target_a + (start_a - target_a) * decay.current;
        if let Some(totals) = totals {
            totals.add(circuit, path, target_a, length_s, [start_a, end_a]);
        }
        self.sense(circuit, path, target_a, length_s, decay);
        self.current_a = circuit.sign * end_a.clamp(-circuit.chop_a, circuit.chop_a);
    }

    /// The pin meanwhile, in as many pieces as the sense's law has.
    fn sense(&mut self, circuit: &Circuit, path: Path, target_a: f64, length_s: f64, decay: Decay) {
        let mut start_a = circuit.sign * self.current_a;
        let end_a = target_a + (start_a - target_a) * decay.current;
        let mut bends = circuit.sense.bends();
        if end_a < start_a {
            bends.reverse();
        }
        let mut left_s = length_s;
        for bend_a in bends {
            if (bend_a - start_a) * (bend_a - end_a) < 0.0 {
                let tau = circuit.constants.time_constant_s;
                let length_s = tau * ((start_a - target_a) / (bend_a - target_a)).ln();
                let decay = Decay::over(length_s, circuit);
                self.settle(circuit, path, target_a, [start_a, bend_a], decay);
                start_a = bend_a;
                left_s -= length_s;
            }
        }
        let decay = if left_s < length_s {
            Decay::over(left_s.max(0.0), circuit)
        } else {
            decay
        };
        self.settle(circuit, path, target_a, [start_a, end_a], decay);
    }

    /// The pin while the sense's law is one straight line.
    fn settle(
        &mut self,
        circuit: &Circuit,
        path: Path,
        target_a: f64,
        [start_a, end_a]: [f64; 2],
        decay: Decay,
    ) {
        let sense = &circuit.sense;
        let (slope, offset_v) = sense.law(path, circuit.sign, 0.5 * (start_a + end_a));
        let resting_v = slope * target_a + offset_v;
        let moving_v = slope * (start_a - target_a) * circuit.constants.moving;
        self.pin_v =
            resting_v + moving_v * decay.current + (self.pin_v - resting_v - moving_v) * decay.pin;
    }
}

#[cfg(test)]
mod tests;
