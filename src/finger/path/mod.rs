//! The path after contact: a phalanx rolls and slides on a cylinder fixed in space while the torque rises
//! (docs/MECHANICS.md#finite-torque-step).
//!
//! Unknown are the changes delta of the joint angles and the contact force f. They satisfy
//!
//! - equilibrium of every joint, tau(T, delta) = f p(delta), in increments since contact, where tau = 0;
//! - contact: the phalanx stays at the distance R from the cylinder's centre; R = 0 is a point. A soft object's centre gives way
//!   with the force, across the phalanx.
//!
//! Newton's method solves both together, at e_2 as well as anywhere: nothing is divided by what vanishes there. With the
//! contact's place k unknown too and the rotation of the input link given, the same system is the estimator of one
//! finite step. Everything is dimensionless inside: lengths over the finger's, stiffness over the largest.

mod acting;
mod finite_step;
mod joint;
mod linearization;
mod newton;
mod response;
#[cfg(all(test, feature = "firmware"))]
mod tests;

use super::{
    AnyBase, BaseJoint, Configuration, Contact, Finger, JointStep, MAX_PHALANGES, PathPoint,
    Transmission,
};
use crate::numeric::{Bounded, dot};
use linearization::Linearization;
use newton::{PathState, Unknown};
use response::Responses;

/// Pieces into which a torque is divided when Newton's method does not reach it in one.
const PIECES: u8 = 8;

/// Torque beyond break-away over which the tangent is followed, as a share of it: its error is the square, and less turning is rounding.
const TANGENT_SHARE: f32 = 1e-4;

/// A contact path under way: what was there at contact, and the last point found.
#[derive(Clone, Copy, Debug)]
pub struct Path<const N: usize, B = AnyBase> {
    start: Start<N, B>,
    last: PathState<N>,
}

/// A finger that presses on an object, linearised where its path has led: what a second contact starts from
/// (docs/SECOND_CONTACTS.md#two-contacts).
#[derive(Clone, Copy, Debug)]
pub struct Pressed<const N: usize> {
    /// The contact as it was made.
    pub contact: Contact,
    /// Where it is now, metre from the phalanx's joint.
    pub k_now_m: f32,
    /// Contact force, newton.
    pub force_n: f32,
    /// Joint angles, radian.
    pub joints_rad: [f32; N],
    /// Transmission factors.
    pub x: [f32; N],
    /// H = K - T_a W + f P, newton metre per radian.
    pub stiffness_nm_per_rad: [[f32; N]; N],
    /// Moment arms p of the contact, metre.
    pub arms_m: [f32; N],
    /// Change of the joint angles for a unit of input torque, radian per newton metre.
    pub tangent_per_nm: [f32; N],
    pub(crate) lengths_m: [f32; N],
    pub(crate) turn: [crate::numeric::Rotation; N],
}

impl<const N: usize> Pressed<N> {
    /// Compliance of the input link while this contact alone holds, radian per newton metre: y^T H y for the tangent y,
    /// which keeps its digits near the stiffest place, where x . y does not.
    pub fn compliance_rad_per_nm(&self) -> f32 {
        let y = &self.tangent_per_nm;
        let rows = self.stiffness_nm_per_rad.iter().zip(y);
        rows.map(|(row, turned)| turned * dot(row, y)).sum()
    }
}

impl<const N: usize, B> Path<N, B> {
    /// Changes of all joint angles from contact to the last point found, radian.
    pub fn joint_changes_rad(&self) -> [f32; N] {
        self.last.at.delta
    }

    /// From the last point on nothing rubs: contact friction acts against the motion, and where another contact changes that it is no
    /// longer what it was along the path.
    pub(super) fn slip(&mut self) {
        self.start.friction = 0.0;
        self.start.taken = [0.0; N];
    }
}

/// The instant of contact, dimensionless.
#[derive(Clone, Copy, Debug)]
struct Start<const N: usize, B> {
    from: Configuration<N>,
    base: B,
    torque: f32,
    /// Phalanges before the one in contact.
    before: u8,
    /// The sense in which each joint begins to turn: 1 where it closes, -1 where it turns back.
    sense: [f32; N],
    /// Share of the torque that is lost on the way to each joint, less than zero where it turns back.
    taken: [f32; N],
    /// Twice the torque at contact where a joint turns back: the free finger closed it, so a pulley first gives up what it took, then takes
    /// as much.
    back: [f32; N],
    lengths: [f32; N],
    stiffness: [f32; N],
    radius: f32,
    /// The finger's weight, along phalanx 1 at contact and across it: twice the torque that it has about joint 1 while the phalanges
    /// are in line, over the stiffness scale.
    weight: [f32; 2],
    /// Torque that holds the joints beyond the first at their stops, or against their `sense`, over the stiffness scale.
    held: [f32; N],
    /// Torque that their bearings take in a finger whose joints turned before, over the stiffness scale.
    braked: f32,
    /// Coefficient of contact friction.
    friction: f32,
    /// Compliance of the object.
    give: f32,
    half_thickness: f32,
    /// 1 where the phalanx slides towards its joint on the object, -1 where it slides away from it.
    slides: f32,
    length_scale: f32,
    stiffness_scale: f32,
}

impl<const N: usize, B: BaseJoint> Start<N, B> {
    /// 1 where bearings rubbed before the contact, because the joints turned; 0 of a finger that stood at its stops.
    fn rubbed(&self) -> f32 {
        if B::stands_at_stops(&self.stiffness) {
            0.0
        } else {
            1.0
        }
    }

    /// Of a compliance in metre per newton.
    fn give_scale(&self) -> f32 {
        self.stiffness_scale / (self.length_scale * self.length_scale)
    }
}

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Finger<N, T, B> {
    /// See [`super::Mechanics::path`].
    pub(crate) fn start(
        &self,
        at: &Configuration<N>,
        torque_nm: f32,
        contact: Contact,
    ) -> Option<Path<N, B>> {
        let Contact {
            phalanx,
            k_m,
            radius_m,
        } = contact;
        let before = phalanx.checked_sub(1)?;
        let length = *self.parameters.lengths_m.get(usize::from(before))?;
        if !(k_m > 0.0 && k_m <= length && radius_m >= 0.0 && torque_nm.is_finite()) {
            return None;
        }
        let length_scale = self.parameters.lengths_m.iter().sum::<f32>();
        let stiffness_scale = match self.base.return_cable() {
            Some(cable) => cable.stiffness_nm_per_rad,
            None => {
                (self.parameters.stiffness_nm_per_rad.iter()).fold(0.0f32, |m, k| k.at_least(m))
            }
        };
        let preload =
            (self.base.preload_nm()).map_or(0.0, |preload_nm| preload_nm / stiffness_scale);
        let mut start = Start {
            from: *at,
            base: self.base,
            torque: torque_nm / stiffness_scale,
            before,
            sense: [1.0; N],
            taken: [0.0; N],
            back: [0.0; N],
            lengths: self.parameters.lengths_m.map(|l| l / length_scale),
            stiffness: self
                .parameters
                .stiffness_nm_per_rad
                .map(|k| k / stiffness_scale),
            radius: radius_m / length_scale,
            weight: [0.0; 2],
            held: [preload; N],
            braked: 0.0,
            friction: 0.0,
            give: 0.0,
            half_thickness: 0.0,
            slides: 1.0,
            length_scale,
            stiffness_scale,
        };
        let last = self.begun(&start, k_m / length_scale)?;
        start.sense = last.tangent.delta.map(f32::signum);
        Some(Path { start, last })
    }

    /// The instant of contact, without force.
    fn at_contact(&self, start: &Start<N, B>, k: f32) -> Option<(Unknown<N>, Linearization<N>)> {
        let at = Unknown {
            delta: [0.0; N],
            force: 0.0,
            k,
        };
        Some((at, start.local(&self.transmission, &at, 0.0)?))
    }

    /// Where the joints begin to turn: at contact, or where what holds joint 2 at its stop lets them. None where such a contact would
    /// not press, or never makes them turn.
    fn begun(&self, start: &Start<N, B>, k: f32) -> Option<PathState<N>> {
        let (mut at, mut local) = self.at_contact(start, k)?;
        let mut rise = 0.0;
        if B::HOLDS {
            [rise, at.force] = local.break_away()?;
            local = start.local(&self.transmission, &at, rise)?;
        }
        let tangent = local.tangent()?;
        let presses = tangent.force > 0.0 && local.compliance(&tangent) >= 0.0;
        presses.then_some(PathState {
            at,
            rise,
            tangent,
            before: (tangent, 0.0),
        })
    }

    /// The finger at the last point of a path; `None` where it is not stable there.
    pub fn pressed(&self, path: &Path<N, B>) -> Option<Pressed<N>> {
        let Path { start, last } = path;
        let at = &last.at;
        let local = start.local(&self.transmission, at, last.rise)?;
        let tangent = local.tangent()?;
        let now = start.from.advanced(&JointStep::of(at.delta));
        let scale = start.stiffness_scale;
        Some(Pressed {
            contact: Contact {
                phalanx: start.before + 1,
                k_m: at.k * start.length_scale,
                radius_m: start.radius * start.length_scale,
            },
            k_now_m: self.on_phalanx(start, local.k_now)?,
            force_n: at.force * scale / start.length_scale,
            joints_rad: now.rad(),
            x: local.x,
            stiffness_nm_per_rad: local.stiffness.map(|row| row.map(|h| h * scale)),
            arms_m: local.arms.map(|arm| arm * start.length_scale),
            tangent_per_nm: tangent.delta.map(|delta| delta / scale),
            lengths_m: self.parameters.lengths_m,
            turn: now.turn(),
        })
    }

    /// See [`super::Mechanics::follow`].
    pub(crate) fn continue_to(&self, path: &mut Path<N, B>, rise_nm: f32) -> Option<PathPoint> {
        let rise = rise_nm / path.start.stiffness_scale;
        if !rise.is_finite() {
            return None;
        }
        let (start, from) = (&path.start, &path.last);
        if B::HOLDS {
            let (_, at_contact) = self.at_contact(start, from.at.k)?;
            let [break_away, _] = at_contact.break_away()?;
            if rise < break_away * (1.0 + TANGENT_SHARE) {
                return self.held_point(start, &self.begun(start, from.at.k)?, rise);
            }
        }
        let near = self
            .newton(start, from, rise)
            .or_else(|| self.newton_in_pieces(start, from, rise))?;
        let (point, last) = self.point(start, from, &near, rise)?;
        path.last = last;
        Some(point)
    }

    /// The point of a finger whose joint 2 is still held at its stop, `begun` where it gives way. Its rotation is negative, how far the
    /// tangent of the path leads back from there: the finger is rigid. The derivatives are those at break-away.
    fn held_point(
        &self,
        start: &Start<N, B>,
        begun: &PathState<N>,
        rise: f32,
    ) -> Option<PathPoint> {
        let (point, _) = self.point(start, begun, &begun.at, begun.rise)?;
        let missing_nm = (rise - begun.rise) * start.stiffness_scale;
        // Joint 1 alone balances the contact.
        let share = rise / begun.rise;
        let force_n = point.force_n * share;
        let rotation_rad = point.compliance_rad_per_nm * missing_nm;
        let presses = share >= 0.0 && force_n.is_finite() && rotation_rad.is_finite();
        presses.then_some(PathPoint {
            rotation_rad,
            force_n,
            force_by_friction_n: point.force_by_friction_n * share,
            joints_rad: [0.0; MAX_PHALANGES],
            ..point
        })
    }

    /// As [`Finger::newton`], where that does not reach so far in one piece.
    // Not inlined: it is seldom needed, and its points would lie in the frame of who follows a path.
    #[inline(never)]
    fn newton_in_pieces(
        &self,
        start: &Start<N, B>,
        from: &PathState<N>,
        rise: f32,
    ) -> Option<Unknown<N>> {
        let mut station = *from;
        for piece in 1..PIECES {
            let next = from.rise + (rise - from.rise) * (f32::from(piece) / f32::from(PIECES));
            let near = self.newton(start, &station, next)?;
            (_, station) = self.point(start, &station, &near, next)?;
        }
        self.newton(start, &station, rise)
    }

    /// What a user wants to know of the point that `near` is near to, after the last step of Newton's method; `None` where
    /// the contact would be off the phalanx or pull.
    fn point(
        &self,
        start: &Start<N, B>,
        from: &PathState<N>,
        near: &Unknown<N>,
        rise: f32,
    ) -> Option<(PathPoint, PathState<N>)> {
        let local = start.local(&self.transmission, near, rise)?;
        let Responses {
            step,
            tangent,
            by_k,
            by_friction,
            force_by_friction,
            by_joint_friction,
            by_loss: by_ln_loss,
            by_give,
        } = local.responses(near.force)?;
        let mut at = *near;
        at.add(&step.into())?;
        let stable = local.compliance(&tangent);
        let mut compliance = stable + local.rubbed_compliance(&tangent);
        let [loss, _] = T::JOINT_LOSS;
        let (mut compliance_by_loss, mut rotation_by_loss) = (0.0, 0.0);
        if loss > 0.0 {
            let lost = local.lost_compliance(&tangent);
            compliance += lost;
            compliance_by_loss = -lost / (loss * start.stiffness_scale);
            rotation_by_loss = by_ln_loss / loss;
        }
        // Pulleys still keep a joint from turning back.
        let is_held = loss > 0.0 && dot(&start.back, &at.delta) > 0.0;
        let compliance = compliance.at_least(0.0) / start.stiffness_scale;
        let step = JointStep::of(at.delta);
        let rotation_rad =
            self.transmission.turned_rad(&start.from, &step)? + start.braked * by_joint_friction;
        let reach = start.lengths.get(usize::from(start.before))?;
        let stays = local.k_now > 0.0
            && local.k_now <= *reach
            && (at.force >= -f32::EPSILON || is_held)
            && stable >= 0.0;
        let force_scale = start.stiffness_scale / start.length_scale;
        let mut joints_rad = [0.0; MAX_PHALANGES];
        for (joint, delta) in joints_rad.iter_mut().zip(at.delta) {
            *joint = delta;
        }
        let point = PathPoint {
            rotation_rad,
            compliance_rad_per_nm: compliance,
            compliance_by_loss_rad_per_nm: compliance_by_loss,
            rotation_by_loss_rad: rotation_by_loss,
            rotation_by_k_rad_per_m: by_k / start.length_scale,
            rotation_by_friction_rad: by_friction,
            rotation_by_joint_friction_rad_per_nm: by_joint_friction / start.stiffness_scale,
            rotation_by_give_rad_n_per_m: by_give * start.give_scale(),
            k_now_m: self.on_phalanx(start, local.k_now)?,
            force_n: at.force.at_least(0.0) * force_scale,
            force_by_friction_n: force_by_friction * force_scale,
            joints_rad,
        };
        let finite = [rotation_rad, compliance, by_k, point.force_n]
            .iter()
            .all(|x| x.is_finite());
        let station = PathState {
            at,
            rise,
            tangent,
            before: (from.tangent, rise - from.rise),
        };
        (stays && finite).then_some((point, station))
    }

    /// A distance along the phalanx in metre; the change of scale may round past the tip.
    fn on_phalanx(&self, start: &Start<N, B>, k: f32) -> Option<f32> {
        let length_m = self.parameters.lengths_m.get(usize::from(start.before))?;
        Some((k * start.length_scale).at_most(*length_m))
    }
}
