//! Identification of the motor: what the data sheet says of it, measured in place.
//!
//! Short pulses of two currents spin the motor up, between them it coasts to a stop with the bridge off: closing over one turn
//! of the worm, then opening until another pulse could lead back beyond where all began. Nothing but the drivetrain and a free
//! finger is moved, never against a stop, with less than the drive's limits. The equations are in
//! docs/SENSING.md#identification-of-the-motor.

mod estimator;
mod procedure;
#[cfg(test)]
mod tests;

use zerocopy::{FromBytes, Immutable, IntoBytes};

pub use procedure::{FREE_WAY_RAD, Identification, NotIdentified, Step};

/// What is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Resistance of the winding at 25 degrees Celsius and of the choke, ohm.
    Resistance,
    /// Torque constant, newton metre per ampere.
    TorqueConstant,
    /// Inertia of the rotor with what turns with it, kilogram square metre.
    Inertia,
    /// Torque that friction of motor and gears takes without load at the closing speed, newton metre at the motor.
    Friction,
    /// Time at every edge of the PWM in which no switch conducts, second.
    DeadTime,
}

impl Quantity {
    /// Every quantity, in the order of [`Identified::estimates`].
    pub const ALL: [Self; 5] = [
        Self::Resistance,
        Self::TorqueConstant,
        Self::Inertia,
        Self::Friction,
        Self::DeadTime,
    ];
}

/// A measured value, SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Estimate {
    /// The value.
    pub value: f32,
    /// Its standard deviation: scatter, tolerance of the sense and of the supply's divider, and what is not known of the winding's
    /// temperature.
    pub sigma: f32,
}

/// What an identification found.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Identified {
    /// One of each [`Quantity`].
    pub estimates: [Estimate; Quantity::ALL.len()],
}

impl Identified {
    /// The estimate of a quantity.
    pub fn of(&self, quantity: Quantity) -> Estimate {
        // One for each quantity.
        self.estimates
            .get(quantity as usize)
            .copied()
            .unwrap_or_default()
    }

    /// Whether every value is finite and its deviation positive: what a stored one must be.
    pub fn is_valid(&self) -> bool {
        self.estimates.iter().all(|estimate| {
            estimate.value.is_finite() && estimate.sigma > 0.0 && estimate.sigma < 1e9
        })
    }
}
