//! Trade-off of the user's settings: the time from first contact to an answer against the answer's error. Simulated: the library's
//! control, sequence and sensing on the simulation's plant, default scene.
//!
//! Fingers differ from one another and from the scene as the plant's parameters are uncertain. Each is homed, records its
//! friction at the closing speed and goes through the guided calibration; then it closes on cylinders of 4 to 40 mm
//! diameter at places from 0.1 to 0.9 of the distal phalanx. Delays count from the plant's true first contact until the
//! sensing tells an event; the time that a fit takes on the chip is not in them (see the whole path: some milliseconds).

use anyhow::{Result, anyhow};
use palpate::app::console::command::Command;
use palpate::app::console::settings::Setting;
use palpate::sensing::Event;
use palpate_plant::{Grasp, Parameters, Shape};
use palpate_scenes::P70;
use palpate_simulation::places::PIN_SHARES;
use palpate_simulation::{Outcome, Simulation};
use rayon::prelude::*;
use serde::Serialize;

/// Fingers, and closings of each, for every choice.
pub const FINGERS: u64 = 4;
pub const CLOSINGS: u32 = 20;

/// Length of the distal phalanx, metre.
const LENGTH_M: f32 = 0.070;
/// theta_1 at the pins, radian.
const PIN_RAD: f64 = 0.6;

/// Settings that a user may choose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// `closing-speed`.
    pub closing_speed_rad_per_s: f32,
    /// `wanted-deviation`.
    pub wanted_deviation_mm: f32,
    /// `probe-torque`.
    pub probe_torque_mnm: f32,
}

/// The scene's own: 0.3 rad/s, 0.3 mm, 350 mNm.
pub const USUAL: Choice = Choice {
    closing_speed_rad_per_s: 0.3,
    wanted_deviation_mm: 0.3,
    probe_torque_mnm: 350.0,
};
const SPEEDS: [f32; 3] = [0.15, 0.3, 0.6];
const DEVIATIONS_MM: [f32; 4] = [0.2, 0.3, 1.0, 3.0];
const TORQUES_MNM: [f32; 3] = [25.0, 50.0, 100.0];

/// Every deviation at every speed, and less torque at the scene's own of both.
fn choices() -> Vec<Choice> {
    let of_speeds = SPEEDS.into_iter().flat_map(|closing_speed_rad_per_s| {
        DEVIATIONS_MM.map(|wanted_deviation_mm| Choice {
            closing_speed_rad_per_s,
            wanted_deviation_mm,
            ..USUAL
        })
    });
    let of_torques = TORQUES_MNM.map(|probe_torque_mnm| Choice {
        probe_torque_mnm,
        ..USUAL
    });
    of_speeds.chain(of_torques).collect()
}

/// An answer and when it came.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Answer {
    delay_ms: f64,
    error_mm: f64,
}

/// What one closing gave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Closing {
    touch_ms: Option<f64>,
    /// The first place told, and the last one.
    first: Option<Answer>,
    last: Option<Answer>,
    settled: bool,
    /// The last place told is on another phalanx than the contact.
    wrong: bool,
}

fn closing(outcome: &Outcome) -> Closing {
    let Some(contact) = outcome.first_contact else {
        return Closing::default();
    };
    let since_ms = |time_us: u64| 1e3 * (time_us as f64 * 1e-6 - contact.time_s);
    let mut closing = Closing::default();
    for (time_us, event) in &outcome.events {
        match event {
            Event::Touch { .. } => {
                closing.touch_ms.get_or_insert(since_ms(*time_us));
            }
            Event::Located {
                phalanx,
                k_m,
                settled,
                ..
            } => {
                closing.wrong = *phalanx != contact.contact.phalanx;
                let answer = Answer {
                    delay_ms: since_ms(*time_us),
                    error_mm: 1e3 * (f64::from(*k_m) - contact.contact.k_m).abs(),
                };
                closing.last = (!closing.wrong).then_some(answer);
                closing.first = closing.first.or(closing.last);
                closing.settled |= settled;
            }
            _ => {}
        }
    }
    closing
}

/// A line of the report: the closings of one choice.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// `delay`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// The settings.
    #[serde(flatten)]
    pub choice: Choice,
    /// Closings on an object.
    pub closings: usize,
    /// With a touch.
    pub touched: usize,
    /// With a place on the right phalanx at the end.
    pub located: usize,
    /// Whose last place was called settled.
    pub settled: usize,
    /// With a place on the wrong phalanx at the end.
    pub wrong_phalanx: usize,
    /// From first contact to the touch told, millisecond: median and 90th percentile.
    pub touch_ms: [f64; 2],
    /// To the first place told.
    pub first_ms: [f64; 2],
    /// Its error, millimetre.
    pub first_error_mm: [f64; 2],
    /// To the last place told: settled, or the torque's limit.
    pub last_ms: [f64; 2],
    /// Its error.
    pub last_error_mm: [f64; 2],
    /// The largest of them.
    pub last_error_mm_max: f64,
}

/// Median and 90th percentile.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    [0.5, 0.9].map(|share| {
        let at = (share * values.len().saturating_sub(1) as f64).round() as usize;
        values.get(at).copied().unwrap_or(f64::NAN)
    })
}

impl Row {
    fn new(choice: Choice, closings: &[Closing]) -> Self {
        let of = |which: fn(&Closing) -> Option<f64>| spread(closings.iter().filter_map(which));
        let count = |which: fn(&Closing) -> bool| closings.iter().filter(|c| which(c)).count();
        Self {
            kind: "delay",
            choice,
            closings: closings.len(),
            touched: count(|c| c.touch_ms.is_some()),
            located: count(|c| c.last.is_some()),
            settled: count(|c| c.settled),
            wrong_phalanx: count(|c| c.wrong),
            touch_ms: of(|c| c.touch_ms),
            first_ms: of(|c| Some(c.first?.delay_ms)),
            first_error_mm: of(|c| Some(c.first?.error_mm)),
            last_ms: of(|c| Some(c.last?.delay_ms)),
            last_error_mm: of(|c| Some(c.last?.error_mm)),
            last_error_mm_max: closings
                .iter()
                .filter_map(|c| Some(c.last?.error_mm))
                .fold(0.0, f64::max),
        }
    }

    /// The choice in few words.
    pub fn label(&self) -> String {
        let Choice {
            closing_speed_rad_per_s,
            wanted_deviation_mm,
            probe_torque_mnm,
        } = self.choice;
        format!("{closing_speed_rad_per_s} rad/s, {wanted_deviation_mm} mm, {probe_torque_mnm} mNm")
    }
}

/// What a user types.
fn set(simulation: &mut Simulation<P70>, setting: Setting, value: f32) -> Result<()> {
    let command = Command::Set(setting, value);
    let told = simulation.slow().coordinator.command(command);
    told.map_err(|refused| anyhow!("{setting:?} = {value}: {refused:?}"))?;
    // One order a millisecond reaches the sensing.
    simulation.idle(0.01);
    Ok(())
}

/// A finger at home that has recorded its friction at a speed and is calibrated.
fn finger(seed: u64, speed: f32) -> Result<Simulation<P70>> {
    let parameters = Parameters::default().randomised(seed);
    let mut simulation = Simulation::<P70>::new(&parameters, seed)?;
    set(&mut simulation, Setting::ClosingSpeed, speed)?;
    let prepared = simulation.prepare()?;
    anyhow::ensure!(
        prepared.fault.is_none(),
        "finger {seed}: {:?}",
        prepared.fault
    );
    for share in PIN_SHARES {
        simulation.calibrate(2, share as f32 * LENGTH_M, PIN_RAD)?;
    }
    Ok(simulation)
}

/// An object's place and size: spread evenly, places and sizes apart from each other.
fn grasp(at: u32) -> Grasp {
    let share = |step: f64| (f64::from(at) + 0.5) * step % 1.0;
    let k_m = f64::from(LENGTH_M) * (0.1 + 0.8 * share(0.618_033_988_749_895));
    let diameter_m = 0.004 + 0.036 * share(0.754_877_666_246_693);
    let theta_1 = 0.4 + 0.5 * share(0.569_840_290_998_053);
    Grasp::touching(2, k_m, theta_1, Shape::Cylinder { diameter_m })
}

/// One finger's closings under a choice, from the same state each.
fn close(
    finger: &Simulation<P70>,
    seed: u64,
    choice: &Choice,
    closings: u32,
) -> Result<Vec<Closing>> {
    let mut set_up = finger.clone();
    set(
        &mut set_up,
        Setting::WantedDeviation,
        1e-3 * choice.wanted_deviation_mm,
    )?;
    set(
        &mut set_up,
        Setting::ProbeTorque,
        1e-3 * choice.probe_torque_mnm,
    )?;
    (0..closings)
        .map(|at| {
            let at = at + seed as u32 * closings;
            let mut simulation = set_up.clone();
            simulation.reseed(u64::from(at) + 1);
            Ok(closing(&simulation.close(&grasp(at))?))
        })
        .collect()
}

fn measure(choices: &[Choice], fingers: u64, closings: u32) -> Result<Vec<Row>> {
    let mut speeds: Vec<f32> = choices.iter().map(|c| c.closing_speed_rad_per_s).collect();
    speeds.sort_by(f32::total_cmp);
    speeds.dedup();
    let wanted: Vec<(f32, u64)> = speeds
        .iter()
        .flat_map(|speed| (1..=fingers).map(|seed| (*speed, seed)))
        .collect();
    let simulations: Vec<((f32, u64), Simulation<P70>)> = wanted
        .into_par_iter()
        .map(|(speed, seed)| Ok(((speed, seed), finger(seed, speed)?)))
        .collect::<Result<_>>()?;
    let jobs: Vec<(&Choice, u64, &Simulation<P70>)> = choices
        .iter()
        .flat_map(|choice| {
            simulations
                .iter()
                .filter(|((speed, _), _)| *speed == choice.closing_speed_rad_per_s)
                .map(move |((_, seed), simulation)| (choice, *seed, simulation))
        })
        .collect();
    let closed: Vec<Vec<Closing>> = jobs
        .par_iter()
        .map(|(choice, seed, simulation)| close(simulation, *seed, choice, closings))
        .collect::<Result<_>>()?;
    Ok(choices
        .iter()
        .map(|choice| {
            let of_choice: Vec<Closing> = jobs
                .iter()
                .zip(&closed)
                .filter(|((other, ..), _)| *other == choice)
                .flat_map(|(_, closings)| closings.iter().copied())
                .collect();
            Row::new(*choice, &of_choice)
        })
        .collect())
}

/// All choices.
pub fn rows() -> Result<Vec<Row>> {
    measure(&choices(), FINGERS, CLOSINGS)
}

#[cfg(test)]
mod tests {
    use super::super::delay_table::SHOWN;
    use super::{Choice, USUAL, choices, measure, spread};

    #[test]
    fn a_wish_for_less_deviation_costs_time() {
        let hasty = Choice {
            wanted_deviation_mm: 3.0,
            ..USUAL
        };
        let rows = measure(&[hasty, USUAL], 1, 6).expect("the simulation runs");
        let [hasty, careful] = &rows[..] else {
            panic!("two choices")
        };
        assert_eq!((hasty.closings, careful.closings), (6, 6));
        assert!(careful.located >= 5, "{careful:?}");
        assert!(
            hasty.last_ms[0] < careful.last_ms[0],
            "{hasty:?} {careful:?}"
        );
        // Over six closings the errors themselves do not tell the two apart: both are far inside what is wanted.
        for row in [hasty, careful] {
            assert!(row.last_error_mm[1] < 3.0, "{row:?}");
        }
        for row in &rows {
            let order = [row.touch_ms[0], row.first_ms[0], row.last_ms[0]];
            assert!(order[0] > 0.0 && order.is_sorted(), "{row:?}");
        }
    }

    #[test]
    fn the_scene_s_own_settings_are_a_choice_once() {
        let choices = choices();
        assert_eq!(choices.iter().filter(|choice| **choice == USUAL).count(), 1);
        let settings = <palpate_scenes::P70 as palpate::scene::Scene>::settings();
        assert_eq!(settings.speed_rad_per_s, USUAL.closing_speed_rad_per_s);
        for shown in SHOWN {
            assert!(choices.contains(&shown), "docs/RESULTS.md shows {shown:?}");
        }
        assert!((1e3 * settings.wanted_sigma_m - USUAL.wanted_deviation_mm).abs() < 1e-6);
        assert!((1e3 * settings.torque_limit_nm - USUAL.probe_torque_mnm).abs() < 1e-3);
    }

    #[test]
    fn quantiles_of_nothing_are_no_number() {
        assert!(
            spread(std::iter::empty())
                .iter()
                .all(|value| value.is_nan())
        );
        assert_eq!(spread([3.0, 1.0, 2.0].into_iter()), [2.0, 3.0]);
    }
}
