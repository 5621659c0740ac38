//! Incremental encoder with its wires, and a quadrature counter at their end.

use crate::parameters::Encoder;
use crate::wander::Wander;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

/// Fault of the encoder's wires.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncoderFault {
    /// Phase A stays low.
    pub a_cut: bool,
    /// Phase B stays low.
    pub b_cut: bool,
    /// A and B are exchanged.
    pub swapped: bool,
    /// Rate of false edges on both phases, per second.
    pub storm_edges_per_s: f64,
}

impl EncoderFault {
    fn any(&self) -> bool {
        *self != Self::default()
    }
}

/// Position of a pair of levels in the cycle 00, 10, 11, 01 that closing makes.
fn quarter((a, b): (bool, bool)) -> i64 {
    match (a, b) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    }
}

fn levels(count: i64) -> (bool, bool) {
    let quarter = count.rem_euclid(4);
    (quarter == 1 || quarter == 2, quarter >= 2)
}

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct QuadratureEncoder {
    counts_per_rad: f64,
    periodic: f64,
    phase: f64,
    /// Non-periodic error, counts over motor turns.
    random: Wander,
    rotor: f64,
    /// Edges of the true disc.
    disc: i64,
    /// Count of a counter on the wires.
    pub count: i64,
    noise: (bool, bool),
    wires: (bool, bool),
}

impl QuadratureEncoder {
    pub fn new(parameters: &Encoder, random: &mut Pcg64Mcg) -> Self {
        let mut encoder = Self {
            counts_per_rad: parameters.counts_per_rev / TAU,
            periodic: parameters.periodic_error_counts,
            phase: parameters.periodic_phase_deg.to_radians(),
            random: Wander::new(
                parameters.random_error_counts,
                parameters.random_error_revs,
                random,
            ),
            rotor: 0.0,
            disc: 0,
            count: 0,
            noise: (false, false),
            wires: (false, false),
        };
        encoder.disc = encoder.edge(0.0);
        encoder.wires = levels(encoder.disc);
        encoder
    }

    #[expect(clippy::cast_possible_truncation, reason = "a count of edges")]
    fn edge(&self, rotor: f64) -> i64 {
        let edges = rotor * self.counts_per_rad
            + self.periodic * (rotor - self.phase).sin()
            + self.random.value();
        // The floor, where a processor may have no instruction for it.
        let whole = edges as i64;
        whole - i64::from(whole as f64 > edges)
    }

    /// Levels on the wires.
    pub fn phases(&self) -> (bool, bool) {
        self.wires
    }

    /// Advances the non-periodic error to the rotor's angle.
    pub fn wander(&mut self, rotor: f64, random: &mut Pcg64Mcg) {
        self.random.advance((rotor - self.rotor) / TAU, random);
        self.rotor = rotor;
    }

    /// Turns the disc to the rotor's angle.
    pub fn turn(&mut self, rotor: f64, fault: &EncoderFault, random: &mut Pcg64Mcg, dt: f64) {
        let disc = self.edge(rotor);
        if !fault.any() && self.noise == (false, false) {
            self.count += disc - self.disc;
            self.disc = disc;
            self.wires = levels(disc);
            return;
        }
        let way = (disc - self.disc).signum();
        while self.disc != disc {
            self.disc += way;
            self.settle(fault);
        }
        let mut expected = fault.storm_edges_per_s * dt;
        while expected > 0.0 {
            if random.random::<f64>() < expected {
                if random.random() {
                    self.noise.0 = !self.noise.0;
                } else {
                    self.noise.1 = !self.noise.1;
                }
                self.settle(fault);
            }
            expected -= 1.0;
        }
        if fault.storm_edges_per_s == 0.0 {
            self.noise = (false, false);
        }
        self.settle(fault);
    }

    /// Sets the wires' levels from disc and faults, and counts an edge if there is one.
    fn settle(&mut self, fault: &EncoderFault) {
        let (a, b) = levels(self.disc);
        let mut wires = (
            (a ^ self.noise.0) && !fault.a_cut,
            (b ^ self.noise.1) && !fault.b_cut,
        );
        if fault.swapped {
            wires = (wires.1, wires.0);
        }
        self.count += match (quarter(wires) - quarter(self.wires)).rem_euclid(4) {
            1 => 1,
            3 => -1,
            // Both levels change at once: the counter cannot determine the direction and ignores it.
            _ => 0,
        };
        self.wires = wires;
    }
}
