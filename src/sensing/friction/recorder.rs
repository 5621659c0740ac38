//! Fills a record from free motion.

use super::Friction;
use super::statistics::{Node, Statistics};
use super::track::BINS;
use crate::numeric::Bounded;
use crate::sensing::Drive;
use crate::sensing::block::Block;

/// Blocks held back by the recorder.
const HELD: usize = 2;

/// Mean over a stretch about as long as a bin.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    drive: Drive,
    index: usize,
    sum_counts: f32,
    sum_nm: f32,
    blocks: u16,
    way_counts: f32,
}

impl Stretch {
    fn node(&self) -> Node {
        let blocks = f32::from(self.blocks.max(1));
        Node {
            counts: self.sum_counts / blocks,
            torque_nm: self.sum_nm / blocks,
            way_counts: self.way_counts,
        }
    }
}

/// Fills a record from free motion.
#[derive(Clone, Debug)]
pub struct Recorder {
    friction: Friction,
    stretch: Option<Stretch>,
    /// Blocks held back: those in which the motion came to its end are not free motion at a steady speed.
    held: [Option<Block>; HELD],
    /// The two stretches before, the last one first.
    nodes: [Option<Node>; 2],
    closing: Statistics,
    opening: Statistics,
}

impl Recorder {
    /// Starts a new record over a travel.
    pub fn new(travel_counts: i32) -> Self {
        Self {
            friction: Friction::empty(travel_counts),
            stretch: None,
            held: const { [None; HELD] },
            nodes: const { [None; 2] },
            closing: Statistics::default(),
            opening: Statistics::default(),
        }
    }

    /// Takes a block of free motion. One outside the travel is left out, and so are the last two of a run.
    pub fn push(&mut self, block: &Block) {
        let [first, second] = self.held;
        self.held = [second, Some(*block)];
        if let Some(block) = first {
            self.take(&block);
        }
    }

    fn take(&mut self, block: &Block) {
        let Some(index) = self.friction.index(block.counts) else {
            self.break_off();
            return;
        };
        if self
            .stretch
            .as_ref()
            .is_none_or(|stretch| stretch.index != index)
        {
            self.end_stretch();
        }
        let stretch = self.stretch.get_or_insert(Stretch {
            drive: block.drive,
            index,
            sum_counts: 0.0,
            sum_nm: 0.0,
            blocks: 0,
            way_counts: 0.0,
        });
        stretch.sum_counts += block.counts as f32;
        stretch.sum_nm += block.drive_torque_nm;
        stretch.blocks = stretch.blocks.saturating_add(1);
        stretch.way_counts += block.width_counts as f32;
    }

    /// The motion ended or turned round.
    pub fn end_run(&mut self) {
        self.held = const { [None; HELD] };
        self.break_off();
    }

    /// What comes next does not join on to what was.
    fn break_off(&mut self) {
        self.end_stretch();
        self.nodes = const { [None; 2] };
    }

    /// Fills the bins whose centres lie between this stretch and the one before.
    fn end_stretch(&mut self) {
        let Some(stretch) = self.stretch.take() else {
            return;
        };
        let node = stretch.node();
        if !node.torque_nm.is_finite() {
            return;
        }
        let bin_counts = self.friction.bin_counts();
        let (track, statistics) = match stretch.drive {
            Drive::Closing => (&mut self.friction.closing, &mut self.closing),
            Drive::Opening => (&mut self.friction.opening, &mut self.opening),
            Drive::Idle => return,
        };
        let [before, first] = self.nodes;
        if let (Some(first), Some(middle)) = (&first, &before) {
            statistics.rough(first, middle, &node);
        }
        if let Some(before) = before {
            let (low, high) = if before.counts < node.counts {
                (before.counts, node.counts)
            } else {
                (node.counts, before.counts)
            };
            let from = (low / bin_counts - 0.5).at_least(0.0) as usize;
            // At most three: stretches are a bin apart, or two where one was left out.
            for index in from..BINS.min(from + 4) {
                let centre = (index as f32 + 0.5) * bin_counts;
                if centre > low && centre <= high {
                    let share = (centre - before.counts) / (node.counts - before.counts);
                    let torque_nm = before.torque_nm + share * (node.torque_nm - before.torque_nm);
                    if let Some(difference) = track.fill(index, torque_nm) {
                        statistics.repeat(difference);
                    }
                }
            }
        }
        self.nodes = [Some(node), before];
    }

    /// The record so far; None while either direction lacks the bins for its statistics.
    pub fn finish(&mut self) -> Option<&Friction> {
        self.end_run();
        let friction = &mut self.friction;
        let bin_counts = friction.bin_counts();
        friction.closing.noise_nm2_counts = self.closing.noise_nm2_counts(bin_counts)?;
        friction.opening.noise_nm2_counts = self.opening.noise_nm2_counts(bin_counts)?;
        Some(friction)
    }

    /// Share of the travel that has been covered both ways, 0 to 1.
    pub fn coverage(&self) -> f32 {
        let Friction {
            closing, opening, ..
        } = &self.friction;
        closing.coverage().at_most(opening.coverage())
    }
}
