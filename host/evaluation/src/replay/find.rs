//! Free motion in a recording, from which friction can be learned.

use palpate::sample::{Drive, Sample};

/// A pause in a closing, microseconds, that does not yet end it.
const PAUSE_US: u64 = 100_000;
/// Share of the scene's travel that is enough for a free closing.
const LEAST_SHARE: f64 = 0.5;
/// Share of the longest closing, or of the scene's travel if that is shorter, that a free one must have: one that stopped early
/// may have touched something.
const FREE_SHARE: f64 = 0.9;
/// Samples below which a closing is a twitch.
const LEAST_SAMPLES: usize = 100;
/// Ratio of late to early current within which a closing counts as free.
const FREE_RISE: std::ops::Range<f64> = 0.5..1.5;

/// A stretch of samples, by index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MotionSegment {
    /// First sample.
    pub from: usize,
    /// After the last sample.
    pub to: usize,
}

/// Stretches driven in one direction.
fn stretches(samples: &[Sample], drive: Drive) -> Vec<MotionSegment> {
    let mut found: Vec<MotionSegment> = Vec::new();
    for (index, sample) in samples.iter().enumerate() {
        if sample.drive != drive {
            continue;
        }
        match found.last_mut() {
            Some(last)
                if sample.time_us.saturating_sub(samples[last.to - 1].time_us) <= PAUSE_US
                    && samples[last.to..index]
                        .iter()
                        .all(|s| s.drive == Drive::Idle) =>
            {
                last.to = index + 1;
            }
            _ => found.push(MotionSegment {
                from: index,
                to: index + 1,
            }),
        }
    }
    found
}

fn travel(samples: &[Sample], stretch: &MotionSegment) -> f64 {
    let (first, last) = (&samples[stretch.from], &samples[stretch.to - 1]);
    f64::from(last.position_counts.wrapping_sub(first.position_counts))
}

/// Mean current over the last quarter of a stretch, over that of its second quarter: a contact makes it rise.
fn rise(samples: &[Sample], stretch: &MotionSegment) -> f64 {
    let length = stretch.to - stretch.from;
    let mean = |from: usize, to: usize| {
        let part = &samples[stretch.from + from..stretch.from + to];
        part.iter().map(|s| f64::from(s.current_a)).sum::<f64>() / part.len().max(1) as f64
    };
    mean(3 * length / 4, length) / mean(length / 4, length / 2)
}

/// Why there is no free closing in a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoFreeClosing {
    /// The motor never closes.
    NoClosing,
    /// No closing is long enough, counts.
    TooShort {
        /// The longest one.
        longest: f64,
        /// What is needed.
        needed: f64,
    },
    /// The current rises in every long closing: something was touched, or the stop.
    Rises {
        /// When the flattest one begins, second.
        from_s: f64,
        /// Its late current over its early one.
        ratio: f64,
    },
}

impl std::fmt::Display for NoFreeClosing {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoClosing => write!(
                out,
                "the motor never closes in it (is closing the direction of rising counts?)"
            ),
            Self::TooShort { longest, needed } => write!(
                out,
                "its longest closing is {longest:.0} counts long, a free one must be {needed:.0}: half the scene's travel"
            ),
            Self::Rises { from_s, ratio } => write!(
                out,
                "in the flattest of its long closings, at {from_s:.3} s, the current ends {ratio:.2} times as large as it \
                 began: something was touched"
            ),
        }
    }
}

/// A free closing: among those that are long, the one whose current rises least.
///
/// # Errors
/// Why there is none.
pub fn free_closing(
    samples: &[Sample],
    travel_counts: f64,
) -> Result<MotionSegment, NoFreeClosing> {
    let least_counts = LEAST_SHARE * travel_counts;
    let closings = stretches(samples, Drive::Closing);
    let longest = closings
        .iter()
        .map(|stretch| travel(samples, stretch))
        .reduce(f64::max)
        .ok_or(NoFreeClosing::NoClosing)?;
    let too_short = NoFreeClosing::TooShort {
        longest,
        needed: least_counts,
    };
    if longest < least_counts {
        return Err(too_short);
    }
    let flattest = closings
        .into_iter()
        .filter(|stretch| {
            travel(samples, stretch) >= FREE_SHARE * longest.min(travel_counts)
                && stretch.to - stretch.from > LEAST_SAMPLES
        })
        .min_by(|a, b| rise(samples, a).total_cmp(&rise(samples, b)))
        .ok_or(too_short)?;
    // A closing that ends in a contact is no free one, however long.
    let ratio = rise(samples, &flattest);
    if FREE_RISE.contains(&ratio) {
        Ok(flattest)
    } else {
        Err(NoFreeClosing::Rises {
            from_s: samples[flattest.from].time_us as f64 * 1e-6,
            ratio,
        })
    }
}

/// With the opening that follows, so that friction is known both ways.
#[must_use]
pub fn with_opening(samples: &[Sample], closing: &MotionSegment) -> MotionSegment {
    let opening = stretches(samples, Drive::Opening)
        .into_iter()
        .find(|stretch| stretch.from >= closing.to);
    let next = stretches(samples, Drive::Closing)
        .into_iter()
        .find(|stretch| stretch.from >= closing.to);
    let to = match (opening, next) {
        (Some(opening), Some(next)) if opening.from > next.from => closing.to,
        (Some(opening), _) => opening.to,
        (None, _) => closing.to,
    };
    MotionSegment {
        from: closing.from,
        to,
    }
}
