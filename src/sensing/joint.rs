//! The optional sensor of theta_2, as a type: a finger without one carries no trace of it.

/// How joint 2 is measured: [`NoHall`] or [`Hall`].
pub trait JointSensor: Copy + core::fmt::Debug {
    /// A reading, kept with each block.
    type Reading: Copy + Default + core::fmt::Debug + PartialEq;

    /// Deviation of a change of theta_2 from the truth, radian.
    const SIGMA_RAD: f32;

    /// Change of theta_2 between two readings.
    fn change(from: Self::Reading, to: Self::Reading) -> Self::Reading;

    /// A reading or a change, radian; None without a sensor or while it has no reading.
    fn rad(reading: Self::Reading) -> Option<f32>;

    /// The reading whose angle a recording tells, radian; without a sensor it is ignored.
    fn reading(rad: Option<f32>) -> Self::Reading;

    /// Which side of phalanx 2's stiffest place e_2 a change since contact indicates; None without a sensor.
    fn side(change: Self::Reading) -> Option<Side> {
        let change_rad = Self::rad(change)?;
        Some(if change_rad > SIDE_SIGMAS * Self::SIGMA_RAD {
            Side::Below
        } else if change_rad < -SIDE_SIGMAS * Self::SIGMA_RAD {
            Side::Beyond
        } else {
            Side::Unclear
        })
    }
}

/// Deviations that a change must exceed to speak for a side.
const SIDE_SIGMAS: f32 = 3.0;

/// Side of e_2 on which phalanx 2 is touched: below it the joint closes as the torque rises, beyond it the joint opens
/// (docs/MECHANICS.md#observability). Of a contact on another phalanx it says nothing certain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Between the joint and e_2.
    Below,
    /// Between e_2 and the tip.
    Beyond,
    /// The joint has not moved by more than its sensor's noise.
    Unclear,
}

/// No sensor.
#[derive(Clone, Copy, Debug)]
pub struct NoHall;

impl JointSensor for NoHall {
    type Reading = ();
    const SIGMA_RAD: f32 = f32::INFINITY;

    fn change(_: (), _: ()) {}

    fn rad(_: ()) -> Option<f32> {
        None
    }

    fn reading(_: Option<f32>) {}
}

/// A Hall sensor at joint 2: its sign shows on which side of e_2 the contact lies (docs/MECHANICS.md#observability).
#[derive(Clone, Copy, Debug)]
pub struct Hall;

impl JointSensor for Hall {
    type Reading = Option<f32>;
    // 0.2 degree, a few millivolt of such a sensor.
    const SIGMA_RAD: f32 = 3.5e-3;

    fn change(from: Option<f32>, to: Option<f32>) -> Option<f32> {
        Some(to? - from?)
    }

    fn rad(reading: Option<f32>) -> Option<f32> {
        reading.filter(|angle| angle.is_finite())
    }

    fn reading(rad: Option<f32>) -> Option<f32> {
        rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_of_the_change_is_the_side() {
        let side = |from, to| Hall::side(Hall::change(from, to));
        assert_eq!(side(Some(1.0), Some(1.02)), Some(Side::Below));
        assert_eq!(side(Some(1.0), Some(0.98)), Some(Side::Beyond));
        assert_eq!(side(Some(1.0), Some(1.01)), Some(Side::Unclear));
        for nothing in [None, Some(f32::NAN), Some(f32::INFINITY)] {
            assert_eq!(side(Some(1.0), nothing), None);
            assert_eq!(side(nothing, Some(1.0)), None);
        }
    }

    #[test]
    fn without_a_sensor_there_is_nothing() {
        NoHall::change((), ());
        assert_eq!(NoHall::side(()), None);
        assert_eq!(size_of::<<NoHall as JointSensor>::Reading>(), 0);
    }
}
