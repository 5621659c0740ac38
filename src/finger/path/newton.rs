//! Newton's method along the path.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::Start;
use super::response::Response;
use crate::finger::{BaseJoint, Finger, Transmission};
use crate::numeric::Bounded;

/// Newton steps towards one torque; warm-started, two or three are taken.
pub(super) const STEPS: u8 = 16;
/// A joint's change in one Newton step, radian, beyond which the step is shortened.
const STRIDE_RAD: f32 = 0.2;
/// After a step this small compared with the joints' changes the next one, some times its square, is below 1e-5 of them,
/// and the one after it their rounding.
const NEAR_SHARE: f32 = 1e-3;
/// About break-away the joints have hardly turned, and a step is compared with the torque that holds them at their stops, over the
/// stiffness: one this small is its rounding.
const ROUNDING: f32 = 2e-6;
/// Longest way, compared with the one before, over which the path's bend is extrapolated.
const AHEAD: f32 = 4.0;

/// What Newton's method moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknown<const N: usize> {
    pub(super) delta: [f32; N],
    pub(super) force: f32,
    pub(super) k: f32,
}

impl<const N: usize> From<Response<N>> for Unknown<N> {
    fn from(Response { delta, force }: Response<N>) -> Self {
        Self {
            delta,
            force,
            k: 0.0,
        }
    }
}

impl<const N: usize> Unknown<N> {
    /// Adds a Newton step, shortened to the stride; respond its size and whether it was shortened.
    pub(super) fn add(&mut self, step: &Unknown<N>) -> Option<(f32, bool)> {
        let size = largest(&step.delta);
        let share = if size > STRIDE_RAD {
            STRIDE_RAD / size
        } else {
            1.0
        };
        for m in 0..N {
            self.delta[m] += share * step.delta[m];
        }
        self.force += share * step.force;
        self.k += share * step.k;
        let finite = self
            .delta
            .iter()
            .chain([&self.force, &self.k])
            .all(|x| x.is_finite() && x.abs() < 1e12);
        finite.then_some((size, share < 1.0))
    }
}

pub(super) fn largest<const N: usize>(of: &[f32; N]) -> f32 {
    of.iter().fold(0.0f32, |m, x| x.abs().at_least(m))
}

/// A solved point of the path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState<const N: usize> {
    pub(super) at: Unknown<N>,
    /// Input torque since contact, over the stiffness scale.
    pub(super) rise: f32,
    /// Change along the path for a unit of it.
    pub(super) tangent: Response<N>,
    /// What that was at the station before, and the way from there; no way at the start.
    pub(super) before: (Response<N>, f32),
}

impl<const N: usize> PathState<N> {
    /// Where the path leads to over some more torque, by its tangent and its bend.
    fn ahead(&self, more: f32) -> Unknown<N> {
        let (before, way) = &self.before;
        // Over a way that hardly was one the bend is rounding, over none it is no number.
        let bend = if more.abs() < AHEAD * way.abs() {
            0.5 * more / way
        } else {
            0.0
        };
        let along = |now: f32, before: f32| more * (now + bend * (now - before));
        let mut delta = self.tangent.delta;
        for m in 0..N {
            delta[m] = along(delta[m], before.delta[m]);
        }
        Unknown {
            delta,
            force: along(self.tangent.force, before.force),
            k: 0.0,
        }
    }
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// From a point of the path to near the one at another rise: so near that one step more, which who asks for the
    /// point takes, ends in the rounding.
    pub(super) fn newton(
        &self,
        start: &Start<N, B>,
        from: &PathState<N>,
        rise: f32,
    ) -> Option<Unknown<N>> {
        let mut at = from.at;
        // Along the path first: Newton's method from there keeps to the branch.
        at.add(&from.ahead(rise - from.rise))?;
        for _ in 0..STEPS {
            let step = start.local(&self.transmission, &at, rise)?.step()?;
            let (size, shortened) = at.add(&step.into())?;
            if !shortened
                && size <= NEAR_SHARE * largest(&at.delta) + ROUNDING * largest(&start.held)
            {
                return Some(at);
            }
        }
        None
    }
}
