//! The path after contact: a phalanx rolls and slides on a cylinder fixed in space while the torque rises (MATH 7).
//!
//! Unknown are the changes delta of the joint angles and the contact force f. They satisfy
//!
//! - equilibrium of every joint, tau(T, delta) = f p(delta), in increments since contact, where tau = 0;
//! - contact: the phalanx stays at the distance R from the cylinder's centre; R = 0 is a point.
//!
//! Newton's method solves both together, at e_2 as well as anywhere: nothing is divided by what vanishes there. With the
//! contact's place k unknown too and the rotation of the input link given, the same system is the estimator of one
//! finite step. Everything is dimensionless inside: lengths over the finger's, stiffness over the largest.

// Indices are those of the matrices in the equations; loops over 0..N need no bounds check.
#![allow(clippy::needless_range_loop)]

use super::preshape::dot;
use super::{Configuration, Contact, Finger, Gear, MAX_PHALANGES, PathPoint, Step, Transmission};
use crate::numeric::{Turn, solve};

/// Newton steps towards one torque; warm-started, two or three are taken.
const STEPS: u8 = 16;
/// A joint's change in one Newton step, radian, beyond which the step is shortened.
const STRIDE_RAD: f32 = 0.2;
/// A change this small compared with the joints' is their rounding.
const SETTLED_SHARE: f32 = 2e-7;
/// A change this small compared with the joints' may be rounding, if it no longer shrinks.
const NOISE_SHARE: f32 = 1e-4;
/// Pieces into which a torque is divided when Newton's method does not reach it in one.
const PIECES: u8 = 8;

/// A contact path under way: what was there at contact, and the last point found.
#[derive(Clone, Copy, Debug)]
pub struct Path<const N: usize> {
    start: Start<N>,
    last: Unknown<N>,
    /// Input torque of `last` since contact, over the stiffness scale.
    rise: f32,
}

/// The instant of contact, dimensionless.
#[derive(Clone, Copy, Debug)]
struct Start<const N: usize> {
    from: Configuration<N>,
    torque: f32,
    /// Phalanges before the one in contact.
    before: usize,
    lengths: [f32; N],
    stiffness: [f32; N],
    radius: f32,
    length_scale: f32,
    stiffness_scale: f32,
}

/// What Newton's method moves.
#[derive(Clone, Copy, Debug)]
struct Unknown<const N: usize> {
    delta: [f32; N],
    force: f32,
    k: f32,
}

/// The finger a step after contact, and what is amiss there.
struct Local<const N: usize> {
    gear: Gear<N>,
    /// H + f dp/ddelta.
    stiffness: [[f32; N]; N],
    /// Moment arms p of the contact.
    arms: [f32; N],
    /// dp/dk, and the sine with which k shifts the gap.
    arms_by_k: [f32; N],
    gap_by_k: f32,
    /// tau - f p.
    torques: [f32; N],
    /// Distance of the cylinder from the phalanx.
    gap: f32,
    k_now: f32,
}

/// Linear responses of the finger held by the contact.
struct Response<const N: usize> {
    /// To the torques and gap that are amiss.
    amiss: [f32; N],
    /// To a unit of input torque: d delta / dT, d f / dT.
    by_torque: [f32; N],
    force_amiss: f32,
    force_by_torque: f32,
}

impl<const N: usize> Start<N> {
    /// Everything about the finger at `at`, exactly as far from contact as the increments say.
    fn local<T: Transmission<N>>(
        &self,
        transmission: &T,
        at: &Unknown<N>,
        rise: f32,
    ) -> Option<Local<N>> {
        let step = Step::of(at.delta);
        let now = self.from.advanced(&step);
        let gear = transmission.gear(&now)?;
        let x_change = transmission.x_change(&self.from, &step)?;
        let torque = self.torque + rise;
        let (was, turn, i) = (self.from.turn(), now.turn(), self.before);

        // Down from the contact: bend of phalanx i against phalanx j at contact and now, and half the rotation of j.
        let mut half = step
            .half
            .iter()
            .take(i + 1)
            .fold(Turn::NONE, |sum, h| sum.then(*h));
        let phi = half.twice();
        let versine = 2.0 * half.sin * half.sin;
        let mut arms_sines = [(0.0f32, 0.0f32); N];
        let (mut bend_was, mut bend_now) = (Turn::NONE, Turn::NONE);
        let (mut arm, mut sine) = (0.0f32, 0.0f32);
        let mut shift = [0.0f32; 2];
        for j in (0..N).filter(|j| *j <= i).rev() {
            arms_sines[j] = (arm, sine);
            let Some(below) = j.checked_sub(1) else { break };
            half = half.then(step.half[j].back());
            bend_was = bend_was.then(was[j]);
            bend_now = bend_now.then(turn[j]);
            // The tip of phalanx j moves by a chord, perpendicular to its middle direction; frame of phalanx i at contact.
            let middle = bend_was.back().then(half);
            let chord = 2.0 * half.sin * self.lengths[below];
            shift[0] -= chord * middle.sin;
            shift[1] += chord * middle.cos;
            arm += self.lengths[below] * bend_now.cos;
            sine -= self.lengths[below] * bend_now.sin;
        }
        let gap = -at.k * phi.sin - self.radius * versine + phi.sin * shift[0] - phi.cos * shift[1];
        let k_now = phi.cos * (at.k - shift[0]) + phi.sin * (self.radius - shift[1]);
        let normal = self.radius + gap;

        let (mut arms, mut arms_by_k) = ([0.0; N], [0.0; N]);
        let mut stiffness = gear.w;
        let mut torques = [0.0; N];
        for m in 0..N {
            for q in 0..N {
                stiffness[m][q] *= -torque;
                if m <= i && q <= i {
                    // dp_m/ddelta_q: the height of the contact over the joint nearer to the base.
                    stiffness[m][q] += at.force * (normal + arms_sines[m.min(q)].1);
                }
            }
            stiffness[m][m] += self.stiffness[m];
            if m <= i {
                arms[m] = k_now + arms_sines[m].0;
                arms_by_k[m] = phi.cos;
            }
            let driven = gear.x[m] * rise + x_change[m] * self.torque;
            torques[m] = driven - self.stiffness[m] * at.delta[m] - at.force * arms[m];
        }
        Some(Local {
            gear,
            stiffness,
            arms,
            arms_by_k,
            gap_by_k: phi.sin,
            torques,
            gap,
            k_now,
        })
    }
}

impl<const N: usize> Local<N> {
    /// The stiffness made regular by a spring across the contact, which moves no solution and lends joint 1 without a
    /// spring a pivot.
    fn braced(&self) -> [[f32; N]; N] {
        let mut a = self.stiffness;
        for m in 0..N {
            for q in 0..N {
                a[m][q] += self.arms[m] * self.arms[q];
            }
        }
        a
    }

    /// Newton's step at a given torque, and the tangent along the path.
    fn response(&self) -> Option<Response<N>> {
        let [u, w, y] = solve(self.braced(), [self.torques, self.arms, self.gear.x])?;
        let held = dot(&self.arms, &w);
        let force = (dot(&self.arms, &u) - self.gap) / held;
        let force_by_torque = dot(&self.arms, &y) / held;
        let (mut amiss, mut by_torque) = (u, y);
        for m in 0..N {
            amiss[m] -= w[m] * force;
            by_torque[m] -= w[m] * force_by_torque;
        }
        let all = amiss
            .iter()
            .chain(&by_torque)
            .chain([&force, &force_by_torque]);
        all.into_iter().all(|x| x.is_finite()).then_some(Response {
            amiss,
            by_torque,
            force_amiss: force + self.gap,
            force_by_torque,
        })
    }

    /// y^T H y for the tangent y: the compliance. Unlike x^T y it keeps its digits near e_2, where y vanishes.
    fn compliance(&self, tangent: &[f32; N]) -> f32 {
        self.stiffness
            .iter()
            .zip(tangent)
            .map(|(row, y)| y * dot(row, tangent))
            .sum()
    }

    /// Newton's step with the place of the contact unknown and the rotation of the input link `missing` given.
    fn place_response(&self, force: f32, missing: f32) -> Option<Unknown<N>> {
        let [u, w, z] = solve(self.braced(), [self.torques, self.arms, self.arms_by_k])?;
        let z = z.map(|z| z * force);
        let (p, x) = (&self.arms, &self.gear.x);
        let rows = [
            [dot(p, &w), dot(p, &z) - self.gap_by_k],
            [dot(x, &w), dot(x, &z)],
        ];
        let [[more, k]] = solve(rows, [[dot(p, &u) - self.gap, dot(x, &u) - missing]])?;
        let mut delta = u;
        for m in 0..N {
            delta[m] -= w[m] * more + z[m] * k;
        }
        Some(Unknown {
            delta,
            force: more + self.gap - self.gap_by_k * k,
            k,
        })
    }
}

fn largest<const N: usize>(of: &[f32; N]) -> f32 {
    of.iter().fold(0.0f32, |m, x| m.max(x.abs()))
}

impl<const N: usize> Unknown<N> {
    /// Adds a Newton step, shortened to the stride; answers its size and whether it was shortened.
    fn add(&mut self, step: &Unknown<N>) -> Option<(f32, bool)> {
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

impl<const N: usize, T: Transmission<N>> Finger<N, T> {
    /// See [`super::Mechanics::path`].
    pub(crate) fn start(
        &self,
        at: &Configuration<N>,
        torque_nm: f32,
        contact: Contact,
    ) -> Option<Path<N>> {
        let Contact {
            phalanx,
            k_m,
            radius_m,
        } = contact;
        let before = usize::from(phalanx).checked_sub(1)?;
        let length = *self.parameters.lengths_m.get(before)?;
        if !(k_m > 0.0 && k_m <= length && radius_m >= 0.0 && torque_nm.is_finite()) {
            return None;
        }
        let length_scale = self.parameters.lengths_m.iter().sum::<f32>();
        let stiffness_scale = self
            .parameters
            .stiffness_nm_per_rad
            .iter()
            .fold(0.0f32, |m, k| m.max(*k));
        let start = Start {
            from: *at,
            torque: torque_nm / stiffness_scale,
            before,
            lengths: self.parameters.lengths_m.map(|l| l / length_scale),
            stiffness: self
                .parameters
                .stiffness_nm_per_rad
                .map(|k| k / stiffness_scale),
            radius: radius_m / length_scale,
            length_scale,
            stiffness_scale,
        };
        let last = Unknown {
            delta: [0.0; N],
            force: 0.0,
            k: k_m / length_scale,
        };
        let local = start.local(&self.transmission, &last, 0.0)?;
        let response = local.response()?;
        let presses =
            response.force_by_torque > 0.0 && local.compliance(&response.by_torque) >= 0.0;
        presses.then_some(Path {
            start,
            last,
            rise: 0.0,
        })
    }

    /// See [`super::Mechanics::follow`].
    pub(crate) fn continue_to(&self, path: &mut Path<N>, rise_nm: f32) -> Option<PathPoint> {
        let rise = rise_nm / path.start.stiffness_scale;
        if !rise.is_finite() {
            return None;
        }
        let found = self
            .newton(&path.start, path.last, path.rise, rise)
            .or_else(|| {
                let (mut at, mut reached) = (path.last, path.rise);
                for piece in 1..=PIECES {
                    let next =
                        path.rise + (rise - path.rise) * (f32::from(piece) / f32::from(PIECES));
                    at = self.newton(&path.start, at, reached, next)?;
                    reached = next;
                }
                Some(at)
            })?;
        let point = self.point(&path.start, &found, rise)?;
        path.last = found;
        path.rise = rise;
        Some(point)
    }

    /// From a point of the path to the one at another rise.
    fn newton(
        &self,
        start: &Start<N>,
        last: Unknown<N>,
        reached: f32,
        rise: f32,
    ) -> Option<Unknown<N>> {
        let mut at = last;
        // Along the tangent first: Newton's method from there keeps to the branch.
        let response = start.local(&self.transmission, &at, reached)?.response()?;
        let more = rise - reached;
        at.add(&Unknown {
            delta: response.by_torque.map(|y| y * more),
            force: response.force_by_torque * more,
            k: 0.0,
        })?;
        let mut settling = Settling {
            before: f32::INFINITY,
        };
        for _ in 0..STEPS {
            let response = start.local(&self.transmission, &at, rise)?.response()?;
            let (size, shortened) = at.add(&Unknown {
                delta: response.amiss,
                force: response.force_amiss,
                k: 0.0,
            })?;
            if settling.done(size, shortened, &at.delta) {
                return Some(at);
            }
        }
        None
    }

    /// What a user wants to know of a solved point; `None` where the contact would be off the phalanx or pull.
    fn point(&self, start: &Start<N>, at: &Unknown<N>, rise: f32) -> Option<PathPoint> {
        let local = start.local(&self.transmission, at, rise)?;
        let response = local.response()?;
        let compliance = local.compliance(&response.by_torque) / start.stiffness_scale;
        let step = Step::of(at.delta);
        let rotation_rad = self.transmission.turned_rad(&start.from, &step)?;
        let reach = start.lengths.get(start.before)?;
        let stays = local.k_now > 0.0
            && local.k_now <= *reach
            && at.force >= -f32::EPSILON
            && compliance >= 0.0;
        let mut joints_rad = [0.0; MAX_PHALANGES];
        for (joint, delta) in joints_rad.iter_mut().zip(at.delta) {
            *joint = delta;
        }
        let point = PathPoint {
            rotation_rad,
            compliance_rad_per_nm: compliance,
            k_now_m: self.on_phalanx(start, local.k_now)?,
            force_n: at.force * (start.stiffness_scale / start.length_scale),
            joints_rad,
        };
        let finite =
            rotation_rad.is_finite() && compliance.is_finite() && point.force_n.is_finite();
        (stays && finite).then_some(point)
    }

    /// A distance along the phalanx in metre; the change of scale may round past the tip.
    fn on_phalanx(&self, start: &Start<N>, k: f32) -> Option<f32> {
        Some((k * start.length_scale).min(*self.parameters.lengths_m.get(start.before)?))
    }

    /// See [`super::Mechanics::place`].
    pub(crate) fn placed(
        &self,
        guess: &Path<N>,
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
        let mut at = path.last;
        let mut settling = Settling {
            before: f32::INFINITY,
        };
        for _ in 0..STEPS {
            let local = start.local(&self.transmission, &at, rise)?;
            let turned = self
                .transmission
                .turned_rad(&start.from, &Step::of(at.delta))?;
            let step = local.place_response(at.force, rotation_rad - turned)?;
            let (size, shortened) = at.add(&step)?;
            let moved = size.max(step.k.abs() * largest(&at.delta));
            if settling.done(moved, shortened, &at.delta) {
                let reach = *start.lengths.get(start.before)?;
                let point = self.point(start, &at, rise)?;
                let on_it = at.k > 0.0 && at.k <= reach;
                return on_it.then_some((self.on_phalanx(start, at.k)?, point));
            }
        }
        None
    }
}
