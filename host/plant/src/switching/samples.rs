//! Computes the sense's pin at all instants of a converter at once.
//!
//! Valid while the current keeps its direction, stays out of the sense's dead zone and below the limit at which the bridge chops. Current
//! and pin are then linear in what the period begins with and in the voltages about the winding, with factors that depend on the duty
//! and on the instants alone.

use super::periods::{Decay, Part};
use super::{Circuit, Path, Period, Winding};

/// Number of instants: the conversions of half a period.
pub(crate) const INSTANTS: usize = 8;

/// Factors of a quantity that is linear in four currents: the one at the beginning of the period, and the steady ones that back-EMF,
/// supply and diode would drive.
type Factors = [f64; 4];

/// Factors of the pin at equally distant instants, and of the current at the edges.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    /// First instant and distance, second from the middle of the on-time.
    at_s: [f64; 2],
    /// Share of the pin's voltage at the beginning that is left at each instant.
    left: [f64; INSTANTS],
    /// The pin for a sense of 1 V/A, by factor.
    pin: [[f64; INSTANTS]; 4],
    edges: [Factors; 6],
}

/// Current and pin on the way through a period.
#[derive(Clone, Copy)]
struct Way {
    current: Factors,
    pin: Factors,
    left: f64,
}

impl Way {
    const START: Self = Self {
        current: [1.0, 0.0, 0.0, 0.0],
        pin: [0.0; 4],
        left: 1.0,
    };

    fn pass(&mut self, path: Path, decay: Decay, moving: f64) {
        let target = match path {
            Path::Drive => [0.0, 1.0, 1.0, 0.0],
            Path::Dead => [0.0, 1.0, 0.0, 1.0],
            Path::Brake => [0.0, 1.0, 0.0, 0.0],
        };
        for ((current, pin), target) in self.current.iter_mut().zip(&mut self.pin).zip(target) {
            let apart = *current - target;
            let bent = moving * apart;
            *pin = target + bent * decay.current + (*pin - target - bent) * decay.pin;
            *current = target + apart * decay.current;
        }
        self.left *= decay.pin;
    }
}

impl Samples {
    /// The factors for instants within the period; `None` where one lies beyond it.
    pub fn new(circuit: &Circuit, period: &Period, [first_s, every_s]: [f64; 2]) -> Option<Self> {
        let [.., end] = &period.parts;
        if first_s < 0.0 || first_s + every_s * (INSTANTS - 1) as f64 > end.end_s {
            return None;
        }
        let moving = circuit.constants.moving;
        let mut samples = Self {
            at_s: [first_s, every_s],
            left: [0.0; INSTANTS],
            pin: [[0.0; INSTANTS]; 4],
            edges: [[0.0; 4]; 6],
        };
        let mut way = Way::START;
        let mut next = 0;
        for (part, edge) in period.parts.iter().zip(&mut samples.edges) {
            let &Part {
                path,
                start_s,
                end_s,
                decay,
            } = part;
            while next < INSTANTS {
                let at_s = first_s + every_s * next as f64;
                if at_s > end_s {
                    break;
                }
                let mut there = way;
                there.pass(path, Decay::over(at_s - start_s, circuit), moving);
                samples.left[next] = there.left;
                for (row, pin) in samples.pin.iter_mut().zip(there.pin) {
                    row[next] = pin;
                }
                next += 1;
            }
            way.pass(path, decay, moving);
            *edge = way.current;
        }
        Some(samples)
    }

    /// Whether these are the instants.
    pub fn is_at(&self, at_s: [f64; 2]) -> bool {
        self.at_s == at_s
    }

    /// Finds the pin at the instants, from a winding in the middle of the on-time; `false`, and nothing is changed, where the current
    /// comes to zero, to a bend of the sense or to the bridge's limit.
    pub fn try_fill(
        &self,
        circuit: &Circuit,
        winding: &Winding,
        volts: &mut [f64; INSTANTS],
    ) -> bool {
        let start_a = circuit.sign * winding.current_a;
        let per_ohm = circuit.constants.per_ohm;
        let causes = [
            start_a,
            -circuit.sign * circuit.back_emf_v * per_ohm,
            circuit.supply_v * per_ohm,
            -circuit.diode_v * per_ohm,
        ];
        let (mut least_a, mut most_a) = (start_a, start_a);
        for edge in &self.edges {
            let edge_a: f64 = edge.iter().zip(causes).map(|(f, a)| f * a).sum();
            least_a = least_a.min(edge_a);
            most_a = most_a.max(edge_a);
        }
        let low_a = circuit.sense.highest_bend_a();
        if !(winding.phase_s == 0.0 && least_a > low_a && most_a < circuit.chop_a) {
            return false;
        }
        let (slope, offset_v) = circuit.sense.law(Path::Drive, circuit.sign, start_a);
        let shown = causes.map(|a| slope * a);
        let apart_v = winding.pin_v - offset_v;
        for (n, volt) in volts.iter_mut().enumerate() {
            let [began, emf, supply, diode] = &self.pin;
            *volt = offset_v
                + self.left[n] * apart_v
                + (began[n] * shown[0] + emf[n] * shown[1])
                + (supply[n] * shown[2] + diode[n] * shown[3]);
        }
        true
    }
}
