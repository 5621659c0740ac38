//! The finger closes and nothing is felt yet: the detector on what the friction record leaves of each block.

use super::Work;
use super::known::Known;
use crate::finger::Mechanics;
use crate::sensing::block::Block;
use crate::sensing::detector::{self, Detector, Finding};
use crate::sensing::friction::{Aligned, Alignment};
use crate::sensing::joint::JointSensor;
use crate::sensing::location::Series;
use crate::sensing::{Drive, Event};
use heapless::Deque;

/// Blocks kept, so that the curve starts at the onset and not at its detection: a quarter of a second.
pub(super) const HISTORY: usize = 32;

/// A block as it is remembered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Past<R> {
    pub(super) time_us: u64,
    pub(super) counts: i32,
    pub(super) width_counts: u32,
    pub(super) residual_nm: f32,
    /// How far beyond the friction record, counts.
    pub(super) beyond_counts: f32,
    /// As in [`Block`].
    pub(super) inertia_nm: f32,
    pub(super) overspeed: f32,
    pub(super) reading: R,
}

/// A search under way.
#[derive(Clone, Debug)]
pub(super) struct Search<R> {
    pub(super) history: Deque<Past<R>, HISTORY>,
    detector: Option<Detector>,
    /// While a record of before a restart waits for it.
    alignment: Alignment,
}

impl<R> Default for Search<R> {
    fn default() -> Self {
        Self {
            history: Deque::new(),
            detector: None,
            alignment: Alignment::default(),
        }
    }
}

impl<R> Search<R> {
    /// Becomes what is in hand.
    // Not inlined: so it does not take room in the frame from which everything else is called.
    #[inline(never)]
    pub(super) fn begin(work: &mut Work<R>) {
        *work = Work::Searching(Self::default());
    }
}

/// What a block of a search showed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Found {
    Nothing,
    /// No contact comes of this closing; why has been told.
    Over,
    Contact(Onset),
}

/// A contact as the detector has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Onset {
    /// Blocks since it began, the last one included.
    pub(super) since: usize,
    /// What the record's level was off by, newton metre of motor torque, and its variance.
    pub(super) level: (f32, f32),
    /// Noise of a residual, as in [`Track`](crate::sensing::friction::Track).
    pub(super) noise_nm2_counts: f32,
}

impl<F: Mechanics, H: JointSensor, X: Series> Known<F, H, X> {
    /// A block with the residual of the record.
    pub(super) fn past(&self, block: &Block, in_contact: bool) -> Option<Past<H::Reading>> {
        let friction = self.friction.as_ref()?;
        // Only a closing is felt.
        let drive = Drive::Closing;
        let counts = block.counts.wrapping_add(self.shift_counts.unwrap_or(0));
        let beyond = in_contact || self.presses_stop();
        let (torque_nm, beyond_counts) = if beyond {
            let period_counts = self.drivetrain.counts_per_worm_turn;
            friction.beyond(drive, counts, period_counts)?
        } else {
            (friction.at(drive, counts)?, 0.0)
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
    pub(super) fn search(
        &mut self,
        search: &mut Search<H::Reading>,
        block: &Block,
        past: Past<H::Reading>,
    ) -> Found {
        let residual_nm = past.residual_nm;
        let theta_a_rad = self.drivetrain.closing_rad(block.counts);
        if let Some(free) = self.free(theta_a_rad) {
            self.posture = free.configuration;
        }
        if self.shift_counts.is_none()
            && let Some(friction) = &self.friction
        {
            match search.alignment.push(friction, block, &self.drivetrain) {
                Aligned::Pending => {}
                Aligned::By(counts) => self.shift_counts = Some(counts),
                Aligned::Nowhere { misfit_nm } => {
                    // Whatever is there, no place could be told of it: the finger opens, and friction is recorded first.
                    self.tell(Event::FrictionStale { misfit_nm });
                    self.tell(Event::FrictionNotRecorded { coverage: 0.0 });
                    return Found::Over;
                }
            }
            return Found::Nothing;
        }
        if search.history.is_full() {
            search.history.pop_front();
        }
        let _ = search.history.push_back(past);
        if search.detector.is_none() {
            search.detector = self.detector(block);
        }
        let Some(detector) = &mut search.detector else {
            return Found::Nothing;
        };
        let finding = detector.push(residual_nm, block.width_counts);
        let level = detector.level();
        match finding {
            Finding::Free => {}
            Finding::Stale { misfit_nm } => {
                if !self.stale_told && !self.presses_stop() {
                    self.stale_told = true;
                    self.tell(Event::FrictionStale { misfit_nm });
                }
            }
            // Beyond the record, on the way to the stop, friction may well be less.
            Finding::Softer { .. } if self.presses_stop() => {
                search.detector = None;
            }
            Finding::Softer { .. } => {
                self.tell_unusual(theta_a_rad, residual_nm - level.0);
                return Found::Over;
            }
            Finding::Contact { since } => {
                return Found::Contact(Onset {
                    since,
                    level,
                    noise_nm2_counts: detector.noise_nm2_counts(),
                });
            }
        }
        Found::Nothing
    }

    /// A detector for the friction recorded.
    #[inline(never)]
    fn detector(&self, block: &Block) -> Option<Detector> {
        let friction = self.friction.as_ref()?;
        let blocks = friction.travel_counts as f32 / block.width_counts.max(1) as f32;
        Some(Detector::new(
            detector::threshold(self.settings.false_alarms_per_closing, blocks),
            friction.closing.mean_nm()?,
            friction.noise_nm2_counts(Drive::Closing)?,
        ))
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
}
