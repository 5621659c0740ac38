//! Implements the questions of sensing for every finger of this crate.

use super::{Contact, Free, Inverse, JointPoint, Mechanics, PathPoint};
use crate::finger::inverse::{Bisection, ClosedForm, ContactStatics, PostureStiffness};
use crate::finger::path::Path;
use crate::finger::{BaseJoint, Configuration, Finger, Mounting, Transmission};

impl<const N: usize, T: Transmission<N>, B: BaseJoint> Mechanics for Finger<N, T, B>
where
    PostureStiffness<N>: ContactStatics,
{
    const PHALANGES: usize = N;
    const FIRST_TOUCHING: u8 = B::FIRST_TOUCHING;
    const CABLE_DECIDES: bool = B::FIRST_TOUCHING > 1 || !T::COUPLES;
    const UNEVEN: bool = T::UNEVEN;
    const PINS_LEAVE: f32 = B::PINS_LEAVE;
    const HOLDS: bool = B::HOLDS;
    const JOINT_LOSS: [f32; 2] = T::JOINT_LOSS;
    const WEIGHS: bool = B::WEIGHS;
    type Configuration = Configuration<N>;
    type Path = Path<N, B>;

    fn preload_nm(&self) -> f32 {
        self.base.preload_nm().unwrap_or(0.0)
    }

    fn mounted(&self, mounting: Mounting) -> Self {
        self.mounted(mounting)
    }

    fn rest(&self) -> Self::Configuration {
        self.rest
    }

    fn input_angle_rad(&self, at: &Self::Configuration) -> f32 {
        self.transmission.rotation_rad(at)
    }

    fn joint_rad(&self, at: &Self::Configuration, joint: u8) -> Option<f32> {
        at.rad().get(usize::from(joint).checked_sub(1)?).copied()
    }

    fn phalanx_length_m(&self, phalanx: u8) -> Option<f32> {
        self.parameters
            .lengths_m
            .get(usize::from(phalanx).checked_sub(1)?)
            .copied()
    }

    fn free_at_angle(
        &self,
        theta_a_rad: f32,
        near: &Self::Configuration,
    ) -> Option<Free<Self::Configuration>> {
        self.free_under_weight(theta_a_rad, near, 0.0)
    }

    fn closing_at_angle(
        &self,
        theta_a_rad: f32,
        near: &Self::Configuration,
    ) -> Option<Free<Self::Configuration>> {
        self.free_under_weight(theta_a_rad, near, T::JOINT_LOSS[0])
    }

    fn free_at_torque(
        &self,
        torque_nm: f32,
        near: &Self::Configuration,
    ) -> Option<Self::Configuration> {
        self.preshape(torque_nm, near)
    }

    fn weighed(
        &self,
        free: &Free<Self::Configuration>,
        torque_nm: f32,
        preload_nm: f32,
    ) -> Option<(Free<Self::Configuration>, f32)> {
        self.under_weight(free, torque_nm, preload_nm)
    }

    fn expected_k_a(&self, free: &Free<Self::Configuration>) -> Option<f32> {
        self.secant_stiffness(free)
    }

    fn free_compliance(&self, at: &Self::Configuration, torque_nm: f32) -> Option<f32> {
        self.free(at, torque_nm)
    }

    fn proximal_compliance(&self, at: &Self::Configuration, torque_nm: f32) -> Option<f32> {
        self.proximal_at(at, torque_nm)
    }

    fn softest_compliance(&self, at: &Self::Configuration, torque_nm: f32) -> Option<f32> {
        if T::COUPLES {
            self.proximal_compliance(at, torque_nm)
        } else {
            let tip_m = *self.parameters.lengths_m.last()?;
            self.contact_compliance(at, torque_nm, N as u8, tip_m)
        }
    }

    fn contact_compliance(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        phalanx: u8,
        k_m: f32,
    ) -> Option<f32> {
        self.compliance_at(at, torque_nm, phalanx, k_m)
    }

    fn locate(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        compliance_rad_per_nm: f32,
    ) -> Inverse {
        self.places::<Bisection>(at, torque_nm, compliance_rad_per_nm)
    }

    fn locate_closed(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        compliance_rad_per_nm: f32,
    ) -> Inverse {
        self.places::<ClosedForm>(at, torque_nm, compliance_rad_per_nm)
    }

    fn path(
        &self,
        at: &Self::Configuration,
        torque_nm: f32,
        contact: Contact,
    ) -> Option<Self::Path> {
        self.start(at, torque_nm, contact)
    }

    fn load(&self, path: &mut Self::Path, weight: [f32; 2], held_nm: f32) {
        self.weigh(path, weight, held_nm);
    }

    fn brake(&self, path: &mut Self::Path, torque_nm: f32) {
        Self::brakes(path, torque_nm);
    }

    fn soften(&self, path: &mut Self::Path, compliance_m_per_n: f32) -> Option<()> {
        self.gives(path, compliance_m_per_n)
    }

    fn lose(&self, path: &mut Self::Path) {
        Self::loses(path);
    }

    fn rub(&self, path: &mut Self::Path, friction: f32, half_thickness_m: f32) -> Option<()> {
        self.rubs(path, friction, half_thickness_m)
    }

    fn follow(&self, path: &mut Self::Path, rise_nm: f32) -> Option<PathPoint> {
        self.continue_to(path, rise_nm)
    }

    fn joint_2(&self, path: &Self::Path) -> Option<JointPoint> {
        self.second_joint(path)
    }

    fn place(
        &self,
        guess: &Self::Path,
        rise_nm: f32,
        rotation_rad: f32,
    ) -> Option<(f32, PathPoint)> {
        self.placed(guess, rise_nm, rotation_rad)
    }

    fn stiffest_m(&self, at: &Self::Configuration, torque_nm: f32, phalanx: u8) -> Option<f32> {
        self.stiffest_at(at, torque_nm, phalanx)
    }
}
