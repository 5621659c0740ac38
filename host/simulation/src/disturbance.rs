//! What happens to an object that a finger touches or holds: it goes, gives way or is pushed against the finger.

use palpate::drive::sequence::State;
use palpate_plant::{Grasp, Plant};

/// Samples in which an object moves, and after which the torque is what came of it: a finger with mass follows late.
const MOVING: u32 = 5;
const FOLLOWING: u32 = 15;

/// When something happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Not at all.
    Never,
    /// While the torque rises, at this torque of the input link, newton metre.
    Rising(f64),
    /// So long into the hold, second.
    Holding(f64),
}

/// What happens then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// Nothing.
    Nothing,
    /// The object goes.
    Goes,
    /// It moves away from the phalanx by this distance, or (negative) towards it, metre, within 5 ms.
    Gives(f64),
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Happened {
    /// When it began, second since the world was made.
    pub time_s: f64,
    /// Torque at the input link before and after, newton metre.
    pub from_nm: f64,
    /// See `from_nm`.
    pub to_nm: f64,
    /// In the hold.
    pub is_held: bool,
}

/// Lets something happen, once.
#[derive(Clone, Debug)]
pub struct Disturbance {
    when: When,
    what: What,
    held: u32,
    since: u32,
    away: [f64; 2],
    happened: Option<Happened>,
}

impl Disturbance {
    /// Of a closing that is still to come.
    #[must_use]
    pub fn new(when: When, what: What) -> Self {
        Self {
            when,
            what,
            held: 0,
            since: 0,
            away: [0.0; 2],
            happened: None,
        }
    }

    /// What has happened so far.
    #[must_use]
    pub fn happened(&self) -> Option<Happened> {
        self.happened
    }

    /// To be called after every sample of the closing.
    ///
    /// # Errors
    /// The world cannot have the object there.
    pub fn advance(&mut self, plant: &mut Plant, state: State) -> Result<(), palpate_plant::Error> {
        self.held += u32::from(state == State::Hold);
        let truth = plant.truth();
        if let Some(happened) = &mut self.happened {
            if self.since < FOLLOWING {
                self.since += 1;
                if let What::Gives(by_m) = self.what
                    && self.since <= MOVING
                {
                    plant.shift(self.away.map(|part| part * by_m / f64::from(MOVING)))?;
                }
                happened.to_nm = truth.torque_nm;
            }
            return Ok(());
        }
        let is_due = match self.when {
            When::Never => false,
            When::Rising(torque_nm) => state == State::Probe && truth.torque_nm > torque_nm,
            When::Holding(s) => f64::from(self.held) * 1e-3 > s,
        };
        let Some(contact) = truth.strongest().filter(|_| is_due) else {
            return Ok(());
        };
        let angles = &truth.joint_rad[..usize::from(contact.phalanx)];
        let (sin, cos) = angles.iter().sum::<f64>().sin_cos();
        self.away = [-sin, cos];
        self.happened = Some(Happened {
            time_s: truth.time_s,
            from_nm: truth.torque_nm,
            to_nm: truth.torque_nm,
            is_held: state == State::Hold,
        });
        if self.what == What::Goes {
            plant.place(&Grasp::Free)?;
        }
        Ok(())
    }
}
