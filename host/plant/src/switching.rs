//! The winding between the edges of the PWM, and what the current sense makes of it at the converter's pin.
//!
//! Between two edges voltage and resistance are constant, so the current is an exponential and everything that follows from it
//! is a formula: no small steps. EN switches one half bridge; the low side of the other conducts all the time. Directions are those
//! of the drive: positive flows along it.

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
    /// Time constant of mirror and pin together, second, positive.
    pub lag_s: f64,
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

/// What stays the same over some periods of the PWM.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Circuit {
    /// Direction of the drive, 1 where it closes, otherwise -1.
    pub sign: f64,
    /// Supply, volt.
    pub supply_v: f64,
    /// Back-EMF, volt, closing positive.
    pub back_emf_v: f64,
    /// Winding and two switches, ohm.
    pub resistance_ohm: f64,
    /// L/R, second.
    pub time_constant_s: f64,
    /// Drop of a body diode, volt.
    pub diode_v: f64,
    /// Current at which the bridge chops, ampere.
    pub chop_a: f64,
    /// The sense.
    pub sense: Sense,
}

impl Circuit {
    /// Time constant of the sense. Equal ones have a formula of their own; parted by a millionth they need none.
    fn lag_s(&self) -> f64 {
        let (tau, lag_s) = (self.time_constant_s, self.sense.lag_s);
        if (tau - lag_s).abs() < 1e-6 * tau {
            lag_s + 1e-6 * tau
        } else {
            lag_s
        }
    }
}

/// A part of the period between two edges.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    path: Path,
    start_s: f64,
    end_s: f64,
    /// What is left after it of a deviation of the current and of the pin's voltage.
    decay: Decay,
}

/// What is left of deviations after a time.
#[derive(Clone, Copy, Debug, Default)]
struct Decay {
    current: f64,
    pin: f64,
}

impl Decay {
    fn over(length_s: f64, circuit: &Circuit) -> Self {
        if length_s == 0.0 {
            return Self {
                current: 1.0,
                pin: 1.0,
            };
        }
        Self {
            current: (-length_s / circuit.time_constant_s).exp(),
            pin: (-length_s / circuit.lag_s()).exp(),
        }
    }
}

/// A period of the PWM from the middle of the on-time, where the timer counts zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Period {
    parts: [Part; 6],
    /// What the parts' decays were computed for.
    key: [f64; 5],
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
        }
    }

    fn key(duty: f64, period_s: f64, dead_s: f64, circuit: &Circuit) -> [f64; 5] {
        let (current_s, pin_s) = (circuit.time_constant_s, circuit.sense.lag_s);
        [duty, period_s, dead_s, current_s, pin_s]
    }

    /// Whether [`Period::new`] would make the same again.
    pub fn is_of(&self, duty: f64, period_s: f64, dead_s: f64, circuit: &Circuit) -> bool {
        self.key == Self::key(duty, period_s, dead_s, circuit)
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
        let mut totals = Totals::default();
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
                self.pass(circuit, part.path, length_s, decay, &mut totals);
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
        totals
    }

    fn decay(&mut self, length_s: f64, circuit: &Circuit) -> Decay {
        let key = [length_s, circuit.time_constant_s, circuit.sense.lag_s];
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
        totals: &mut Totals,
    ) {
        let Circuit {
            supply_v, diode_v, ..
        } = *circuit;
        let emf_v = circuit.sign * circuit.back_emf_v;
        let start_a = circuit.sign * self.current_a;
        let (low_v, high_v) = (-diode_v, supply_v + diode_v);
        let voltage_v = match path {
            Path::Drive => supply_v,
            Path::Brake => 0.0,
            Path::Dead if start_a > 0.0 || (start_a == 0.0 && emf_v < low_v) => low_v,
            Path::Dead if start_a < 0.0 || (start_a == 0.0 && emf_v > high_v) => high_v,
            // Neither diode conducts.
            Path::Dead => emf_v,
        };
        let target_a = (voltage_v - emf_v) / circuit.resistance_ohm;
        let end_a = target_a + (start_a - target_a) * decay.current;
        if path == Path::Dead && start_a * end_a < 0.0 {
            // The diode stops conducting at zero: from there the other one does, or none.
            let first_s = circuit.time_constant_s * ((start_a - target_a) / -target_a).ln();
            let first_s = first_s.clamp(0.0, length_s);
            let first = Decay::over(first_s, circuit);
            self.follow(circuit, path, target_a, first_s, first, totals);
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
        totals: &mut Totals,
    ) {
        let tau = circuit.time_constant_s;
        let start_a = circuit.sign * self.current_a;
        let apart_a = start_a - target_a;
        let left_a = apart_a * decay.current;
        let charge = target_a * length_s + (apart_a - left_a) * tau;
        totals.charge += circuit.sign * charge;
        totals.square += target_a * (target_a * length_s + 2.0 * (apart_a - left_a) * tau)
            + 0.5 * tau * (apart_a * apart_a - left_a * left_a);
        // Through the high side's switch, or back through its diode.
        if path == Path::Drive || (path == Path::Dead && start_a < 0.0) {
            totals.drawn += charge;
        }
        self.sense(circuit, path, target_a, length_s, decay);
        let end_a = target_a + left_a;
        totals.chopped |= end_a.abs() > circuit.chop_a;
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
                let tau = circuit.time_constant_s;
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
        let tau = circuit.time_constant_s;
        let resting_v = slope * target_a + offset_v;
        let moving_v = slope * (start_a - target_a) * tau / (tau - circuit.lag_s());
        self.pin_v =
            resting_v + moving_v * decay.current + (self.pin_v - resting_v - moving_v) * decay.pin;
    }
}

#[cfg(test)]
mod tests;
