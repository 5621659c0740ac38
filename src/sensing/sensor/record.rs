//! Records free motion: on demand, and from the free part of every closing since.

use super::search::CorrectedBlock;
use super::state::SensorState;
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::numeric::Bounded;
use crate::sensing::block::Block;
use crate::sensing::detector::Onset;
use crate::sensing::friction::{Assessment, Friction, Pass};
use crate::sensing::location::SeriesElement;
use crate::sensing::{Drive, Event};

/// Share of the travel that a recording must cover.
const COVERAGE: f32 = 0.6;
/// Largest angle from the opening stop at which a recording may begin, radian (chosen: three times what a closing takes to settle). No
/// contact is felt before the record begins.
const BEGUN_RAD: f32 = 0.25;
/// Samples between two steps of an assessment, so that steps leave time for everything else.
const SAMPLES_PER_STEP: u8 = 4;
/// Blocks before a contact's onset that do not count as free motion.
const MARGIN_BLOCKS: f32 = 3.0;

/// Learns friction from free motion.
#[derive(Clone, Debug, Default)]
pub(super) struct Learning {
    /// The current run, or the one that has just ended.
    pass: Option<Pass>,
    /// Whether the run of `pass` has ended.
    ended: bool,
    /// Assessment of an earlier pass.
    assessment: Option<Assessment>,
    /// Samples until its next step.
    pause: u8,
    /// The record that is being made.
    draft: Option<Friction>,
    /// Whether the record is to be handed over at the end of the assessment.
    wanted: bool,
}

impl Learning {
    /// Begins a new record.
    // Not inlined: the record is written directly to its place.
    #[inline(never)]
    pub(super) fn begin(&mut self, empty: Friction) {
        *self = Self {
            draft: Some(empty),
            ..Self::default()
        };
    }

    /// A block of the motion that is to be recorded.
    pub(super) fn record(&mut self, block: &Block) {
        let Some(draft) = &self.draft else {
            return;
        };
        let known_nm = match block.drive {
            Drive::Closing => draft
                .at(block.counts)
                .map_or(0.0, |recorded| recorded.torque_nm),
            _ => 0.0,
        };
        collect(
            &mut self.pass,
            &mut self.ended,
            draft,
            block.counts,
            block,
            known_nm,
        );
    }

    /// A block of a closing without a contact so far.
    pub(super) fn watch<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &SensorState<F, H, X>,
        block: &Block,
        corrected: &CorrectedBlock<H::Reading>,
    ) {
        let (Some(friction), Some(shift_counts)) = (&state.friction, state.shift_counts) else {
            return;
        };
        let counts = block.counts.wrapping_add(shift_counts);
        if corrected.beyond_counts == 0.0 {
            let known_nm = block.drive_torque_nm - corrected.residual_nm;
            collect(
                &mut self.pass,
                &mut self.ended,
                friction,
                counts,
                block,
                known_nm,
            );
        }
    }

    /// Drops the blocks after an onset: they were no free motion.
    pub(super) fn cut<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &SensorState<F, H, X>,
        onset: &Onset,
    ) {
        let margin = MARGIN_BLOCKS * state.drivetrain.counts_per_turn as f32;
        let counts = onset.counts - margin.at_least(2.0 * onset.sigma_counts);
        let shift_counts = state.shift_counts.unwrap_or(0);
        if let (Some(pass), Some(friction)) = (&mut self.pass, &state.friction) {
            pass.cut(friction, (counts as i32).wrapping_add(shift_counts));
        }
    }

    /// Drops the current motion.
    pub(super) fn forget(&mut self) {
        self.pass = None;
    }

    /// The motion ended or turned round.
    pub(super) fn end_run<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &SensorState<F, H, X>,
    ) {
        self.ended = true;
        if self.draft.is_some() {
            self.assess(state);
        }
    }

    /// Begins to assess the run that ended.
    #[inline(never)]
    fn assess<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &SensorState<F, H, X>,
    ) {
        self.ended = false;
        let record = self.draft.as_mut();
        if let (Some(pass), Some(record)) = (
            self.pass.take(),
            record.as_deref().or(state.friction.as_ref()),
        ) {
            self.assessment = Assessment::new(pass, record);
            self.pause = SAMPLES_PER_STEP;
        }
        if let (Some(assessment), Some(draft)) = (&self.assessment, record) {
            assessment.prepare(draft);
        }
    }

    /// Ends a recording.
    pub(super) fn end_recording<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &mut SensorState<F, H, X>,
    ) {
        if self.draft.is_none() || self.wanted {
            return;
        }
        if self.pass.is_some() && self.assessment.is_none() {
            self.assess(state);
        }
        self.pass = None;
        self.wanted = true;
        if !self.assessment.as_ref().is_some_and(Assessment::is_closing) {
            self.hand_over(state);
        }
    }

    /// Adopts the finished record if it is good enough, and reports the result.
    #[inline(never)]
    fn hand_over<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &mut SensorState<F, H, X>,
    ) {
        self.wanted = false;
        let Some(draft) = self.draft.take() else {
            return;
        };
        let coverage = draft.coverage();
        let begun = draft.at((BEGUN_RAD / draft.rad_per_count) as i32);
        // No torque of an opening: the recording was ended while the finger closed, perhaps by something in its way.
        if coverage >= COVERAGE
            && begun.is_some()
            && draft.opening_nm != 0.0
            && draft.is_valid()
            && let Some(closing_nm) = draft.mean_nm()
        {
            let opening_nm = draft.opening_nm;
            let residual_nm = draft.noise_nm(&state.drivetrain);
            let wander = draft.wander(draft.speed_rad_per_s);
            state.friction = Some(draft);
            state.shift_counts = Some(0);
            state.shift_sigma_counts = 0.0;
            state.emit(Event::FrictionRecorded {
                closing_nm,
                opening_nm,
                residual_nm,
                coverage,
                wander_nm: wander.rms_nm,
                wander_s: wander.time_s,
            });
        } else {
            self.assessment = None;
            state.emit(Event::FrictionNotRecorded { coverage });
        }
    }

    /// Continues the assessment, one step at a time; `busy` while the record is in use.
    pub(super) fn step<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        state: &mut SensorState<F, H, X>,
        busy: bool,
    ) {
        if self.ended && !busy && self.assessment.is_none() {
            self.assess(state);
        }
        let Some(assessment) = &mut self.assessment else {
            return;
        };
        // Of what the assessment of an opening changes a search uses the noise alone, and by the time a search has got through the way
        // that settles, the assessment is over.
        if busy && assessment.is_closing() {
            return;
        }
        if self.pause > 0 {
            self.pause -= 1;
            return;
        }
        self.pause = SAMPLES_PER_STEP - 1;
        let Some(record) = self.draft.as_mut().or(state.friction.as_mut()) else {
            self.assessment = None;
            return;
        };
        if assessment.step(record) {
            assessment.update(record);
            self.assessment = None;
            if self.wanted {
                self.hand_over(state);
            }
        }
    }
}

/// Adds a block to the pass of its run.
fn collect(
    pass: &mut Option<Pass>,
    ended: &mut bool,
    record: &Friction,
    counts: i32,
    block: &Block,
    known_nm: f32,
) {
    if *ended
        || pass
            .as_ref()
            .is_some_and(|pass| pass.drive() != block.drive)
    {
        *pass = None;
        *ended = false;
    }
    pass.get_or_insert_with(|| Pass::new(block.drive))
        .push(record, counts, block, known_nm);
}
