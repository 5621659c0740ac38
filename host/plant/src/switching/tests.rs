//! Against the same circuit integrated in steps of a nanosecond, switch by switch: no formula in common.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const PERIOD_S: f64 = 1e-5;
const NS: f64 = 1e-9;
/// The steps know to a nanosecond when a diode ceases to conduct: 17 uA where 12 V act.
const SLACK_A: f64 = 2e-5;

/// What both computations are told.
#[derive(Clone, Copy, Debug)]
struct Case {
    circuit: Circuit,
    /// Nanoseconds, so that edges fall between steps: half the on-time, dead time.
    half_on_ns: u32,
    dead_ns: u32,
    current_a: f64,
    pin_v: f64,
}

impl Case {
    fn duty(&self) -> f64 {
        2.0 * f64::from(self.half_on_ns) * NS / PERIOD_S
    }

    fn period(&self) -> Period {
        let dead_s = f64::from(self.dead_ns) * NS;
        Period::new(self.duty(), PERIOD_S, dead_s, &self.circuit)
    }

    fn random(random: &mut Pcg64Mcg) -> Self {
        let volt_per_a = 6.8;
        let offset_a = random.random_range(-7e-3..7e-3);
        let sense = Sense {
            signed: random.random_bool(0.2),
            volt_per_a,
            offset_v: volt_per_a * offset_a,
        };
        let lag_s = [1e-7, 0.4e-6, 6.8e-6, 20e-6][random.random_range(0..4)];
        let circuit = Circuit {
            sign: if random.random_bool(0.5) { 1.0 } else { -1.0 },
            supply_v: random.random_range(9.0..14.0),
            back_emf_v: random.random_range(-8.0..8.0),
            constants: Constants::new(
                random.random_range(28.0..45.0),
                // Without and with a choke.
                [20e-6, 70e-6][random.random_range(0..2)],
                lag_s,
            ),
            diode_v: 0.9,
            chop_a: 1.0,
            sense,
        };
        let odd = [0, 60, 5000, 4920][random.random_range(0..4)];
        let half_on_ns = if random.random_bool(0.6) {
            random.random_range(0..5000)
        } else {
            odd
        };
        let mut circuit = circuit;
        if random.random_bool(0.5) {
            // Hardly any current in the mean: it goes through zero, and stays there in a dead time.
            let mean_v = 2e-4 * f64::from(half_on_ns) * circuit.supply_v;
            circuit.back_emf_v = circuit.sign * (mean_v - random.random_range(-0.6..0.8));
        }
        Self {
            circuit,
            half_on_ns,
            dead_ns: [0, 100, 300][random.random_range(0..3)],
            current_a: random.random_range(-0.1..0.1),
            pin_v: random.random_range(0.0..1.0),
        }
    }
}

/// The bridge with its switches, in the motor's terms: lead 1 is switched by EN, lead 2 stays low.
struct Stepped {
    case: Case,
    ns: u32,
    high: bool,
    since_ns: u32,
    current_a: f64,
    pin_v: f64,
    charge: f64,
    drawn: f64,
    square: f64,
}

impl Stepped {
    fn new(case: Case) -> Self {
        Self {
            case,
            ns: 0,
            high: case.half_on_ns > 0,
            // EN rose half an on-time ago, or never changes.
            since_ns: match case.half_on_ns {
                0 | 5000 => 1_000_000,
                half_on_ns => half_on_ns,
            },
            current_a: case.current_a,
            pin_v: case.pin_v,
            charge: 0.0,
            drawn: 0.0,
            square: 0.0,
        }
    }

    fn nanosecond(&mut self) {
        let c = self.case.circuit;
        let high = self.ns < self.case.half_on_ns || self.ns >= 10_000 - self.case.half_on_ns;
        if high != self.high {
            (self.high, self.since_ns) = (high, 0);
        }
        let settled = self.since_ns >= self.case.dead_ns;
        let (upper, lower) = (high && settled, !high && settled);
        // In the direction of the drive.
        let before_a = c.sign * self.current_a;
        let emf_v = c.sign * c.back_emf_v;
        let lead_v = if upper {
            Some(c.supply_v)
        } else if lower {
            Some(0.0)
        } else if before_a > 0.0 {
            Some(-c.diode_v)
        } else if before_a < 0.0 || emf_v > c.supply_v + c.diode_v {
            Some(c.supply_v + c.diode_v)
        } else if emf_v < -c.diode_v {
            Some(-c.diode_v)
        } else {
            None
        };
        let ohm = c.constants.resistance_ohm;
        let inductance_h = ohm * c.constants.time_constant_s;
        let mut after_a = match lead_v {
            Some(lead_v) => {
                let slope = |a: f64| (lead_v - emf_v - ohm * a) / inductance_h;
                let half_a = before_a + 0.5 * NS * slope(before_a);
                before_a + NS * slope(half_a)
            }
            None => 0.0,
        };
        if !upper && !lower && before_a * after_a < 0.0 {
            after_a = 0.0;
        }
        let mean_a = 0.5 * (before_a + after_a);
        self.charge += c.sign * mean_a * NS;
        self.square += mean_a * mean_a * NS;
        if upper || (!lower && before_a < 0.0) {
            self.drawn += mean_a * NS;
        }
        // Drain to source in each low side: lead 2's always conducts, lead 1's in brake.
        let shown_a = mean_a.max(0.0) + if lower { (-mean_a).max(0.0) } else { 0.0 };
        let sense = c.sense;
        let volts = if sense.signed {
            sense.volt_per_a * c.sign * mean_a + sense.offset_v
        } else {
            (sense.volt_per_a * shown_a + sense.offset_v).max(0.0)
        };
        let slope = |v: f64| (volts - v) / c.constants.lag_s;
        let half_v = self.pin_v + 0.5 * NS * slope(self.pin_v);
        self.pin_v += NS * slope(half_v);
        self.current_a = c.sign * after_a;
        self.ns = (self.ns + 1) % 10_000;
        self.since_ns += 1;
    }
}

fn start(case: &Case) -> Winding {
    Winding {
        current_a: case.current_a,
        pin_v: case.pin_v,
        ..Winding::default()
    }
}

#[test]
fn formulas_agree_with_small_steps() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let (mut rectified, mut blocked) = (0, 0);
    for _ in 0..300 {
        let case = Case::random(&mut random);
        let (mut winding, mut stepped) = (start(&case), Stepped::new(case));
        let period = case.period();
        // Instants as odd as those of a converter, over five periods.
        for _ in 0..12 {
            let ns = random.random_range(1..8000);
            let totals = winding.advance(&case.circuit, &period, f64::from(ns) * NS);
            (stepped.charge, stepped.drawn, stepped.square) = (0.0, 0.0, 0.0);
            for _ in 0..ns {
                stepped.nanosecond();
                blocked += u32::from(stepped.current_a == 0.0);
            }
            let seconds = f64::from(ns) * NS;
            for (what, formula, small, allowed) in [
                ("current", winding.current_a, stepped.current_a, SLACK_A),
                ("pin", winding.pin_v, stepped.pin_v, 2e-4),
                (
                    "mean",
                    totals.charge / seconds,
                    stepped.charge / seconds,
                    SLACK_A,
                ),
                (
                    "drawn",
                    totals.drawn / seconds,
                    stepped.drawn / seconds,
                    SLACK_A,
                ),
                (
                    "square",
                    totals.square / seconds,
                    stepped.square / seconds,
                    1e-6,
                ),
            ] {
                assert!(
                    (formula - small).abs() < allowed,
                    "{what}: {formula} {small}, {case:?} at {} ns",
                    stepped.ns
                );
            }
            rectified += u32::from(case.circuit.sign * winding.current_a < 0.0);
        }
    }
    assert!(rectified > 300 && blocked > 100, "{rectified} {blocked}");
}

#[test]
fn any_division_of_time_gives_the_same() {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let mut at_once = 0;
    for _ in 0..1000 {
        let case = Case::random(&mut random);
        let period = case.period();
        let (mut whole, mut parts) = (start(&case), start(&case));
        let straight = whole.clone().whole(&case.circuit, &period, 5);
        at_once += u32::from(straight.is_some());
        let in_one = whole.advance(&case.circuit, &period, 5.0 * PERIOD_S);
        let mut in_many = Totals::default();
        for _ in 0..7 {
            let totals = parts.advance(&case.circuit, &period, 5.0 * PERIOD_S / 7.0);
            in_many.charge += totals.charge;
            in_many.drawn += totals.drawn;
            in_many.square += totals.square;
        }
        assert!((whole.current_a - parts.current_a).abs() < 1e-9, "{case:?}");
        assert!((whole.pin_v - parts.pin_v).abs() < 1e-7, "{case:?}");
        assert!((in_one.charge - in_many.charge).abs() < 1e-13, "{case:?}");
        assert!((in_one.drawn - in_many.drawn).abs() < 1e-13, "{case:?}");
        assert!((in_one.square - in_many.square).abs() < 1e-13, "{case:?}");
        assert_eq!(whole.phase_s, 0.0);
    }
    // Both ways of computing whole periods were needed.
    assert!((50..950).contains(&at_once), "{at_once}");
}

/// A free closing: 15.7 mA in the mean, between -2.3 and 34.7 mA.
fn free_closing(dead_ns: u32, signed: bool) -> (Case, Winding) {
    let circuit = Circuit {
        sign: 1.0,
        supply_v: 12.0,
        back_emf_v: 3.4,
        constants: Constants::new(35.7, 20e-6, 1e-9),
        diode_v: 0.9,
        chop_a: 1.0,
        sense: Sense {
            signed,
            volt_per_a: 6.8,
            offset_v: 0.0,
        },
    };
    let case = Case {
        circuit,
        half_on_ns: 1650,
        dead_ns,
        current_a: 0.0157,
        pin_v: 0.0,
    };
    let mut winding = start(&case);
    winding.advance(&circuit, &case.period(), 100.0 * PERIOD_S);
    (case, winding)
}

#[test]
fn ripple_has_the_mean_of_the_mean_voltage_and_is_rectified_by_the_mirror() {
    let (case, mut winding) = free_closing(0, false);
    let period = case.period();
    let mean = winding.advance(&case.circuit, &period, PERIOD_S).charge / PERIOD_S;
    assert!((mean - (0.33 * 12.0 - 3.4) / 35.7).abs() < 1e-9, "{mean}");
    let (mut least, mut most, mut sum) = (f64::MAX, f64::MIN, 0.0);
    for _ in 0..1000 {
        winding.advance(&case.circuit, &period, PERIOD_S / 1000.0);
        least = winding.current_a.min(least);
        most = winding.current_a.max(most);
        sum += winding.pin_v / 6.8 / 1000.0;
    }
    assert!(
        (least + 2.28e-3).abs() < 5e-5 && (most - 34.7e-3).abs() < 5e-5,
        "{least} {most}"
    );
    // Twice the area below zero in brake, once in drive.
    let excess = sum - mean;
    assert!((0.8e-4..2e-4).contains(&excess), "{excess}");
}

#[test]
fn dead_time_takes_voltage_from_a_current_either_way() {
    let mean = |dead_ns, back_emf_v| {
        let (mut case, mut winding) = free_closing(dead_ns, true);
        case.circuit.back_emf_v = back_emf_v;
        let period = case.period();
        winding.advance(&case.circuit, &period, 100.0 * PERIOD_S);
        winding.advance(&case.circuit, &period, PERIOD_S).charge / PERIOD_S
    };
    // 300 ns of 10 us at 12 V and twice the diode's drop, over 35.7 ohm.
    let lost = mean(0, 0.0) - mean(300, 0.0);
    assert!(
        (lost - 0.03 * (12.0 + 2.0 * 0.9) / 35.7).abs() < 1e-5,
        "{lost}"
    );
    let gained = mean(300, 8.0) - mean(0, 8.0);
    assert!(
        (gained - 0.03 * (12.0 + 2.0 * 0.9) / 35.7).abs() < 1e-5,
        "{gained}"
    );
}

#[test]
fn instants_found_at_once_are_those_found_one_by_one() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let mut at_once = 0;
    for _ in 0..1000 {
        let case = Case::random(&mut random);
        let period = case.period();
        let mut winding = start(&case);
        winding.advance(&case.circuit, &period, 3.0 * PERIOD_S);
        let late = random.random_bool(0.5);
        let at_s = [
            if late { 0.51 * PERIOD_S } else { 0.0 } + random.random_range(0.0..4e-7),
            random.random_range(1e-8..6.3e-7),
        ];
        let mut volts = [f64::NAN; INSTANTS];
        if !period.try_fill(&case.circuit, &winding, at_s, &mut volts) {
            continue;
        }
        at_once += 1;
        let mut wait_s = at_s[0];
        for (n, volt) in volts.into_iter().enumerate() {
            winding.wait(&case.circuit, &period, wait_s);
            wait_s = at_s[1];
            assert!((volt - winding.pin_v).abs() < 1e-8, "{n}: {case:?}");
        }
        // Other instants, or some beyond the period, are not found.
        let begun = start(&case);
        let beyond = [6e-6, 7e-7];
        for other in [[at_s[0], 0.5 * at_s[1]], beyond] {
            assert!(!period.try_fill(&case.circuit, &begun, other, &mut volts));
        }
        let fresh = case.period();
        assert!(!fresh.try_fill(&case.circuit, &begun, beyond, &mut volts));
    }
    // Both ways were needed.
    assert!((50..950).contains(&at_once), "{at_once}");
}

#[test]
fn the_series_is_the_exponential() {
    for step in 0..2000 {
        let x = 1e-4 * f64::from(step);
        let relative = periods::left_after(x) * x.exp() - 1.0;
        assert!(relative.abs() < 5e-16, "{x}: {relative}");
    }
}
