//! Places that explain a compliance, and their classification.

use super::LONGEST_FINGER;

/// A place where a contact explains a measured compliance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Candidate {
    /// Phalanx, 2 for the second.
    pub phalanx: u8,
    /// Distance from the phalanx's joint, metre.
    pub k_m: f32,
    /// The candidate lies beyond the stiffest point of its phalanx (e_2 (27) with two phalanges), where further torque
    /// opens the next joint instead of closing it.
    pub beyond_stiffest: bool,
}

/// What a compliance implies about the place of the contact (docs/MECHANICS.md#observability).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One place.
    Unique,
    /// Two places on one phalanx, either side of its stiffest point.
    AmbiguousSame,
    /// Places on several phalanges.
    AmbiguousAcross,
    /// Softer than the finger without contact.
    TooSoft,
    /// Between the compliance of a proximal contact and that of the free finger: no place is that soft.
    Gap,
    /// No place is that stiff.
    TooStiff,
    /// A contact on phalanx 1, anywhere, or at the very joint of phalanx 2; with three phalanges there may be candidates
    /// as soft on the others.
    Proximal,
    /// The question makes no sense: a value is not finite, negative, or the finger is not stable in this posture.
    Invalid,
}

/// Two places on each phalanx but the first.
pub const MOST_CANDIDATES: usize = 2 * (LONGEST_FINGER - 1);

/// A list of places.
pub type Candidates = heapless::Vec<Candidate, MOST_CANDIDATES>;

/// All places that explain a compliance.
#[derive(Clone, Debug, PartialEq)]
pub struct Inverse {
    class: Class,
    candidates: Candidates,
}

impl Inverse {
    /// Collects what `class` and `candidates` say; the class of candidates follows from their phalanges.
    pub(crate) fn of(candidates: Candidates, without: Class) -> Self {
        let class = match candidates.as_slice() {
            [] => without,
            [_] => Class::Unique,
            [first, rest @ ..] if rest.iter().all(|c| c.phalanx == first.phalanx) => {
                Class::AmbiguousSame
            }
            _ => Class::AmbiguousAcross,
        };
        Self { class, candidates }
    }

    /// The same without candidates that something else rules out; all of them where none would be left.
    pub(crate) fn retaining(self, keep: impl Fn(&Candidate) -> bool) -> Self {
        let mut kept = heapless::Vec::new();
        for candidate in self.candidates.iter().filter(|c| keep(c)) {
            // As long as the list that it comes from.
            let _ = kept.push(*candidate);
        }
        if kept.is_empty() || self.class == Class::Proximal {
            self
        } else {
            Self::of(kept, self.class)
        }
    }

    /// As soft as a proximal contact; `others` are places on further phalanges that are as soft.
    pub(crate) fn proximal(others: Candidates) -> Self {
        Self {
            class: Class::Proximal,
            candidates: others,
        }
    }

    /// What the compliance implies.
    pub fn class(&self) -> Class {
        self.class
    }

    /// The places, by phalanx and distance; none unless the class is unique, ambiguous or proximal.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }
}
