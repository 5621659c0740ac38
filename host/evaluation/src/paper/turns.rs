//! Means over whole turns of the motor at a steady speed.

use palpate::sample::{Drive, Sample};

use super::Model;

/// A turn whose speed is further from the closing's median than this share is no steady motion.
const SPEED_TOLERANCE: f64 = 0.2;
/// Way after a start that is left out, turns: the motor accelerates and takes up the gears' backlash there.
const START_UP_TURNS: usize = 8;
/// Longer without a closing sample is a pause, microseconds.
const PAUSE_US: u64 = 40_000;

/// Torque and angle over a turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotorTurn {
    /// End of the turn.
    pub time_us: u64,
    /// Mean torque, newton metre, as computed from the current.
    pub torque_nm: f64,
    /// The free finger's torque taken off.
    pub excess_nm: f64,
    /// Middle of the turn, radian of the input link.
    pub angle_rad: f64,
    duration_us: f64,
    /// Turns since the last start or pause.
    since_start: usize,
}

/// Whole turns in the closing direction, cut within a sample where need be.
fn whole(model: &Model, samples: &[Sample]) -> Vec<MotorTurn> {
    let mut turns = Vec::new();
    // Begin of the turn, counts; time and current-time so far.
    let mut open: Option<(f64, f64, f64)> = None;
    let mut since_start = 0;
    let mut last: Option<&Sample> = None;
    for sample in samples {
        let before = last.replace(sample);
        let Some(before) = before.filter(|b| sample.time_us.saturating_sub(b.time_us) <= PAUSE_US)
        else {
            open = None;
            continue;
        };
        if sample.drive != Drive::Closing {
            open = None;
            continue;
        }
        let elapsed_us = (sample.time_us - before.time_us) as f64;
        let way = f64::from(sample.position_counts.wrapping_sub(before.position_counts));
        let from = f64::from(before.position_counts);
        let (mut begin, mut time_us, mut ampere_us) = *open.get_or_insert_with(|| {
            since_start = 0;
            (from, 0.0, 0.0)
        });
        let mut left = 1.0;
        // More than a turn within a sample does not happen: 1 ms is less than half a turn at full speed.
        let end = begin + model.counts_per_turn;
        if from + way >= end && way > 0.0 {
            let share = ((end - from) / way).clamp(0.0, 1.0);
            time_us += share * elapsed_us;
            ampere_us += share * elapsed_us * f64::from(sample.current_a);
            let torque_nm = ampere_us / time_us * model.torque_nm_per_a;
            let angle_rad = (begin + 0.5 * model.counts_per_turn) / model.counts_per_rad;
            turns.push(MotorTurn {
                time_us: sample.time_us,
                torque_nm,
                excess_nm: torque_nm - model.free_torque(angle_rad),
                angle_rad,
                duration_us: time_us,
                since_start,
            });
            since_start += 1;
            left -= share;
            (begin, time_us, ampere_us) = (end, 0.0, 0.0);
        }
        time_us += left * elapsed_us;
        ampere_us += left * elapsed_us * f64::from(sample.current_a);
        open = Some((begin, time_us, ampere_us));
    }
    turns
}

/// The steady turns of a closing.
pub(super) fn steady(model: &Model, samples: &[Sample]) -> Vec<MotorTurn> {
    let mut turns = whole(model, samples);
    let mut durations: Vec<f64> = turns.iter().map(|turn| turn.duration_us).collect();
    durations.sort_by(f64::total_cmp);
    let Some(&median) = durations.get(durations.len() / 2) else {
        return turns;
    };
    turns.retain(|turn| {
        turn.since_start >= START_UP_TURNS
            && (median / turn.duration_us - 1.0).abs() <= SPEED_TOLERANCE
    });
    turns
}
