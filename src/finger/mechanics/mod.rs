//! What sensing asks of a finger, for any number of phalanges and any transmission.

mod candidates;
mod implementation;

use super::Mounting;
pub use candidates::{Candidate, Candidates, Class, Inverse, MOST_CANDIDATES};

/// Most phalanges of a finger that a scene describes, and joints whose changes a [`PathPoint`] holds.
pub const MAX_PHALANGES: usize = 3;

/// Most phalanges of a finger that this crate can build.
pub const LONGEST_FINGER: usize = 6;

/// A posture of the finger without contact, with the torque that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free<C> {
    /// Joint angles.
    pub configuration: C,
    /// Torque at the input link, newton metre.
    pub torque_nm: f32,
}

/// Where a phalanx touches, and what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Phalanx in contact, 1 for the proximal one.
    pub phalanx: u8,
    /// Distance of the contact from the phalanx's joint, metre, 0 < k <= l.
    pub k_m: f32,
    /// Effective contact radius, metre: the object's radius plus half the phalanx's thickness; 0 for a point.
    pub radius_m: f32,
}

/// One point of the path that the finger takes after contact as the torque rises (docs/MECHANICS.md#finite-torque-step).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathPoint {
    /// Change of the input link's angle since contact, against what [brakes](Mechanics::brake) the joints, radian. Negative while something
    /// holds the finger: while a return cable or a preloaded spring does, how far the path's tangent at break-away leads back; while other
    /// torque at a stop, or the friction of a pulley, keeps a joint from turning, the rotation in equilibrium with that torque as it acts
    /// once the joint turns.
    pub rotation_rad: f32,
    /// Slope of `rotation_rad` over torque at this point, radian per newton metre.
    pub compliance_rad_per_nm: f32,
    /// Derivative of that slope by the share of the torque that is lost at each joint beyond the first ([`Mechanics::JOINT_LOSS`]), radian
    /// per newton metre. Contact friction is left out: with a coefficient of 0.3 it is 0.5 to 0.8 of the whole on a finger of two
    /// phalanges, and without it 0.85 to 0.95, because the contact moves less as well.
    pub compliance_by_loss_rad_per_nm: f32,
    /// Derivative of `rotation_rad` by that share of the torque's rise, at this torque, radian. Not for a finger that is
    /// [held at a stop](Mechanics::HOLDS): there the share of what was overcome counts as well.
    pub rotation_by_loss_rad: f32,
    /// Derivative of `rotation_rad` by the place of the contact on the phalanx, at this torque, radian per metre.
    pub rotation_by_k_rad_per_m: f32,
    /// Derivative of `rotation_rad` by the coefficient of contact friction, at this torque and that coefficient, radian
    /// (docs/SENSING.md#contact-friction).
    pub rotation_by_friction_rad: f32,
    /// Derivative of `rotation_rad` by a torque that opposes the turning of each joint beyond the first (friction, or a
    /// spring that was held against its stop), at this torque, radian per newton metre. Where the joints turned before the contact friction
    /// in those that go on changes nothing, and in those that turn back it counts twice (docs/SENSING.md#a-joint-that-turns-back).
    pub rotation_by_joint_friction_rad_per_nm: f32,
    /// Derivative of `rotation_rad` by the compliance of the object, at this torque and that compliance, radian newton per metre
    /// (docs/MECHANICS.md#soft-objects).
    pub rotation_by_give_rad_n_per_m: f32,
    /// Where the contact is now, metre from the phalanx's joint (21).
    pub k_now_m: f32,
    /// Normal contact force, newton, at least 0: while a pulley keeps a joint from turning back no force is told.
    pub force_n: f32,
    /// Its derivative by the coefficient of contact friction, as `rotation_by_friction_rad`, newton.
    pub force_by_friction_n: f32,
    /// Change of each joint's angle since contact, radian; zero for joints that the finger does not have. Those beyond the
    /// third: [`Path::joint_changes_rad`](super::Path::joint_changes_rad).
    pub joints_rad: [f32; MAX_PHALANGES],
}

/// Joint 2 at the end of a contact path, for a sensor that reads it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointPoint {
    /// Its angle at contact, radian.
    pub at_contact_rad: f32,
    /// Change of its angle since contact, radian.
    pub rad: f32,
    /// Slope of that over the input torque, radian per newton metre.
    pub by_torque_rad_per_nm: f32,
    /// Its derivative by the place of the contact on the phalanx, at this torque, radian per metre.
    pub by_k_rad_per_m: f32,
    /// Its derivative by the coefficient of contact friction, as [`PathPoint::rotation_by_friction_rad`], radian.
    pub by_friction_rad: f32,
    /// Its derivative by a torque that opposes the turning of each joint beyond the first, as
    /// [`PathPoint::rotation_by_joint_friction_rad_per_nm`], radian per newton metre.
    pub by_joint_friction_rad_per_nm: f32,
}

/// A finger as sensing sees it: the number of phalanges and the transmission are hidden.
///
/// Torques and angles are those of the input link, closing positive. Every function returns `None` where a value is not
/// finite, the posture cannot be taken, or the finger is not stable there; nothing panics and no NaN comes out.
pub trait Mechanics {
    /// Number of phalanges.
    const PHALANGES: usize;
    /// The first phalanx that can touch anything: 1, or 2 where the first lies within the palm.
    const FIRST_TOUCHING: u8 = 1;
    /// Whether the finger goes on closing round an object after the first contact, so that a second one may follow: with three phalanges.
    /// Two hold each other after one contact.
    const MOVES_ON: bool = Self::PHALANGES > 2;
    /// Whether the stiffness of a cable that is not known decides which phalanx a contact is taken for: where the first lies within the
    /// palm, and where the motor turns joint 1 alone (docs/SENSING.md#which-phalanx).
    const CABLE_DECIDES: bool;
    /// Whether its leverage may differ from what the lengths say by percents, and from one contact to another.
    const UNEVEN: bool;
    /// Share, 0 to 1, of the doubt about the leverage (`leverage_sigma`) that is left after a calibration by pins.
    const PINS_LEAVE: f32;
    /// Whether something holds joint 2 at its stop until a contact has raised the torque by a break-away torque
    /// (docs/FINGERS.md#break-away).
    const HOLDS: bool;
    /// Share of the torque carried to each joint beyond the first that is lost there: mean and deviation. See [`Self::lose`].
    const JOINT_LOSS: [f32; 2];
    /// Whether the weight of its phalanges is stated ([`Weighted`](super::Weighted)).
    const WEIGHS: bool;
    /// Joint angles with their cosines and sines.
    type Configuration: Copy + core::fmt::Debug;
    /// A contact path under way; see [`Mechanics::path`].
    type Path: Clone + core::fmt::Debug;

    /// Torque with which a spring that is preloaded by design holds joint 2 at its stop, newton metre; paths have it, 0 elsewhere.
    fn preload_nm(&self) -> f32;

    /// The same finger mounted otherwise. Postures, torques and stiffnesses have its weight where it is stated; without, nothing changes.
    #[must_use]
    fn mounted(&self, mounting: Mounting) -> Self
    where
        Self: Sized;

    /// The posture of the springs' rest angles.
    fn rest(&self) -> Self::Configuration;

    /// Angle of the input link, theta_a, radian; it is zero where all joint angles are.
    fn input_angle_rad(&self, at: &Self::Configuration) -> f32;

    /// Angle of a joint relative to the phalanx before it, radian; joint 1 is the first.
    fn joint_rad(&self, at: &Self::Configuration, joint: u8) -> Option<f32>;

    /// Length of a phalanx, metre; phalanx 1 is the proximal one.
    fn phalanx_length_m(&self, phalanx: u8) -> Option<f32>;

    /// Posture and torque of the free finger at an input angle (6). `near` is where the search starts: the last sample.
    ///
    /// Without a spring at joint 1 (K_1 = 0) the torque is 0 and joint 1 follows the input link, the others rest. A return cable lets
    /// joint 1 alone turn as well.
    fn free_at_angle(
        &self,
        theta_a_rad: f32,
        near: &Self::Configuration,
    ) -> Option<Free<Self::Configuration>>;

    /// The same of a finger that closes, with what is expected to be lost on the way to the joints ([`Self::JOINT_LOSS`]).
    fn closing_at_angle(
        &self,
        theta_a_rad: f32,
        near: &Self::Configuration,
    ) -> Option<Free<Self::Configuration>>;

    /// Posture of the free finger at an input torque (6). Without a spring at joint 1 only torque 0 has one, and joint
    /// 1 stays where `near` has it. A return cable holds the finger at rest up to a torque.
    fn free_at_torque(
        &self,
        torque_nm: f32,
        near: &Self::Configuration,
    ) -> Option<Self::Configuration>;

    /// A finger without a spring at joint 1 whose weight the input link holds with `torque_nm` (negative where the weight
    /// closes it): `free` as that leaves it, and the torque that would then hold joint 2 at its lower stop (negative where the
    /// weight lifts it off, 0 where it is not there in `free`). `preload_nm` is what the springs hold their joints at the stops
    /// with in `free`. The mass is taken to be even along phalanges that are about in line. None of any other finger.
    fn weighed(
        &self,
        free: &Free<Self::Configuration>,
        torque_nm: f32,
        preload_nm: f32,
    ) -> Option<(Free<Self::Configuration>, f32)>;

    /// Secant stiffness K_a' of the free finger from rest to `free` (7), newton metre per radian; 0 without a spring at
    /// joint 1.
    fn expected_k_a(&self, free: &Free<Self::Configuration>) -> Option<f32>;

    /// Compliance of the finger without contact, radian per newton metre (docs/MECHANICS.md#preshaping). None where
    /// nothing holds it (K_1 = 0).
    fn free_compliance(&self, at: &Self::Configuration, torque_nm: f32) -> Option<f32>;

    /// Compliance with a contact on phalanx 1, anywhere on it, radian per newton metre
    /// (docs/MECHANICS.md#contact-stiffness).
    fn proximal_compliance(&self, at: &Self::Configuration, torque_nm: f32) -> Option<f32>;

    /// Compliance with the softest contact that a closing finger can make, radian per newton metre: anywhere on phalanx 1,
    /// or at the tip where the motor turns joint 1 alone ([`super::Direct`]).
    fn softest_compliance(&self, at: &Self::Configuration, torque_nm: f32) -> Option<f32>;

    /// Compliance 1/K_c with a contact at `k_m` on `phalanx` at the instant of contact (18), radian per newton metre.
    fn contact_compliance(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        phalanx: u8,
        k_m: f32,
    ) -> Option<f32>;

    /// All places where a contact explains a tangent compliance, by bisection: 24 halvings a root, on a residual that is
    /// bounded and monotone either side of the stiffest place (docs/MECHANICS.md#contact-stiffness).
    ///
    /// `torque_nm` holds the finger in equilibrium in the posture `at`; `compliance_rad_per_nm` is that of the finger
    /// alone, 1/K_c, not negative. [`Inverse::class`] says what the compliance implies (docs/MECHANICS.md#observability).
    /// Error against 50 digits over random fingers: median 3e-6, largest 1e-4 % of the phalanx (docs/report).
    fn locate(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        compliance_rad_per_nm: f32,
    ) -> Inverse;

    /// The same by the stable closed form: checks [`Mechanics::locate`] in tests and in the report, the firmware does not
    /// call it.
    fn locate_closed(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        compliance_rad_per_nm: f32,
    ) -> Inverse;

    /// Starts the path after a contact made at `torque_nm` in equilibrium (tau = 0). None where such a contact would not
    /// press as the finger closes, or lies off the phalanx.
    fn path(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        contact: Contact,
    ) -> Option<Self::Path>;

    /// Makes the finger's weight act along a path that has just begun (docs/SENSING.md#gravity). `weight` is the torque with
    /// which the input link held the weight at contact, newton metre, and the derivative of that torque by the input angle, newton
    /// metre per radian; `held_nm`, from 0, what it presses the joints beyond the first on their stops with, newton metre. Assumes
    /// even mass and phalanges in line at contact, as [`Mechanics::weighed`] does.
    fn load(&self, path: &mut Self::Path, weight: [f32; 2], held_nm: f32);

    /// Makes friction, or a preload that a spring is held at its stop with, oppose the turning of each joint beyond the first along a path
    /// that has just begun, in the sense in which it begins to turn, newton metre. A finger that stands at its stops has it in the
    /// balance of its joints; where joints turned before it acts by [`PathPoint::rotation_by_joint_friction_rad_per_nm`]
    /// (docs/SENSING.md#torque-that-holds-the-joints). Before [`Mechanics::rub`].
    fn brake(&self, path: &mut Self::Path, torque_nm: f32);

    /// Makes the object give way along a path that has just begun, across the phalanx, by a compliance from 0, metre per newton
    /// (docs/MECHANICS.md#soft-objects). Before [`Mechanics::rub`]. Not for a finger that a preload holds at its stops. None where
    /// such a contact would not press; with a value that is not finite the path cannot be followed.
    fn soften(&self, path: &mut Self::Path, compliance_m_per_n: f32) -> Option<()>;

    /// Takes off what is lost on the way to the joints ([`Self::JOINT_LOSS`]) along a path that has just begun, in the sense in which each
    /// joint begins to turn: a few turn in the other sense later (docs/SENSING.md#a-joint-that-turns-back). The free finger closed all
    /// joints; where one turns back, the loss that there was at contact changes its sign as well, and the joint stands until the torque
    /// has made up for that. Before [`Mechanics::rub`].
    fn lose(&self, path: &mut Self::Path);

    /// Makes contact friction of a coefficient from 0 act along a path that has just begun, on the surface of a phalanx that lies
    /// `half_thickness_m` from its centre line (docs/SENSING.md#contact-friction). It acts against the sense in which the phalanx begins
    /// to slide on the object. Where less holds the contact in its place, no more acts: a finger of two phalanges is rigid then. None
    /// where the finger is not stable; with a value that is not finite the path cannot be followed.
    fn rub(&self, path: &mut Self::Path, friction: f32, half_thickness_m: f32) -> Option<()>;

    /// Follows the path until the input torque has risen by `rise_nm` since contact. Starts from the last point found, so
    /// that rising torques cost little. A rise instead of a torque, because the difference of two torques would round.
    /// None where the contact is lost, slides off its phalanx, or equilibrium is not found; the path then stays where it
    /// was.
    fn follow(&self, path: &mut Self::Path, rise_nm: f32) -> Option<PathPoint>;

    /// Joint 2 at the end of a path. None for a finger of one phalanx.
    fn joint_2(&self, path: &Self::Path) -> Option<JointPoint>;

    /// The place of a contact from one finite step: the `k` with which the path of `guess` turns the input link by
    /// `rotation_rad` while the torque rises by `rise_nm`, both since contact (docs/MECHANICS.md#finite-torque-step);
    /// also the point reached. `guess`
    /// chooses the branch: a path started at a candidate of the tangent inverse. None where no such place is found on
    /// the phalanx.
    fn place(
        &self,
        guess: &Self::Path,
        rise_nm: f32,
        rotation_rad: f32,
    ) -> Option<(f32, PathPoint)>;

    /// Stiffest place of a phalanx: e_2 (27) and its counterparts with more phalanges, metre; it may lie off the
    /// phalanx.
    fn stiffest_m(&self, at: &Self::Configuration, torque_nm: f32, phalanx: u8) -> Option<f32>;
}
