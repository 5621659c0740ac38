//! False contacts against delay: what each choice of the setting `sensitivity` costs in a world.
//!
//! Fingers drawn from the spreads close on nothing and on something; every closing is simulated once and judged with every
//! choice.

use palpate_document::table::head;
use palpate_scenes::P70;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::Serialize;

use crate::experiments::catalogue::random_cylinder;
use crate::experiments::job::{Plan, Wanted, closing};
use crate::experiments::live::{Failure, Setup};
use crate::experiments::result::Place;
use crate::experiments::session::{Case, Session};
use crate::score::{Scores, Trial};

/// Choices of the setting, false contacts per thousand closings.
pub const CHOICES: [f32; 6] = [100.0, 10.0, 1.0, 0.1, 0.01, 0.001];
/// Free closings of one finger.
const CLOSINGS: usize = 50;
/// Contacts of one finger: on the proximal phalanx, where a contact is softest, and on the distal one.
const CONTACTS: [usize; 2] = [5, 5];

/// What one choice costs.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// The setting, false contacts per thousand closings.
    pub sensitivity: f32,
    /// Free closings.
    pub free: usize,
    /// Touches in them.
    pub false_contacts: usize,
    /// Those said to be softer than a free finger.
    pub unusual: usize,
    /// Contacts.
    pub contacts: usize,
    /// Of them: felt before they were there.
    pub early: usize,
    /// Of them: never felt.
    pub missed: usize,
    /// Delay of the contacts on the proximal phalanx, median and 90 %, millisecond.
    pub proximal_ms: [Option<f64>; 2],
    /// The same, distal phalanx.
    pub distal_ms: [Option<f64>; 2],
}

/// The trials of one finger by choice.
type Trials = Vec<[Trial; CHOICES.len()]>;

fn judged(session: &mut Session<P70>, case: &Case) -> Result<[Trial; CHOICES.len()], Failure> {
    let calibration = session.calibrated;
    let mut trials = [Trial::default(); CHOICES.len()];
    for (trial, choice) in trials.iter_mut().zip(CHOICES) {
        session.settings.false_contacts_per_thousand = choice;
        *trial = session.ours(case, &calibration)?;
    }
    Ok(trials)
}

fn finger(plan: &Plan, index: u64, closings: usize) -> Result<Trials, Failure> {
    let seed = plan.seed + 7000 + index;
    let mut session =
        Session::<P70>::new(&plan.parameters.randomised(seed), &Setup::default(), seed)?;
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x00fa_15e0);
    let mut trials = Trials::new();
    for _ in 0..closings {
        let case = session.free_closing()?;
        trials.push(judged(&mut session, &case)?);
    }
    for (phalanx, (contacts, length_m)) in (1..).zip(CONTACTS.into_iter().zip([0.090, 0.070])) {
        for _ in 0..contacts {
            let case = closing(&mut session, || Wanted {
                object: random_cylinder(&mut random),
                phalanx,
                k_m: length_m * random.random_range(0.05..0.95),
                theta_1_rad: random.random_range(0.25..1.1),
                any_first: false,
            })?;
            trials.push(judged(&mut session, &case)?);
        }
    }
    Ok(trials)
}

/// `closings` free closings on as many fingers as they need. The second list: fingers that did not get through.
#[must_use]
pub fn study(plan: &Plan, closings: usize) -> (Vec<Row>, Vec<Failure>) {
    let fingers = closings.div_ceil(CLOSINGS) as u64;
    let each = closings.div_ceil(fingers.max(1) as usize);
    let found: Vec<_> = (0..fingers)
        .into_par_iter()
        .map(|index| finger(plan, index, each))
        .collect();
    let (mut all, mut failed) = (Trials::new(), Vec::new());
    for one in found {
        match one {
            Ok(trials) => all.extend(trials),
            Err(failure) => failed.push(failure),
        }
    }
    let row = |index: usize| {
        let trials: Vec<Trial> = all.iter().map(|trials| trials[index]).collect();
        let on = |phalanx: u8| {
            let of = trials.iter().filter(|trial| {
                trial
                    .truth
                    .is_some_and(|contact| contact.phalanx == phalanx)
            });
            Scores::of(of)
        };
        let free = Scores::of(trials.iter().filter(|trial| trial.truth.is_none()));
        let [proximal, distal] = [on(1), on(2)];
        let delays = |scores: &Scores| [scores.touch_delay_ms, scores.touch_delay_90_ms];
        Row {
            place: plan.place.clone(),
            sensitivity: CHOICES[index],
            free: free.free,
            false_contacts: free.free_touched,
            unusual: free.unusual,
            contacts: proximal.closings + distal.closings,
            early: proximal.early + distal.early,
            missed: proximal.missed + distal.missed,
            proximal_ms: delays(&proximal),
            distal_ms: delays(&distal),
        }
    };
    ((0..CHOICES.len()).map(row).collect(), failed)
}

/// The table of the manual.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut out = head(
        "world | `sensitivity` | false contacts | false `unusual` | contacts early, missed | proximal, ms: median, 90 % \
         | distal, ms: median, 90 %",
    );
    let whole = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.0}"));
    let pair = |[a, b]: [Option<f64>; 2]| format!("{}, {}", whole(a), whole(b));
    for row in rows {
        let line = format!(
            "| {} | {} | {} of {} | {} | {}, {} of {} | {} | {} |\n",
            row.place.world,
            row.sensitivity,
            row.false_contacts,
            row.free,
            row.unusual,
            row.early,
            row.missed,
            row.contacts,
            pair(row.proximal_ms),
            pair(row.distal_ms),
        );
        out.push_str(&line);
    }
    out
}
