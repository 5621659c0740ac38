//! Stage of a closing before a contact: runs the detector on the residual torque of each block.

use super::Stage;
use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, exp, sqrt};
use crate::sensing::Event;
use crate::sensing::block::Block;
use crate::sensing::detector::{self, Detector, Finding, Onset, Residual, Test};
use crate::sensing::friction::{Aligned, Alignment, Wander};
use crate::sensing::location::SeriesElement;
use heapless::Deque;

/// Number of blocks kept, so that the curve starts at the onset and not at its detection.
pub(super) const HISTORY: usize = detector::ONSETS;
/// Smallest slope of a contact, as a share of that of the softest contact.
const LEAST_SLOPE: f32 = 0.5;

/// Time in which the finger's swing after a start fades to a third, second: that of the slowest of printed three-phalanx fingers (I, from
/// springs, mass and damping).
const SWING_S: f32 = 2.0 / 3.0;
/// Share of that swing's mean square that counts as white noise of the curve to which a place is fitted (R, chosen). A swing averages out
/// along a curve: with a period of two to five blocks it changes the slope of a line through ten to twenty blocks by 0.01 to 0.9 times the
/// variance that white noise of the same mean square would, a quarter on average.
const SWING_ON_CURVE: f32 = 0.2;
/// Logarithm of the likelihood ratio above which a motion is not learned as free.
const SUSPICIOUS: f32 = 3.0;

/// A block with the recorded friction taken off.
#[derive(Clone, Copy, Debug)]
pub(super) struct CorrectedBlock<R> {
    /// Lower 32 bits of the time, which suffice for differences: a history keeps many blocks.
    pub(super) time_us: u32,
    pub(super) counts: i32,
    pub(super) width_counts: u32,
    pub(super) residual_nm: f32,
    /// Torque that the free finger would take there, newton metre: kept, because a finger with springs takes long to tell it, and a
    /// contact begins with all blocks of its history.
    pub(super) free_nm: f32,
    /// Variance of its white noise on a curve, newton metre squared.
    pub(super) variance_nm2: f32,
    /// Distance beyond the friction record, counts.
    pub(super) beyond_counts: f32,
    /// As in [`Block`].
    pub(super) inertia_nm: f32,
    pub(super) overspeed: f32,
    /// In the middle of the block, as its other values.
    pub(super) reading: R,
}

/// How near the search for a contact is to a decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspicion {
    /// Torque of the motor that friction leaves unexplained in the last block, newton metre.
    pub residual_nm: f32,
    /// Logarithm of the likelihood ratio of the likeliest contact; it may be negative.
    pub ln_ratio: f32,
    /// The logarithm beyond which a contact is reported.
    pub threshold: f32,
}

/// The last blocks of a search.
pub(super) type History<R> = Deque<CorrectedBlock<R>, HISTORY>;

/// State of a search.
#[derive(Clone, Debug)]
pub(super) struct Search<R> {
    pub(super) history: History<R>,
    detector: Option<Detector>,
    /// Whether this closing has already been reported as unusual.
    pub(super) unusual: bool,
    /// In use while a record from before a restart is not aligned.
    alignment: Alignment,
}

impl<R> Default for Search<R> {
    fn default() -> Self {
        Self {
            history: Deque::new(),
            detector: None,
            unusual: false,
            alignment: Alignment::default(),
        }
    }
}

impl<R> Search<R> {
    /// A possible contact that is not decided yet.
    pub(super) fn suspect(&self) -> Option<Onset> {
        let suspect = self.detector.as_ref()?.suspect()?;
        (suspect.ln_ratio > SUSPICIOUS).then_some(suspect)
    }

    /// Last residual of the detector, and how near it is to a decision.
    pub(super) fn suspicion(&self) -> Option<Suspicion> {
        let (ln_ratio, threshold) = self.detector.as_ref()?.evidence();
        Some(Suspicion {
            residual_nm: self.history.back()?.residual_nm,
            ln_ratio,
            threshold,
        })
    }

    /// Makes a new search the current stage.
    // Not inlined, so that it does not enlarge the stack frame from which everything else is called.
    #[inline(never)]
    pub(super) fn begin<F: Mechanics, H: JointSensor<Reading = R>, X: SeriesElement>(
        stage: &mut Stage<F, H, X>,
    ) {
        *stage = Stage::Searching(Self::default());
    }
}

/// What a block means for the search.
#[derive(Clone, Copy, Debug)]
pub(super) enum SearchOutcome {
    Nothing,
    /// The search is over without a contact; the reason has been reported.
    Over,
    Contact(Detection),
}

/// A detected contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detection {
    pub(super) onset: Onset,
    /// Noise of the residual besides its white noise.
    pub(super) wander: Wander,
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// Takes the recorded friction off a block.
    pub(super) fn corrected(&self, block: &Block) -> Option<CorrectedBlock<H::Reading>> {
        let friction = self.friction.as_ref()?;
        let counts = block.counts.wrapping_add(self.shift_counts.unwrap_or(0));
        // The record is extrapolated, because a contact may begin at the very end of the travel.
        let recorded = friction.beyond(counts)?;
        Some(CorrectedBlock {
            time_us: block.time_us as u32,
            counts: block.counts,
            width_counts: block.width_counts,
            residual_nm: block.drive_torque_nm - recorded.torque_nm,
            free_nm: 0.0,
            variance_nm2: friction.white_nm2(block.duration_s)
                + recorded.variance_nm2
                + SWING_ON_CURVE * self.swing_nm2(block),
            beyond_counts: recorded.beyond_counts,
            inertia_nm: block.inertia_nm,
            overspeed: block.overspeed,
            reading: H::middle(self.before, self.reading),
        })
        .filter(|corrected| corrected.residual_nm.is_finite())
    }

    /// The part of a corrected block that the detector needs, with all of the swing in its noise: on single blocks nothing averages out.
    pub(super) fn residual(
        &self,
        block: &Block,
        corrected: &CorrectedBlock<H::Reading>,
    ) -> Residual {
        Residual {
            time_us: block.time_us,
            counts: corrected.counts,
            width_counts: corrected.width_counts,
            torque_nm: corrected.residual_nm,
            variance_nm2: corrected.variance_nm2 + (1.0 - SWING_ON_CURVE) * self.swing_nm2(block),
        }
    }

    /// Mean square of the finger's swing after a start, at the motor, newton metre squared.
    fn swing_nm2(&self, block: &Block) -> f32 {
        let way_rad = block.way_counts as f32 * self.drivetrain.rad_per_count;
        let speed_rad_per_s = self.settings.speed_rad_per_s;
        let swing_nm = self.settings.swing_rms_nm_s_per_rad
            * speed_rad_per_s
            * exp(-way_rad / (SWING_S * speed_rad_per_s));
        swing_nm * swing_nm
    }

    /// Takes a block of a closing without a contact so far.
    pub(super) fn search(
        &mut self,
        search: &mut Search<H::Reading>,
        block: &Block,
        mut corrected: CorrectedBlock<H::Reading>,
    ) -> SearchOutcome {
        let residual = self.residual(block, &corrected);
        let theta_a_rad = self.drivetrain.closing_rad(block.counts);
        if let Some(free) = self.free(theta_a_rad) {
            self.posture = free.configuration;
            corrected.free_nm = free.torque_nm;
        }
        if self.shift_counts.is_none()
            && let Some(friction) = &self.friction
        {
            match search.alignment.push(friction, block, &self.drivetrain) {
                Aligned::Pending => {}
                Aligned::By {
                    counts,
                    sigma_counts,
                } => {
                    self.shift_counts = Some(counts);
                    self.shift_sigma_counts = sigma_counts;
                }
                Aligned::Nowhere { misfit_nm } => {
                    // A contact could not be located without friction: the finger opens, and friction is recorded again.
                    self.emit(Event::FrictionStale { misfit_nm });
                    self.emit(Event::FrictionNotRecorded { coverage: 0.0 });
                    return SearchOutcome::Over;
                }
            }
            return SearchOutcome::Nothing;
        }
        self.last_residual = Some((theta_a_rad, residual.torque_nm));
        if search.history.is_full() {
            search.history.pop_front();
        }
        let _ = search.history.push_back(corrected);
        if search.detector.is_none() {
            self.set_detector(search, block);
        }
        let Some(detector) = &mut search.detector else {
            return SearchOutcome::Nothing;
        };
        let finding = detector.push(&residual);
        match finding {
            Finding::Free => {}
            Finding::Stale { misfit_nm } => {
                if !self.stale_told && !search.unusual && !self.presses_stop() {
                    self.stale_told = true;
                    self.emit(Event::FrictionStale { misfit_nm });
                }
            }
            // Beyond the record, on the way to the stop, friction may well be less.
            Finding::Softer(_) if self.presses_stop() => {
                search.detector = None;
            }
            Finding::Softer(onset) => {
                let fallen_nm = residual.torque_nm - onset.level_nm;
                if !search.unusual
                    && fallen_nm < -self.carried_nm(&corrected)
                    && let Some(k_a) = self.k_a(theta_a_rad, fallen_nm)
                {
                    // The search goes on: what the finger meets from here on must still stop it.
                    search.unusual = true;
                    self.emit_unusual(&k_a);
                }
            }
            Finding::Contact(onset) => {
                let wander = *detector.wander();
                return SearchOutcome::Contact(Detection {
                    onset: self.before_weight(onset, &mut search.history, &corrected),
                    wander,
                });
            }
        }
        SearchOutcome::Nothing
    }

    // Not inlined: the detector is large and should not enlarge the stack frame from which everything else is called.
    #[inline(never)]
    fn set_detector(&self, search: &mut Search<H::Reading>, block: &Block) {
        search.detector = self.detector(block);
    }

    /// A detector for the recorded friction.
    fn detector(&self, block: &Block) -> Option<Detector> {
        let friction = self.friction.as_ref()?;
        let blocks = friction.travel_counts as f32 / block.width_counts.max(1) as f32;
        let way_rad = block.width_counts as f32 * self.drivetrain.rad_per_count;
        let softest = self.softest_contact_nm_per_rad()?;
        // From the finger's torque to the motor's.
        let scale = self.drivetrain.rad_per_count
            / (self.drivetrain.efficiency * self.calibration.torque_factor);
        let least_slope_nm_per_count = LEAST_SLOPE * softest * scale;
        // A spring that loses its hold reduces the stiffness by at most the finger's own.
        let own = (self.free(self.drivetrain.closing_rad(block.counts)))
            .and_then(|free| self.finger.expected_k_a(&free))
            .filter(|own| *own > 0.0)
            .unwrap_or(softest);
        let test = Test {
            threshold: detector::threshold(self.settings.false_contacts_per_thousand, blocks),
            least_slope_nm_per_count,
            least_fall_nm_per_count: LEAST_SLOPE * softest.at_most(own) * scale,
            friction_nm: friction.mean_nm()?,
        };
        let mut wander = friction.wander(way_rad / block.duration_s);
        // An error of the shift leaves a residual that is periodic with the worm and varies about as slowly as the wander.
        let shifted_nm = friction.steepness_nm_per_count() * self.shift_sigma_counts;
        wander.rms_nm = sqrt(wander.rms_nm * wander.rms_nm + shifted_nm * shifted_nm);
        Some(Detector::new(test, wander))
    }

    /// By how much the finger is stiffer with its softest contact, anywhere on the proximal phalanx where a motor turns all
    /// joints, than without, behind the cable, newton metre per radian (docs/MECHANICS.md#contact-stiffness).
    fn softest_contact_nm_per_rad(&self) -> Option<f32> {
        let rest = self.finger.rest();
        let at = &self.posture;
        let cable = if X::FLEXIBLE {
            self.calibration.cable_rad_per_nm
        } else {
            0.0
        };
        let contact = (self.finger.softest_compliance(at, 0.0))
            .or_else(|| self.finger.softest_compliance(&rest, 0.0))?;
        let free = self
            .finger
            .free_compliance(&rest, 0.0)
            .map_or(0.0, |free| 1.0 / (free + cable));
        let excess = 1.0 / (contact + cable) - free;
        (excess > 0.0 && excess.is_finite()).then_some(excess)
    }

    /// Takes a block of a closing whose contact has been decided: the global stiffness at its end is still to be reported.
    pub(super) fn remember(&mut self, corrected: &CorrectedBlock<H::Reading>) {
        if let Some(last) = &mut self.last_residual {
            let theta_a_rad = self.drivetrain.closing_rad(corrected.counts);
            *last = (theta_a_rad, corrected.residual_nm);
        }
    }
}
