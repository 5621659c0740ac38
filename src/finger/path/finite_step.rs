//! The estimator of one finite step: the place that turns the input link as measured.

use super::Path;
use super::newton::{STEPS, largest};
use crate::finger::{BaseJoint, Finger, JointStep, PathPoint, Transmission};
use crate::numeric::Bounded;

/// A change this small compared with the joints' is their rounding.
const SETTLED_SHARE: f32 = 2e-7;
/// A change this small compared with the joints' may be rounding, if it no longer shrinks.
const NOISE_SHARE: f32 = 1e-4;

/// Says when Newton's method is done: the step is the rounding of what it changes, or no longer shrinks near that.
struct Settling {
    before: f32,
}

impl Settling {
    fn done<const N: usize>(&mut self, size: f32, shortened: bool, delta: &[f32; N]) -> bool {
        let scale = largest(delta);
        let done = !shortened
            && (size <= SETTLED_SHARE * scale
                || (size <= NOISE_SHARE * scale && size >= 0.5 * self.before));
        self.before = size;
        done
    }
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// See [`super::Mechanics::place`].
    pub(crate) fn placed(
        &self,
        guess: &Path<N, B>,
        rise_nm: f32,
        rotation_rad: f32,
    ) -> Option<(f32, PathPoint)> {
        let start = &guess.start;
        let rise = rise_nm / start.stiffness_scale;
        if !(rise.is_finite() && rotation_rad.is_finite()) {
            return None;
        }
        let mut path = *guess;
        self.continue_to(&mut path, rise_nm);
        let mut at = path.last.at;
        let mut settling = Settling {
            before: f32::INFINITY,
        };
        for _ in 0..STEPS {
            let local = start.local(&self.transmission, &at, rise)?;
            let turned = self
                .transmission
                .turned_rad(&start.from, &JointStep::of(at.delta))?;
            let step = local.place_response(at.force, rotation_rad - turned)?;
            let (size, shortened) = at.add(&step)?;
            let moved = size.at_least(step.k.abs() * largest(&at.delta));
            if settling.done(moved, shortened, &at.delta) {
                let reach = *start.lengths.get(usize::from(start.before))?;
                let (point, _) = self.point(start, &path.last, &at, rise)?;
                let on_it = at.k > 0.0 && at.k <= reach;
                return on_it.then_some((self.on_phalanx(start, at.k)?, point));
            }
        }
        None
    }
}
