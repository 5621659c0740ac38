//! What becomes of a contact, told next to the truth: contacts that roll, slip, are lost or pushed, while the torque rises and
//! while the object is held. A few of each in `workshop`; the figures of docs/MECHANICS.md are
//! `PALPATE_HOLDS=100 PALPATE_WORLD=harsh cargo test --profile host -p palpate-simulation --test changes -- --nocapture`.

use palpate::drive::sequence::State;
use palpate::sensing::{Change, Followed};
use palpate_plant::{Grasp, Plant, Shape, World};
use palpate_scenes::P70Hold;
use palpate_simulation::{Outcome, Simulation, Verdict};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Grasps of a finger before the next one is drawn.
const GRASPS: usize = 10;
/// Samples in which an object moves.
const MOVING: u32 = 5;
/// A change is told in time within this, second.
const IN_TIME_S: f64 = 0.05;
/// A change counts as large while the torque rises from this torque on, newton metre, and in the hold where more than this share
/// is gone.
const LARGE_NM: f64 = 0.02;
const LARGE_SHARE: f64 = 0.5;

/// When something happens.
#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    Never,
    /// While the torque rises, at this torque of the input link, newton metre.
    Rising(f64),
    /// So long into the hold, second.
    Holding(f64),
}

/// What happens then.
#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    Nothing,
    /// The object goes.
    Goes,
    /// It moves away from the phalanx by this distance, or (negative) towards it, metre.
    Gives(f64),
}

/// What happened: when it began, and the torques before and after.
#[derive(Clone, Copy, Debug)]
struct Happened {
    time_s: f64,
    from_nm: f64,
    to_nm: f64,
    is_held: bool,
}

/// Lets something happen to the object.
struct Event {
    when: When,
    what: What,
    held: u32,
    left: u32,
    away: [f64; 2],
    happened: Option<Happened>,
}

impl Event {
    fn new(when: When, what: What) -> Self {
        Self {
            when,
            what,
            held: 0,
            left: MOVING,
            away: [0.0; 2],
            happened: None,
        }
    }

    /// After every sample.
    fn advance(&mut self, plant: &mut Plant, state: State) {
        self.held += u32::from(state == State::Hold);
        let truth = plant.truth();
        if let Some(happened) = &mut self.happened {
            if self.left > 0 {
                self.left -= 1;
                if let What::Gives(by_m) = self.what {
                    let by = self.away.map(|part| part * by_m / f64::from(MOVING));
                    plant.shift(by).expect("it moves");
                }
                happened.to_nm = truth.torque_nm;
            }
            return;
        }
        let is_due = match self.when {
            When::Never => false,
            When::Rising(torque_nm) => state == State::Probe && truth.torque_nm > torque_nm,
            When::Holding(s) => f64::from(self.held) * 1e-3 > s,
        };
        let Some(contact) = truth.strongest().filter(|_| is_due) else {
            return;
        };
        let angles = &truth.joint_rad[..usize::from(contact.phalanx)];
        let (sin, cos) = angles.iter().sum::<f64>().sin_cos();
        self.away = [-sin, cos];
        self.happened = Some(Happened {
            time_s: truth.time_s,
            from_nm: truth.torque_nm,
            to_nm: truth.torque_nm,
            is_held: state == State::Hold,
        });
        if self.what == What::Goes {
            plant.place(&Grasp::Free).expect("nothing is in the way");
        }
    }
}

/// What a kind of event came to.
#[derive(Debug, Default)]
struct Score {
    happened: u32,
    /// Large ones.
    large: u32,
    told: u32,
    large_told: u32,
    in_time: u32,
    right: u32,
    /// Told before anything happened.
    early: u32,
    delays_s: Vec<f64>,
}

fn changes(outcome: &Outcome) -> impl Iterator<Item = (f64, Change)> {
    outcome
        .followed
        .iter()
        .filter_map(|(us, event)| match event {
            Followed::Changed { change, .. } => Some((*us as f64 * 1e-6, *change)),
            _ => None,
        })
}

impl Score {
    fn add(&mut self, outcome: &Outcome, happened: Option<Happened>, wanted: &[Change]) {
        let Some(happened) = happened else {
            self.early += u32::from(changes(outcome).next().is_some());
            return;
        };
        self.happened += 1;
        self.early += u32::from(changes(outcome).any(|(at_s, _)| at_s < happened.time_s));
        let is_large = if happened.is_held {
            happened.to_nm < LARGE_SHARE * happened.from_nm
        } else {
            (happened.from_nm - happened.to_nm).abs() > LARGE_NM
        };
        self.large += u32::from(is_large);
        let mut since = changes(outcome).filter(|(at_s, _)| *at_s >= happened.time_s);
        if let Some((at_s, _)) = since.next() {
            let delay_s = at_s - happened.time_s;
            self.told += 1;
            self.large_told += u32::from(is_large);
            self.in_time += u32::from(delay_s <= IN_TIME_S);
            self.delays_s.push(delay_s);
        }
        let any = changes(outcome)
            .any(|(at_s, change)| at_s >= happened.time_s && wanted.contains(&change));
        self.right += u32::from(any);
    }

    fn delay_ms(&self, share: f64) -> f64 {
        let last = self.delays_s.len().saturating_sub(1);
        let at = (share * last as f64).round() as usize;
        self.delays_s.get(at).map_or(f64::NAN, |s| 1e3 * s)
    }

    fn print(&mut self, name: &str) {
        self.delays_s.sort_by(f64::total_cmp);
        println!(
            "{name}: {} happened, {} told ({} as what they were, {} within 50 ms); of {} large ones {}; delay median {:.0}, \
             largest {:.0} ms; {} told before",
            self.happened,
            self.told,
            self.right,
            self.in_time,
            self.large,
            self.large_told,
            self.delay_ms(0.5),
            self.delay_ms(1.0),
            self.early
        );
    }
}

/// A place after rolling: error, deviation, how far it had rolled, error of the place where it began; metre.
type Rolled = [f64; 4];

fn rolled(outcome: &Outcome) -> Option<Rolled> {
    let first = outcome.first_contact?.contact;
    let [now] = outcome.truth.contacts[..] else {
        return None;
    };
    let Verdict::Located { k_m: began_m, .. } = outcome.verdict else {
        return None;
    };
    outcome.followed.iter().find_map(|(_, event)| match *event {
        Followed::Moved {
            phalanx,
            k_m,
            sigma_m,
            ..
        } if phalanx == now.phalanx => Some([
            (f64::from(k_m) - now.k_m).abs(),
            f64::from(sigma_m),
            (now.k_m - first.k_m).abs(),
            (began_m - now.k_m).abs(),
        ]),
        _ => None,
    })
}

#[test]
fn what_becomes_of_a_contact_is_told_and_a_quiet_one_stays_quiet() {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .map(|n| n.parse().expect("a number"))
    };
    let is_small = std::env::var("PALPATE_HOLDS").is_err();
    let count: usize = number("PALPATE_HOLDS").unwrap_or(6);
    let name = std::env::var("PALPATE_WORLD").unwrap_or_else(|_| "workshop".to_owned());
    let world = World::named(&name).expect("a world");
    let mut scores: [Score; 8] = Default::default();
    let mut places: Vec<Rolled> = Vec::new();
    let mut random = Pcg64Mcg::seed_from_u64(15);
    let mut finger = None;
    for grasp in 0..count {
        if grasp % GRASPS == 0 {
            let seed = 1 + (grasp / GRASPS) as u64;
            let parameters = world.of("p70-hold").expect("a scene").randomised(seed);
            let mut simulation = Simulation::<P70Hold>::new(&parameters, seed).expect("a finger");
            simulation.prepare().expect("a record");
            simulation.press().expect("a cable");
            for k_m in [0.02, 0.05] {
                simulation.calibrate(2, k_m, 0.8).expect("a pin");
            }
            finger = Some(simulation);
        }
        let shape = Shape::Cylinder {
            diameter_m: random.random_range(0.006..0.04),
        };
        let k_m = 0.07 * random.random_range(0.2..0.85);
        let object = Grasp::touching(2, k_m, random.random_range(0.55..1.0), shape);
        let rising = When::Rising(random.random_range(0.08..0.25));
        let holding = When::Holding(random.random_range(0.1..0.4));
        let by_m = random.random_range(1e-3..8e-3);
        let (slips, pushes) = (What::Gives(by_m), What::Gives(-1.5 * by_m));
        let fallen: &[Change] = &[Change::Slipped, Change::Lost];
        let cases: [(When, What, &[Change]); 8] = [
            (When::Never, What::Nothing, &[]),
            (rising, slips, fallen),
            (rising, What::Goes, &[Change::Lost]),
            (rising, pushes, &[Change::Pushed]),
            (holding, slips, fallen),
            (holding, What::Goes, &[Change::Lost]),
            (holding, pushes, &[Change::Pushed]),
            (holding, What::Gives(6.0 * by_m), fallen),
        ];
        for (index, (when, what, wanted)) in cases.into_iter().enumerate() {
            let mut simulation = finger.clone().expect("a finger");
            simulation.plant().reseed((1000 * grasp + index) as u64);
            let mut event = Event::new(when, what);
            let Ok(outcome) = simulation.close_while(&object, |plant, state| {
                event.advance(plant, state);
            }) else {
                continue;
            };
            println!(
                "{grasp} {when:?} {what:?}: {:?} {:?} {:?} {:?}",
                outcome.verdict, event.happened, outcome.followed, outcome.fault
            );
            if index == 0 {
                scores[0].happened += 1;
                places.extend(rolled(&outcome));
            }
            if event.happened.is_some() || index == 0 {
                scores[index].add(&outcome, event.happened, wanted);
            }
        }
    }
    let names = [
        "quiet",
        "gave way, rising",
        "gone, rising",
        "pushed, rising",
        "gave way, held",
        "gone, held",
        "pushed, held",
        "gave way far, held",
    ];
    for (score, name) in scores.iter_mut().zip(names) {
        score.print(name);
    }
    let count = places.len() as f64;
    let mean = |of: usize| places.iter().map(|rolled| rolled[of]).sum::<f64>() / count;
    let within = places
        .iter()
        .filter(|[error, sigma, ..]| *error <= 2.0 * sigma);
    let within = within.count() as f64 / count;
    println!(
        "{count} contacts rolled by {:.1} mm (mean): told with an error of {:.2} mm (mean), {:.0} % within two deviations; {:.2} mm if \
         taken as where they began",
        1e3 * mean(2),
        1e3 * mean(0),
        100.0 * within,
        1e3 * mean(3)
    );
    let [quiet, gives, goes, pushed, _, goes_held, pushed_held, _] = scores;
    assert!(quiet.happened > 0 && goes.happened == quiet.happened);
    assert_eq!(quiet.early, 0, "told of a quiet hold");
    if !is_small {
        return;
    }
    for score in [&gives, &goes, &pushed, &goes_held] {
        assert_eq!(score.early, 0, "told before");
        assert!(
            score.large_told == score.large && score.large > 0,
            "{score:?}"
        );
    }
    for gone in [&goes, &goes_held] {
        let all = gone.happened;
        assert_eq!((gone.right, gone.in_time), (all, all), "{gone:?}");
    }
    // The worm holds the push, and the motor stands: there is nothing to tell it from.
    assert_eq!(pushed_held.told, 0);
    assert!(mean(0) < 3e-3 && within > 0.8);
}
