//! Scores: what was said of a closing next to the truth, and the figures that follow from many of them.
//!
//! The one place where "located", "early" or "within two deviations" are defined; experiments and recordings count alike.

mod listener;
mod summary;

pub use listener::Listener;
pub use summary::{Scores, mean_and_deviation, median, quantile};

/// So much before the true contact a touch may be decided and still be one, second: two samples.
pub const EARLY_S: f64 = 2e-3;

/// Where and when a closing made first contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Phalanx that was touched first, from 1.
    pub phalanx: u8,
    /// Contact location from that phalanx's joint, metre.
    pub k_m: f64,
    /// Length of that phalanx, metre.
    pub length_m: f64,
    /// First contact, second on the samples' clock.
    pub time_s: f64,
}

/// The last word on a closing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Answer {
    /// Nothing was said of a contact.
    #[default]
    Nothing,
    /// A place; the deviation is NaN where the method claims none.
    Located {
        /// Phalanx.
        phalanx: u8,
        /// Place, metre.
        k_m: f64,
        /// Its claimed standard deviation, metre.
        sigma_m: f64,
    },
    /// Two places; the likelier.
    Ambiguous {
        /// Phalanx.
        phalanx: u8,
        /// Place, metre.
        k_m: f64,
        /// Its claimed standard deviation, metre.
        sigma_m: f64,
    },
    /// On the proximal phalanx, somewhere.
    Proximal,
    /// A contact, but nowhere.
    NotLocated,
}

impl Answer {
    /// Phalanx that was named.
    #[must_use]
    pub fn phalanx(&self) -> Option<u8> {
        match *self {
            Self::Located { phalanx, .. } | Self::Ambiguous { phalanx, .. } => Some(phalanx),
            Self::Proximal => Some(1),
            Self::Nothing | Self::NotLocated => None,
        }
    }

    /// Place and claimed deviation, metre; the likelier of two.
    #[must_use]
    pub fn place(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Located { k_m, sigma_m, .. } | Self::Ambiguous { k_m, sigma_m, .. } => {
                Some((k_m, sigma_m))
            }
            _ => None,
        }
    }
}

/// A contact force that was told, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// When it was told, second on the samples' clock.
    pub time_s: f64,
    /// What was told, newton.
    pub told_n: f64,
    /// Its claimed standard deviation, newton; NaN where none is claimed.
    pub sigma_n: f64,
    /// The truth at that instant, newton; NaN where it is not known.
    pub true_n: f64,
}

/// What one method said of one closing, next to the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trial {
    /// What was touched; `None` for a free closing.
    pub truth: Option<Contact>,
    /// When a contact was first decided, second on the samples' clock.
    pub touched_s: Option<f64>,
    /// The last word.
    pub answer: Answer,
    /// The last force that was told with a place.
    pub force: Option<Force>,
    /// The finger was said to be softer than it is without contact.
    pub unusual: bool,
}

impl Trial {
    /// A touch was decided before there was a contact.
    #[must_use]
    pub fn is_early(&self) -> bool {
        self.touched_s.is_some_and(|touched_s| {
            self.truth
                .is_none_or(|contact| touched_s < contact.time_s - EARLY_S)
        })
    }

    /// A contact beyond the proximal phalanx was given a place on the phalanx that it is on, and not too early.
    #[must_use]
    pub fn is_located(&self) -> bool {
        self.error_m().is_some()
    }

    /// Error of the place, metre, where it was located.
    #[must_use]
    pub fn error_m(&self) -> Option<f64> {
        let contact = self.truth.filter(|contact| contact.phalanx > 1)?;
        let (k_m, _) = self.answer.place()?;
        (self.answer.phalanx() == Some(contact.phalanx) && !self.is_early())
            .then_some(k_m - contact.k_m)
    }

    /// Nothing at all was said of a contact or of softness.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.touched_s.is_none() && !self.unusual && self.answer == Answer::Nothing
    }
}
