//! Advances several whole periods of the PWM in one step.
//!
//! Valid while the current keeps its direction, stays out of the sense's dead zone and below the limit at which the bridge chops. Each
//! part of a period is then the same exponential law whatever the current, so that current and pin at the end of a period are linear in
//! the current at its beginning, and the integrals are at most quadratic.

use super::{Circuit, Path, Period, Totals, Winding};

/// A sum of powers of the current along the drive at the beginning of a period: constant, first, second.
type Powers = [f64; 3];

/// What a period makes of the current and the pin at its beginning.
#[derive(Clone, Copy, Debug, Default)]
struct Whole {
    /// The current at its end.
    current: Powers,
    charge: Powers,
    drawn: Powers,
    square: Powers,
    /// The pin at its end, without what is left of the pin at its beginning; and what is left of that.
    pin: Powers,
    pin_left: f64,
    /// Least and largest current at the edges.
    least_a: f64,
    most_a: f64,
}

/// The sum for a current.
fn at([constant, first, second]: Powers, current_a: f64) -> f64 {
    constant + current_a * (first + current_a * second)
}

impl Whole {
    /// The period while the current flows along the drive, by the powers of the current at its beginning.
    fn new(circuit: &Circuit, period: &Period, start_a: f64) -> Self {
        let tau = circuit.constants.time_constant_s;
        let (slope, offset_v) = circuit.sense.law(Path::Drive, circuit.sign, start_a);
        let bent = slope * circuit.constants.moving;
        let mut whole = Self {
            pin_left: 1.0,
            least_a: start_a,
            most_a: start_a,
            ..Self::default()
        };
        // The current so far: constant and first power.
        let [mut constant, mut first] = [0.0, 1.0];
        for part in &period.parts {
            let length_s = part.end_s - part.start_s;
            if length_s <= 0.0 {
                continue;
            }
            let target_a = circuit.target_a(part.path, start_a);
            let apart = constant - target_a;
            let gone = 1.0 - part.decay.current;
            let charge = [target_a * length_s + apart * gone * tau, first * gone * tau];
            whole.charge[0] += charge[0];
            whole.charge[1] += charge[1];
            if part.path == Path::Drive {
                whole.drawn[0] += charge[0];
                whole.drawn[1] += charge[1];
            }
            // The square of target and what decays towards it.
            let faded = 0.5 * tau * gone * (1.0 + part.decay.current);
            let mixed = 2.0 * target_a * tau * gone;
            whole.square[0] +=
                target_a * target_a * length_s + mixed * apart + faded * apart * apart;
            whole.square[1] += first * (mixed + 2.0 * faded * apart);
            whole.square[2] += faded * first * first;
            let resting_v = slope * target_a + offset_v;
            let moving = bent * (part.decay.current - part.decay.pin);
            whole.pin[0] =
                whole.pin[0] * part.decay.pin + resting_v * (1.0 - part.decay.pin) + moving * apart;
            whole.pin[1] = whole.pin[1] * part.decay.pin + moving * first;
            whole.pin_left *= part.decay.pin;
            constant = target_a + apart * part.decay.current;
            first *= part.decay.current;
            let edge_a = constant + first * start_a;
            whole.least_a = whole.least_a.min(edge_a);
            whole.most_a = whole.most_a.max(edge_a);
        }
        whole.current = [constant, first, 0.0];
        whole
    }
}

impl Winding {
    /// Lets `count` periods pass at once from the middle of the on-time; `None`, and nothing has happened, where the current comes near
    /// to zero, to a bend of the sense or to the bridge's limit.
    pub(super) fn whole(
        &mut self,
        circuit: &Circuit,
        period: &Period,
        count: u32,
    ) -> Option<Totals> {
        let start_a = circuit.sign * self.current_a;
        if start_a <= 0.0 {
            return None;
        }
        let whole = Whole::new(circuit, period, start_a);
        // The beginnings of all periods lie between the first and where they tend to, and no edge moves by more than they do.
        let change_a = (whole.current[0] / (1.0 - whole.current[1]) - start_a).abs();
        let low_a = circuit.sense.highest_bend_a();
        if whole.least_a - change_a <= low_a || whole.most_a + change_a >= circuit.chop_a {
            return None;
        }
        let mut totals = Totals::default();
        let (mut current_a, mut pin_v) = (start_a, self.pin_v);
        for _ in 0..count {
            totals.charge += circuit.sign * at(whole.charge, current_a);
            totals.drawn += at(whole.drawn, current_a);
            totals.square += at(whole.square, current_a);
            pin_v = at(whole.pin, current_a) + whole.pin_left * pin_v;
            current_a = at(whole.current, current_a);
        }
        self.current_a = circuit.sign * current_a;
        self.pin_v = pin_v;
        Some(totals)
    }
}
