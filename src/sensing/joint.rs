//! The optional sensor of theta_2, as a type: a finger without one carries no trace of it.

/// How joint 2 is measured.
pub trait JointSensor {
    /// A reading, kept with each block.
    type Reading: Copy + Default + core::fmt::Debug;
    /// Change of theta_2 between two readings, radian; None without a sensor.
    fn change_rad(from: Self::Reading, to: Self::Reading) -> Option<f32>;
}

/// No sensor.
#[derive(Clone, Copy, Debug)]
pub struct NoHall;

impl JointSensor for NoHall {
    type Reading = ();
    fn change_rad(_from: (), _to: ()) -> Option<f32> {
        None
    }
}

/// A Hall sensor at joint 2: its sign tells on which side of e_2 the contact lies (MATH 6).
#[derive(Clone, Copy, Debug)]
pub struct Hall;

impl Hall {
    /// Deviation of a change of theta_2 from the truth, radian: 0.2 degree, a few millivolt of such a sensor.
    pub const SIGMA_RAD: f32 = 3.5e-3;
}

impl JointSensor for Hall {
    type Reading = Option<f32>;
    fn change_rad(from: Option<f32>, to: Option<f32>) -> Option<f32> {
        Some(to? - from?).filter(|change| change.is_finite())
    }
}
