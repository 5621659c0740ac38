//! The sensor: samples and directives in, events out.
//!
//! | stage | what runs |
//! |---|---|
//! | free motion recorded | [`Recorder`] |
//! | closing, nothing felt | [`Detector`] on the residual of the record |
//! | contact | [`Curve`], and every block one step of the [`Locator`] |
//! | motion over | the locator until its fits stand still, one step every dozen samples; then the last word |

use crate::finger::{Free, Mechanics};
use crate::numeric::sqrt;
use crate::sensing::block::{Block, Gate, Step};
use crate::sensing::curve::{self, Curve, Point};
use crate::sensing::detector::{self, Detector, Finding};
use crate::sensing::fit::{self, Data, Estimate, LEAST_POINTS, Place, Prior};
use crate::sensing::friction::{Friction, Recorder};
use crate::sensing::joint::{Hall, JointSensor, NoHall};
use crate::sensing::locator::{self, Locator, Verdict};
use crate::sensing::{
    Calibration, Directive, Drive, Drivetrain, Event, NotLocated, Refusal, Sample, Settings,
};
use core::mem;
use heapless::{Deque, Vec};

/// Blocks kept, so that the curve starts at the onset and not at its detection: a quarter of a second.
const HISTORY: usize = 32;
/// Deviation of the onset as the detector sees it, radian: a tenth of a second of motion.
const ONSET_SIGMA_RAD: f32 = 0.03;
/// How well a pin is placed by hand or by a gauge, metre (R, chosen).
const PIN_SIGMA_M: f32 = 0.3e-3;
/// Steps that each hypothesis gets when the motion is over.
const LAST_STEPS: u8 = 40;
/// Samples between two of them: a step takes several milliseconds on the target, and samples must not pile up meanwhile.
const SAMPLES_PER_LAST_STEP: u8 = 12;
/// A point enters the fit when its torque stands this many deviations above zero.
const CLEAR_SIGMAS: f32 = 4.0;
/// A deviation that shrinks by less than this factor while the torque grows by a quarter will not be worth more torque.
const NO_HELP: f32 = 0.93;
/// Deviation of k, as a share of the phalanx, above which all the torque there is will be used: far up the curve its bend
/// tells what the slope alone cannot.
const SHARP: f32 = 0.012;
/// Deviation of k, as a share of the phalanx, above which no location is reported.
const VAGUE: f32 = 0.25;
/// Mean square residual, in variances, up to which a curve counts as explained well.
const GOOD: f32 = 4.0;
/// Growth of it with which a curve has left its path.
const WORSE: f32 = 5.0;
/// Rounds that it takes to believe it.
const WORSE_ROUNDS: u8 = 4;
/// A location is reported anew when its deviation has shrunk by this factor.
const SHARPER: f32 = 0.75;
/// Systematic error of the cable's twist that a press does not show (how much it creeps), as a share.
const PRESS_SHARE: f32 = 0.005;
/// Error of the friction beyond the record, continued periodically, as a share of its unevenness within (R, chosen).
const UNSURE_BEYOND: f32 = 0.15;
/// How much the closing stop may yield, radian per newton metre (R, chosen): it counts as cable.
const STOP_YIELD_RAD_PER_NM: f32 = 4e-3;
/// A contact is lost when the torque falls by this share of itself and this many deviations of a block.
const LOST_SHARE: f32 = 0.03;
const LOST_SIGMAS: f32 = 8.0;
/// Share of the record's bins that a recording must fill.
const COVERAGE: f32 = 0.6;

/// A block as it is remembered.
#[derive(Clone, Copy, Debug)]
struct Past<R> {
    time_us: u64,
    counts: i32,
    width_counts: u32,
    residual_nm: f32,
    /// How far beyond the friction record, counts.
    beyond_counts: f32,
    /// As in [`Block`].
    inertia_nm: f32,
    overspeed: f32,
    reading: R,
}

/// A contact in hand.
#[derive(Clone, Debug)]
struct Touching<R> {
    curve: Curve,
    locator: Locator,
    /// What the record's level was off by, and its deviation, newton metre of motor torque.
    level_nm: f32,
    level_sigma_nm: f32,
    noise_nm2_counts: f32,
    /// How uneven the friction is over the travel, newton metre of motor torque.
    unevenness_nm: f32,
    onset_rad: f32,
    reading: R,
    torque_nm: f32,
    /// The torque as the cable's creep feels it, and when it was last brought up to date.
    late_nm: f32,
    late_us: u64,
    /// The last block: it joins the curve when its neighbour has told its acceleration.
    waiting: Past<R>,
    /// Torque and deviation when it was last asked whether more torque helps.
    asked: (f32, f32),
    reported: Reported,
    /// The last verdict from a curve that was explained well, and its misfit.
    good: Option<(Verdict, f32)>,
    /// Rounds in a row whose misfit was much worse.
    worse: u8,
    /// Steps left after the motion ended; None while it goes on.
    last_steps: Option<u8>,
    /// Samples until the next of them.
    pause: u8,
    settled: bool,
}

impl<R> Touching<R> {
    /// No more is to come; the last word is due.
    fn end(&mut self) {
        if self.last_steps.is_none() {
            self.locator.refresh();
            self.last_steps = Some(LAST_STEPS);
        }
    }
}

/// What was said last.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reported {
    Nothing,
    Located { phalanx: u8, k_m: f32, sigma_m: f32 },
    Ambiguous,
}

/// What is in hand. Never two at a time: they share their memory.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put one on")]
enum Work<R> {
    Nothing,
    /// Friction is being recorded.
    Recording(Recorder),
    /// A contact is being judged.
    Contact(Touching<R>),
}

/// Contact sensing of one finger. See the module documentation.
///
/// `H` is [`NoHall`] or [`Hall`].
#[derive(Clone, Debug)]
pub struct Sensor<F: Mechanics, H: JointSensor = NoHall> {
    finger: F,
    drivetrain: Drivetrain,
    settings: Settings,
    calibration: Calibration,
    directive: Directive,
    gate: Gate,
    friction: Option<Friction>,
    work: Work<H::Reading>,
    detector: Option<Detector>,
    history: Deque<Past<H::Reading>, HISTORY>,
    /// The contact of this closing has been judged, or what was found was no contact.
    done: bool,
    stale_told: bool,
    posture: F::Configuration,
    reading: H::Reading,
    events: Deque<Event, 4>,
}

impl<F: Mechanics, H: JointSensor> Sensor<F, H> {
    /// A sensor without friction record.
    pub fn new(
        finger: F,
        drivetrain: Drivetrain,
        settings: Settings,
        calibration: Calibration,
    ) -> Self {
        let posture = finger.rest();
        Self {
            finger,
            drivetrain,
            settings,
            calibration,
            directive: Directive::Rest,
            gate: Gate::default(),
            friction: None,
            work: Work::Nothing,
            detector: None,
            history: Deque::new(),
            done: false,
            stale_told: false,
            posture,
            reading: H::Reading::default(),
            events: Deque::new(),
        }
    }

    /// The finger.
    pub fn finger(&self) -> &F {
        &self.finger
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Other settings, from the next closing on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Nominal efficiency of the drivetrain, 0 to 1, from the next closing on; anything else is ignored.
    pub fn set_efficiency(&mut self, efficiency: f32) {
        if efficiency > 0.0 && efficiency <= 1.0 {
            self.drivetrain.efficiency = efficiency;
        }
    }

    /// The friction record.
    pub fn friction(&self) -> Option<&Friction> {
        self.friction.as_ref()
    }

    /// Takes a record that was kept. One that is not valid is ignored, and said so by `false`.
    pub fn set_friction(&mut self, friction: Friction) -> bool {
        let valid = friction.is_valid();
        if valid {
            self.friction = Some(friction);
        }
        valid
    }

    /// What is known of torque factor and cable.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Takes a calibration that was kept, or the nominal one. One that is not valid is ignored, and said so by `false`.
    pub fn set_calibration(&mut self, calibration: Calibration) -> bool {
        let valid = calibration.is_valid();
        if valid {
            self.calibration = calibration;
        }
        valid
    }

    /// What the samples from now on are good for. A contact in hand is judged with what is there; the same directive
    /// again starts anew.
    pub fn direct(&mut self, directive: Directive) {
        if self.directive == Directive::RecordFriction
            && directive != Directive::RecordFriction
            && let Work::Recording(mut recorder) = mem::replace(&mut self.work, Work::Nothing)
        {
            self.end_recording(&mut recorder);
        }
        if directive == Directive::Rest && matches!(self.work, Work::Contact(_)) {
            // The last word is still to be said, under the old directive; nothing but that comes after.
            self.end_motion();
            return;
        }
        self.directive = directive;
        self.detector = None;
        self.done = false;
        self.stale_told = false;
        self.history.clear();
        self.work = match directive {
            Directive::RecordFriction => Work::Recording(Recorder::new(self.travel_counts())),
            _ => Work::Nothing,
        };
    }

    /// Takes a sample; tells at most one thing. Typically some hundred instructions; every block of a contact, and
    /// after its end for some tens of samples, one step of a fit.
    // A symbol of its own, so that its instructions can be counted on the chip.
    #[inline(never)]
    pub fn update(&mut self, sample: &Sample) -> Option<Event> {
        match self.gate.push(sample, &self.drivetrain, &self.settings) {
            Step::Pending => {}
            Step::Block(block) => self.take(&block),
            Step::Ended => self.end_run(),
        }
        self.conclude();
        self.events.pop_front()
    }

    fn travel_counts(&self) -> i32 {
        // Saturates where nonsense was set.
        (self.settings.travel_rad / self.drivetrain.rad_per_count) as i32
    }

    fn tell(&mut self, event: Event) {
        // Four wait at most: a touch, a location, staleness and a calibration. A fifth would repeat one of them.
        let _ = self.events.push_back(event);
    }

    fn take(&mut self, block: &Block) {
        match self.directive {
            Directive::Rest => {}
            Directive::RecordFriction => {
                if let Work::Recording(recorder) = &mut self.work {
                    recorder.push(block);
                }
            }
            // What comes after the finger has opened is another closing.
            _ if block.drive != Drive::Closing => self.done = false,
            _ if self.done => {}
            _ => {
                let past = self.past(block);
                match (&self.work, past) {
                    (Work::Contact(touching), Some(past)) if touching.last_steps.is_none() => {
                        self.with_contact(|sensor, touching| sensor.press(touching, &past));
                    }
                    (Work::Contact(_), _) | (_, None) => {}
                    (_, Some(past)) => self.search(block, past),
                }
            }
        }
    }

    /// Does something with the contact in hand, which lies on the stack meanwhile: not inlined, so that it does not lie there
    /// for the other users of the caller's frame too.
    #[inline(never)]
    fn with_contact(&mut self, act: impl FnOnce(&mut Self, &mut Touching<H::Reading>)) {
        match mem::replace(&mut self.work, Work::Nothing) {
            Work::Contact(mut touching) => {
                act(self, &mut touching);
                self.work = Work::Contact(touching);
            }
            other => self.work = other,
        }
    }

    fn end_run(&mut self) {
        if let Work::Recording(recorder) = &mut self.work {
            recorder.end_run();
        }
        self.detector = None;
        self.history.clear();
        self.end_motion();
    }

    fn end_motion(&mut self) {
        if let Work::Contact(touching) = &mut self.work {
            touching.end();
        }
    }

    fn end_recording(&mut self, recorder: &mut Recorder) {
        let recorded = recorder.finish();
        let coverage = recorder.coverage();
        let told = recorded.as_ref().and_then(|friction| {
            Some(Event::FrictionRecorded {
                closing_nm: friction.closing.mean_nm()?,
                opening_nm: friction.opening.mean_nm()?,
                residual_nm: friction.residual_nm(),
                coverage,
            })
        });
        match (recorded, told) {
            (Some(friction), Some(event)) if coverage >= COVERAGE => {
                self.friction = Some(friction);
                self.tell(event);
            }
            _ => self.tell(Event::FrictionNotRecorded { coverage }),
        }
    }

    /// A block with the residual of the record.
    fn past(&self, block: &Block) -> Option<Past<H::Reading>> {
        let friction = self.friction.as_ref()?;
        let (torque_nm, beyond_counts) = if self.directive == Directive::CalibrateCable
            || matches!(self.work, Work::Contact(_))
        {
            let period_counts = self.drivetrain.counts_per_worm_turn;
            friction.beyond(block.drive, block.counts, period_counts)?
        } else {
            (friction.at(block.drive, block.counts)?, 0.0)
        };
        Some(Past {
            time_us: block.time_us,
            counts: block.counts,
            width_counts: block.width_counts,
            residual_nm: block.drive_torque_nm - torque_nm,
            beyond_counts,
            inertia_nm: block.inertia_nm,
            overspeed: block.overspeed,
            reading: self.reading,
        })
        .filter(|past| past.residual_nm.is_finite())
    }

    /// Nothing felt yet.
    fn search(&mut self, block: &Block, past: Past<H::Reading>) {
        let residual_nm = past.residual_nm;
        let Some(friction) = &self.friction else {
            return;
        };
        let (Some(noise), Some(mean_nm)) = (
            friction.noise_nm2_counts(block.drive),
            friction.closing.mean_nm(),
        ) else {
            return;
        };
        let theta_a_rad = self.drivetrain.closing_rad(block.counts);
        if let Some(free) = self.free(theta_a_rad) {
            self.posture = free.configuration;
        }
        if self.history.is_full() {
            self.history.pop_front();
        }
        let _ = self.history.push_back(past);
        let settings = &self.settings;
        let detector = self.detector.get_or_insert_with(|| {
            let blocks = friction.travel_counts as f32 / block.width_counts.max(1) as f32;
            Detector::new(
                detector::threshold(settings.false_alarms_per_closing, blocks),
                mean_nm,
                noise,
            )
        });
        let finding = detector.push(residual_nm, block.width_counts);
        let level = detector.level();
        match finding {
            Finding::Free => {}
            Finding::Stale { misfit_nm } => {
                if !self.stale_told && self.directive != Directive::CalibrateCable {
                    self.stale_told = true;
                    self.tell(Event::FrictionStale { misfit_nm });
                }
            }
            // Beyond the record, on the way to the stop, friction may well be less.
            Finding::Softer { .. } if self.directive == Directive::CalibrateCable => {
                self.detector = None;
            }
            Finding::Softer { .. } => {
                self.done = true;
                self.tell_unusual(theta_a_rad, residual_nm - level.0);
            }
            Finding::Contact { since } => self.touch(block, since, level, noise),
        }
    }

    fn tell_unusual(&mut self, theta_a_rad: f32, excess_nm: f32) {
        let rest_rad = self.finger.input_angle_rad(&self.finger.rest());
        let expected = self
            .free(theta_a_rad)
            .and_then(|free| self.finger.expected_k_a(&free))
            .unwrap_or(0.0);
        let way_rad = theta_a_rad - rest_rad;
        let excess = self.drivetrain.efficiency * excess_nm / way_rad;
        self.tell(Event::Unusual {
            k_a_nm_per_rad: if excess.is_finite() {
                expected + excess
            } else {
                expected
            },
            k_a_free_nm_per_rad: expected,
        });
    }

    /// Posture and torque of the free finger at a measured angle.
    fn free(&self, measured_rad: f32) -> Option<Free<F::Configuration>> {
        let creep = self.drivetrain.creep[0];
        fit::free_behind_cable(
            &self.finger,
            measured_rad,
            &self.calibration,
            creep,
            &self.posture,
        )
    }

    /// A contact is decided.
    #[inline(never)]
    fn touch(&mut self, block: &Block, since: usize, level: (f32, f32), noise: f32) {
        let first = self.history.len().saturating_sub(since);
        let Some(onset) = self.history.iter().nth(first).copied() else {
            return;
        };
        let mut touching = Touching {
            curve: Curve::new(onset.counts, onset.width_counts),
            locator: Locator::default(),
            level_nm: level.0,
            level_sigma_nm: sqrt(level.1.max(0.0)),
            noise_nm2_counts: noise,
            unevenness_nm: self
                .friction
                .as_ref()
                .and_then(|friction| friction.unevenness_nm(block.drive))
                .unwrap_or(0.0),
            onset_rad: self.drivetrain.closing_rad(onset.counts),
            reading: onset.reading,
            torque_nm: 0.0,
            late_nm: 0.0,
            late_us: onset.time_us,
            waiting: onset,
            asked: (0.0, f32::INFINITY),
            reported: Reported::Nothing,
            good: None,
            worse: 0,
            last_steps: None,
            pause: 0,
            settled: false,
        };
        for past in self.history.iter().skip(first + 1) {
            self.add(&mut touching, past);
        }
        self.history.clear();
        self.detector = None;
        self.tell(Event::Touch {
            time_us: block.time_us,
            theta_a_rad: touching.onset_rad,
            torque_nm: touching.torque_nm,
        });
        self.work = Work::Contact(touching);
    }

    /// Adds a block to the curve: the one before it, that is. A block's own acceleration is half that since the block
    /// before and half that to the one after.
    fn add(&self, touching: &mut Touching<H::Reading>, next: &Past<H::Reading>) {
        let mut past = core::mem::replace(&mut touching.waiting, *next);
        past.residual_nm += 0.5 * (past.inertia_nm - next.inertia_nm);
        let drivetrain = &self.drivetrain;
        let efficiency =
            drivetrain.efficiency * (1.0 + drivetrain.efficiency_per_speed * past.overspeed);
        let free_nm = self
            .free(drivetrain.closing_rad(past.counts))
            .map_or(0.0, |free| free.torque_nm);
        let excess_nm = efficiency * (past.residual_nm - touching.level_nm);
        let torque_nm = excess_nm + free_nm / self.calibration.torque_factor;
        let elapsed_s = past.time_us.saturating_sub(touching.late_us) as f32 * 1e-6;
        touching.late_us = past.time_us;
        touching.late_nm +=
            (elapsed_s / drivetrain.creep_s).min(1.0) * (excess_nm - touching.late_nm);
        let mut noise = touching.noise_nm2_counts;
        if past.beyond_counts > 0.0 {
            // Wrong for a good part of a period in the same direction.
            let unevenness_nm = UNSURE_BEYOND * touching.unevenness_nm;
            noise += unevenness_nm * unevenness_nm * 0.25 * drivetrain.counts_per_worm_turn as f32;
        }
        let variance = efficiency * efficiency * noise / past.width_counts.max(1) as f32;
        touching.curve.push(
            past.counts,
            Point {
                torque_nm,
                late_nm: touching.late_nm,
                inertia_nm: 0.5 * efficiency * (past.inertia_nm + next.inertia_nm),
                variance_nm2: variance,
                ..Point::default()
            },
        );
        touching.torque_nm = excess_nm;
    }

    /// Whether the torque has fallen: the finger slid off, or the object gave way. What comes after is another contact.
    fn is_lost(&self, touching: &Touching<H::Reading>, past: &Past<H::Reading>) -> bool {
        let efficiency = self.drivetrain.efficiency;
        let torque_nm = efficiency * (past.residual_nm - touching.level_nm);
        let block = efficiency * sqrt(touching.noise_nm2_counts / past.width_counts.max(1) as f32);
        touching.torque_nm - torque_nm > LOST_SHARE * touching.torque_nm + LOST_SIGMAS * block
    }

    /// The contact goes on.
    fn press(&mut self, touching: &mut Touching<H::Reading>, past: &Past<H::Reading>) {
        if self.is_lost(touching, past) {
            touching.end();
            return;
        }
        self.add(touching, past);
        if self.directive == Directive::CalibrateCable || touching.settled {
            return;
        }
        let judged = self.refine(touching);
        if judged && self.directive == Directive::Watch {
            self.report(touching, false);
        }
    }

    fn prior(&self, touching: &Touching<H::Reading>) -> Prior {
        let settings = &self.settings;
        Prior {
            place: match self.directive {
                Directive::Calibrate { phalanx, k_m } => Place::Known {
                    phalanx,
                    k_m,
                    sigma_m: PIN_SIGMA_M,
                },
                _ => Place::Anywhere,
            },
            radius_m: (settings.radius_m, settings.radius_sigma_m),
            offset_sigma_nm: self.drivetrain.efficiency * touching.level_sigma_nm,
            onset_rad: (touching.onset_rad, ONSET_SIGMA_RAD),
            calibration: self.calibration,
            creep: self.drivetrain.creep,
            inertia_share: self.drivetrain.inertia_share,
        }
    }

    /// One step of the locator; true at the end of a round.
    fn refine(&self, touching: &mut Touching<H::Reading>) -> bool {
        let prior = self.prior(touching);
        let free_nm = self
            .free(touching.onset_rad)
            .map_or(0.0, |free| free.torque_nm)
            / self.calibration.torque_factor;
        let offset_variance = prior.offset_sigma_nm * prior.offset_sigma_nm;
        let points: Vec<Point, { curve::BINS }> = touching
            .curve
            .points()
            .filter(|p| {
                let clear = p.torque_nm - free_nm;
                let variance = p.variance_nm2 + offset_variance;
                clear > 0.0 && clear * clear > CLEAR_SIGMAS * CLEAR_SIGMAS * variance
            })
            .copied()
            .collect();
        let data = Data {
            points: &points,
            origin_rad: self.drivetrain.closing_rad(touching.curve.origin_counts()),
            drivetrain: &self.drivetrain,
        };
        touching
            .locator
            .refine(&self.finger, &data, &prior, &self.posture)
    }

    fn verdict(&self, touching: &Touching<H::Reading>) -> Verdict {
        let change = H::change_rad(touching.reading, self.reading);
        touching.locator.verdict(|estimate| {
            change.map_or(0.0, |measured| {
                let [_, expected, _] = estimate.end.joints_rad;
                locator::ln_likelihood(measured, expected, Hall::SIGMA_RAD)
            })
        })
    }

    /// Says what is new at the end of a round; `last` is the last word.
    fn report(&mut self, touching: &mut Touching<H::Reading>, last: bool) {
        if touching.settled {
            return;
        }
        let misfit = touching.locator.misfit();
        let mut verdict = self.verdict(touching);
        let mut over = last || touching.torque_nm >= 0.97 * self.settings.torque_limit_nm;
        let was = touching.good.map_or(misfit, |(_, was)| was);
        if misfit > (WORSE * was.max(1.0)).max(GOOD) {
            touching.worse = touching.worse.saturating_add(1);
        } else {
            touching.worse = 0;
        }
        match touching.good {
            // The curve has left the path that explained it well: a second contact, a slip. What was known before holds. A
            // round or two may just be a fit on its way.
            Some((good, _)) if touching.worse >= WORSE_ROUNDS || verdict == Verdict::Undecided => {
                verdict = good;
                over |= touching.worse >= WORSE_ROUNDS;
            }
            _ if misfit <= GOOD && verdict != Verdict::Undecided => {
                touching.good = Some((verdict, misfit));
            }
            _ => {}
        }
        if touching.worse > 0 && !over {
            return;
        }
        match verdict {
            Verdict::At {
                phalanx,
                estimate,
                spread,
            } => {
                let sigma_m = estimate.k_sigma_m * sqrt(spread);
                let length = self.finger.phalanx_length_m(phalanx).unwrap_or(0.0);
                let help = self.more_torque_helps(touching, sigma_m) || sigma_m > SHARP * length;
                let settled = over || sigma_m <= self.settings.wanted_sigma_m || !help;
                if sigma_m >= VAGUE * length {
                    if over {
                        self.tell_nowhere(touching, NotLocated::TooFewSamples);
                    }
                    return;
                }
                let news = match touching.reported {
                    Reported::Located {
                        phalanx: before,
                        k_m,
                        sigma_m: was,
                    } => {
                        before != phalanx
                            || sigma_m < SHARPER * was
                            || (estimate.k_m - k_m).abs() > 2.0 * was
                    }
                    _ => true,
                };
                touching.settled = settled;
                if news || settled {
                    self.tell_located(touching, phalanx, &estimate, spread);
                }
            }
            Verdict::Either {
                phalanx,
                estimate,
                spread,
            } => {
                touching.settled = over;
                if touching.reported != Reported::Ambiguous || over {
                    self.tell_ambiguous(touching, phalanx, &estimate, spread);
                }
            }
            Verdict::Nowhere(why) => {
                // A proximal contact is not told from one near the joint before the torque has shown the difference.
                let sure = touching.torque_nm >= 0.3 * self.settings.torque_limit_nm;
                if over || (sure && why == NotLocated::Proximal) {
                    self.tell_nowhere(touching, why);
                }
            }
            Verdict::Undecided if last => self.tell_nowhere(touching, NotLocated::TooFewSamples),
            Verdict::Undecided => {}
        }
    }

    fn tell_nowhere(&mut self, touching: &mut Touching<H::Reading>, why: NotLocated) {
        touching.settled = true;
        self.tell(Event::NotLocated {
            why,
            torque_nm: touching.torque_nm,
        });
    }

    /// Whether the deviation still shrinks as the torque grows.
    fn more_torque_helps(&self, touching: &mut Touching<H::Reading>, sigma_m: f32) -> bool {
        let (torque_nm, was_m) = touching.asked;
        if touching.torque_nm < 1.25 * torque_nm {
            return true;
        }
        touching.asked = (touching.torque_nm, sigma_m);
        // Early deviations say little: the fit may not stand still yet.
        touching.torque_nm < 0.4 * self.settings.torque_limit_nm || sigma_m < NO_HELP * was_m
    }

    fn tell_located(
        &mut self,
        touching: &mut Touching<H::Reading>,
        phalanx: u8,
        estimate: &Estimate,
        spread: f32,
    ) {
        let settled = touching.settled;
        let swell = sqrt(spread);
        let sigma_m = estimate.k_sigma_m * swell;
        let radius_sigma_m = estimate.radius_sigma_m * swell;
        // No better than the prior: the curve does not tell.
        let tells_radius = radius_sigma_m < 0.7 * self.settings.radius_sigma_m;
        let k_c = self
            .free(estimate.onset_rad)
            .and_then(|free| {
                self.finger.contact_compliance(
                    &free.configuration,
                    free.torque_nm,
                    phalanx,
                    estimate.k_m,
                )
            })
            .map_or(f32::INFINITY, |compliance| 1.0 / compliance);
        touching.reported = Reported::Located {
            phalanx,
            k_m: estimate.k_m,
            sigma_m,
        };
        self.tell(Event::Located {
            phalanx,
            k_m: estimate.k_m,
            sigma_m,
            k_c_nm_per_rad: k_c,
            force_n: estimate.end.force_n,
            radius_m: if tells_radius {
                estimate.radius_m
            } else {
                f32::NAN
            },
            radius_sigma_m: if tells_radius {
                radius_sigma_m
            } else {
                f32::NAN
            },
            settled,
        });
    }

    fn tell_ambiguous(
        &mut self,
        touching: &mut Touching<H::Reading>,
        phalanx: [u8; 2],
        estimate: &[Estimate; 2],
        spread: f32,
    ) {
        let settled = touching.settled;
        touching.reported = Reported::Ambiguous;
        self.tell(Event::Ambiguous {
            phalanx,
            k_m: estimate.map(|e| e.k_m),
            sigma_m: estimate.map(|e| e.k_sigma_m * sqrt(spread)),
            settled,
        });
    }

    /// After the motion: the fits to their minimum, then the last word.
    fn conclude(&mut self) {
        let Work::Contact(touching) = &mut self.work else {
            return;
        };
        let Some(steps) = touching.last_steps else {
            return;
        };
        if self.directive != Directive::CalibrateCable
            && !touching.settled
            && steps > 0
            && !(steps < LAST_STEPS && touching.locator.has_converged())
        {
            if touching.pause > 0 {
                touching.pause -= 1;
                return;
            }
            touching.pause = SAMPLES_PER_LAST_STEP - 1;
            touching.last_steps = Some(steps - 1);
            self.with_contact(|sensor, touching| {
                sensor.refine(touching);
            });
            return;
        }
        self.done = true;
        self.with_contact(|sensor, touching| match sensor.directive {
            Directive::CalibrateCable => {
                let learned = sensor.learn_from_press(touching);
                sensor.tell_calibration(learned);
            }
            Directive::Calibrate { .. } => {
                let learned = sensor.learn_from_contact(touching);
                sensor.tell_calibration(learned);
            }
            _ if touching.settled => {}
            _ => sensor.report(touching, true),
        });
        self.work = Work::Nothing;
    }

    fn tell_calibration(&mut self, learned: Result<Calibration, Refusal>) {
        match learned {
            Ok(calibration) => {
                self.calibration = calibration;
                self.tell(Event::Calibrated { calibration });
            }
            Err(why) => self.tell(Event::CalibrationRefused { why }),
        }
    }

    fn learn_from_contact(&self, touching: &Touching<H::Reading>) -> Result<Calibration, Refusal> {
        let Directive::Calibrate { phalanx, k_m } = self.directive else {
            return Err(Refusal::NoSuchPlace);
        };
        let length = self
            .finger
            .phalanx_length_m(phalanx)
            .ok_or(Refusal::NoSuchPlace)?;
        if !(phalanx > 1 && k_m > 0.0 && k_m <= length) {
            return Err(Refusal::NoSuchPlace);
        }
        let hypothesis = touching
            .locator
            .hypotheses()
            .first()
            .ok_or(Refusal::TooFewSamples)?;
        let estimate = hypothesis.estimate().ok_or(Refusal::Misfit)?;
        if estimate.reached < LEAST_POINTS {
            return Err(Refusal::TooFewSamples);
        }
        let misfit = estimate.chi_square / (estimate.reached as f32 - 2.0).max(1.0);
        let found = hypothesis
            .learned(&self.prior(touching))
            .ok_or(Refusal::Misfit)?;
        self.calibration.with_contact(&found, misfit)
    }

    fn learn_from_press(&self, touching: &Touching<H::Reading>) -> Result<Calibration, Refusal> {
        let top_nm = touching
            .curve
            .last()
            .ok_or(Refusal::TooFewSamples)?
            .torque_nm;
        // The foot of the curve is where gears and cable settle.
        let slope = curve::slope(
            touching.curve.points(),
            0.2 * top_nm,
            self.drivetrain.creep[0],
        )
        .filter(|slope| slope.points >= LEAST_POINTS as u16)
        .ok_or(Refusal::TooFewSamples)?;
        let rad_per_nm = slope.counts_per_nm * self.drivetrain.rad_per_count;
        // Friction beyond the record, where the stop is, is continued; its error may tilt the line.
        let unevenness_nm = UNSURE_BEYOND * self.drivetrain.efficiency * touching.unevenness_nm;
        let share = unevenness_nm / top_nm;
        let noise = slope.sigma_counts_per_nm * self.drivetrain.rad_per_count;
        let sigma = sqrt(
            noise * noise
                + rad_per_nm * rad_per_nm * (share * share + PRESS_SHARE * PRESS_SHARE)
                + STOP_YIELD_RAD_PER_NM * STOP_YIELD_RAD_PER_NM,
        );
        self.calibration.with_press(rad_per_nm, sigma)
    }
}

impl<F: Mechanics> Sensor<F, Hall> {
    /// Takes a reading of theta_2, radian; it belongs to the samples that follow.
    pub fn set_joint(&mut self, theta_2_rad: f32) {
        self.reading = Some(theta_2_rad).filter(|angle| angle.is_finite());
    }
}
