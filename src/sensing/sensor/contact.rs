//! A contact: runs the locator a few points at a time, and reports what it finds.

use super::collector::{CurveCollector, CurvePhase};
use super::report::Reported;
use super::search::{CorrectedBlock, Detection};
use super::state::SensorState;
use super::{Sensor, Stage};
use crate::finger::Mechanics;
use crate::joint_sensor::JointSensor;
use crate::sensing::Event;
use crate::sensing::block::Block;
use crate::sensing::location::SeriesElement;
use crate::sensing::locator::Locator;

/// Blocks before the detected onset at which the curve begins: the true onset may be earlier.
const LEAD: usize = 4;
/// Points that a curve cut short keeps at least, or it stays whole: what the locator fits needs some.
const LEAST_POINTS: usize = 6;
/// Updates after the end of the curve from which on no shorter part of it is tried (chosen): with three phalanges rounds on ever shorter
/// parts of the curve can take longer than the finger holds.
const LAST_AFTER: u16 = 4500;

/// A contact under way.
#[derive(Clone, Debug)]
pub(super) struct Contact<F: Mechanics, H: JointSensor, X: SeriesElement> {
    pub(super) collector: CurveCollector<H>,
    pub(super) locator: Locator<F, X>,
    pub(super) reported: Reported,
    due: Due,
    /// Another contact shares the torque by now.
    pub(super) shared: bool,
    /// Updates since the end of the curve; not counted with two phalanges, whose rounds are short.
    ended: u16,
}

/// What the next update does for a contact. Each in an update of its own: a step of a fit and a report together take too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Due {
    Nothing,
    /// The locator has a pass to begin or to continue.
    Pass,
    /// A round is over.
    Verdict,
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> Contact<F, H, X> {
    /// Ends the curve before a position, from which another contact shares the torque. One that has ended already, because the motion
    /// has, is judged anew where that leaves out some of it.
    pub(super) fn cut(&mut self, counts: i32) {
        self.shared = true;
        let is_shorter = self.collector.curve.cut(counts, LEAST_POINTS);
        if is_shorter || self.collector.phase != CurvePhase::Ending {
            self.collector.joint = H::Told::default();
            self.collector.phase = CurvePhase::Growing;
            self.ended = 0;
            self.locator.forget_shares();
            self.end();
        }
    }

    /// Ends the curve: the final rounds follow.
    // Not inlined: called from several places.
    #[inline(never)]
    pub(super) fn end(&mut self) {
        if self.collector.phase != CurvePhase::Ending {
            self.collector.phase = CurvePhase::Ending;
            self.due = Due::Nothing;
            self.locator.stop();
        }
    }
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> Sensor<F, H, X> {
    /// Makes a detected contact the current stage.
    // Not inlined: the curve is built on the stack before it replaces the search, and should not enlarge the caller's frame.
    #[inline(never)]
    pub(super) fn begin_contact(&mut self, block: &Block, detection: &Detection) {
        let Stage::Searching(search) = &self.stage else {
            return;
        };
        let history = &search.history;
        let since = history.len().saturating_sub(detection.onset.since + LEAD);
        let Some(first) = history.get(since) else {
            return;
        };
        let state = &mut self.state;
        let mut collector = state.collector(detection, first);
        for (index, corrected) in history.iter().enumerate() {
            if index < since {
                let point = state.point(&collector, corrected, corrected.inertia_nm);
                collector
                    .curve
                    .push_before(index, since, corrected.counts, point);
            } else if index > since {
                state.collect(&mut collector, corrected);
            }
        }
        state.emit(Event::Touch {
            time_us: block.time_us,
            theta_a_rad: collector.onset_rad[0],
            torque_nm: collector.torque_nm,
        });
        if X::OBJECT_GIVES {
            state.object = None;
        }
        self.stage = Stage::Contact(Contact {
            collector,
            locator: Locator::default(),
            reported: Reported::Nothing,
            due: Due::Nothing,
            shared: false,
            ended: 0,
        });
    }

    /// Called with every sample: evaluates some points of the locator's pass. While the curve grows, one pass follows each block;
    /// after the motion passes follow each other in the final rounds, then the final verdict is reported.
    pub(super) fn judge(&mut self) {
        let state = &mut self.state;
        let Stage::Contact(contact) = &mut self.stage else {
            return;
        };
        let ending = contact.collector.phase == CurvePhase::Ending;
        if ending && F::MOVES_ON {
            contact.ended = contact.ended.saturating_add(1);
        }
        let due = core::mem::replace(&mut contact.due, Due::Nothing);
        if due != Due::Verdict {
            if !ending && due == Due::Nothing {
                return;
            }
            let begun = contact.locator.is_under_way() || state.begin_round(contact, ending);
            if begun {
                if state.step(contact) {
                    contact.due = Due::Verdict;
                } else if contact.locator.is_within_pass() {
                    contact.due = Due::Pass;
                }
                return;
            }
            // Too few points.
            state.give_up(contact);
        } else if !ending {
            if contact.locator.explains() && !contact.locator.leans_on_its_end() {
                state.report(contact, false);
            }
            return;
        } else if state.is_calibrating() {
            let curve = &contact.collector.curve;
            // At the stop nothing else can touch.
            if !state.presses_stop() && !contact.locator.teaches(&state.data(curve, curve.points()))
            {
                return;
            }
            let learned = state.learn(contact);
            state.emit_calibration(learned);
        } else {
            let curve = &contact.collector.curve;
            let is_late = F::MOVES_ON && contact.ended >= LAST_AFTER;
            let data = state.data(curve, curve.points());
            if !contact.locator.stands(&data, is_late) {
                return;
            }
            state.report(contact, true);
        }
        self.done = true;
        self.stage = match contact.reported {
            Reported::Vague(spot) if F::MOVES_ON => Stage::Vague(spot),
            _ => Stage::Idle,
        };
    }
}

impl<F: Mechanics, H: JointSensor, X: SeriesElement> SensorState<F, H, X> {
    /// A block of a closing in contact.
    pub(super) fn press(
        &mut self,
        contact: &mut Contact<F, H, X>,
        mut corrected: CorrectedBlock<H::Reading>,
    ) {
        let collector = &mut contact.collector;
        let fallen = self.has_fallen(collector, &corrected);
        collector.fallen = u8::from(fallen) * collector.fallen.saturating_add(1);
        if collector.phase == CurvePhase::Ending {
            return;
        }
        if fallen {
            contact.end();
            return;
        }
        let free = self.free(self.drivetrain.closing_rad(corrected.counts));
        corrected.free_nm = free.map_or(0.0, |free| free.torque_nm);
        self.collect(&mut contact.collector, &corrected);
        if self.is_calibrating() {
            return;
        }
        if contact.collector.torque_nm >= self.settings.enough_nm() {
            contact.end();
            return;
        }
        if contact.due == Due::Verdict {
            return;
        }
        if !contact.locator.is_under_way() {
            self.begin_round(contact, false);
        } else {
            contact.due = Due::Pass;
        }
    }

    fn begin_round(&self, contact: &mut Contact<F, H, X>, last: bool) -> bool {
        contact.collector.joint_of_round = contact.collector.joint;
        contact.collector.constant = self.torque_constant.shift(&self.drivetrain);
        let prior = self.prior(&contact.collector);
        let Contact {
            collector: CurveCollector { curve, .. },
            locator,
            ..
        } = contact;
        // The last point is still being filled and would change during the round.
        let points = if last {
            curve.points()
        } else {
            curve.complete()
        };
        let data = self.data(curve, points);
        locator.begin(&self.finger, &data, &prior, &self.posture, last)
    }

    /// A step of the locator; true at the end of a round.
    // Not inlined, so that its instructions can be counted on the chip.
    #[inline(never)]
    fn step(&self, contact: &mut Contact<F, H, X>) -> bool {
        let prior = self.prior(&contact.collector);
        let Contact {
            collector, locator, ..
        } = contact;
        let data = self.data(&collector.curve, collector.curve.points());
        locator.step(
            &self.finger,
            &data,
            &prior,
            &self.posture,
            collector.joint_of_round,
        )
    }
}
