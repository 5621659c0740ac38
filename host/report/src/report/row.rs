//! One candidate's row: cost and error.

use serde::Serialize;

/// Cost of a call on the emulated core, the call itself taken off.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Cost {
    /// Executed instructions, mean over the timed inputs.
    pub instructions_mean: f64,
    /// Executed instructions, most costly input.
    pub instructions_max: u64,
    /// Cycles by the core's table at zero wait states, mean.
    pub cycles_low: f64,
    /// Cycles with an upper estimate of the flash's wait states, mean.
    pub cycles_high: f64,
}

/// Error over all reference rows, and what it is measured in.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Error {
    /// Unit of the errors.
    pub error_unit: &'static str,
    /// Median over random and hard rows.
    pub error_median: f64,
    /// 99th percentile over random and hard rows.
    pub error_p99: f64,
    /// Largest over random and hard rows.
    pub error_max: f64,
    /// Root mean square over random and hard rows.
    pub error_rms: f64,
    /// Largest over the random rows.
    pub random_max: f64,
    /// Largest over the hard rows; null where there are none.
    pub hard_max: Option<f64>,
    /// Answers that are lacking or not finite, over random and hard rows.
    pub nonfinite: usize,
    /// Answers where there is none to give.
    pub spurious: usize,
    /// Answers wanted.
    pub rows: usize,
}

/// A candidate on the chip.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct OnChip {
    /// Cost.
    #[serde(flatten)]
    pub cost: Cost,
    /// Bytes of its function, of every function that this reaches by fixed calls, and of the statics they name.
    pub flash_bytes: u64,
    /// PC and chip computed the same bits.
    pub same_bits: bool,
}

/// A line of the report.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// `candidate`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Task.
    pub task: String,
    /// Candidate.
    pub name: String,
    /// Error.
    #[serde(flatten)]
    pub error: Error,
    /// What it is on the chip; nothing for what needs the standard library.
    #[serde(flatten)]
    pub on_chip: Option<OnChip>,
    /// The firmware uses it.
    pub chosen: bool,
    /// It checks what the firmware uses: it competes with nothing.
    pub check: bool,
    /// Where and why.
    pub why: Option<&'static str>,
}

impl Row {
    /// Mean instructions; infinite for what cannot run on the chip.
    pub fn instructions(&self) -> f64 {
        self.on_chip
            .map_or(f64::INFINITY, |chip| chip.cost.instructions_mean)
    }

    /// Better in error and in cost than another of the same task, with which it competes. An answer that is lacking is an infinite error.
    pub fn beats(&self, other: &Self) -> bool {
        let error = |row: &Self| {
            if row.error.nonfinite > 0 {
                f64::INFINITY
            } else {
                row.error.error_max
            }
        };
        self.task == other.task
            && !self.check
            && error(self) < error(other)
            && self.instructions() < other.instructions()
    }
}
