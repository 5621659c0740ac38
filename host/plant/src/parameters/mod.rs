//! Parameters of the simulated world: nominal values of a scene, additions of `default.toml`, replacements of a user's file.

mod fingers;
mod load;
mod object;
mod scenes;
mod sections;
mod spread;
mod stated;
mod temperature;

pub use fingers::FingerParameters;
pub use load::World;
pub use object::{Object, ObjectMount};
pub use scenes::{default_scene, scenes};
pub use sections::{
    Bridge, Cable, Choke, Contact, Converter, Encoder, Friction, Gearhead, Hall, Mechanism, Motor,
    Sense, Supply, Transmission, Worm,
};

use crate::Error;
use serde::Deserialize;

/// Values that the default world adds to a scene, each with its source.
pub const DEFAULT_TOML: &str = include_str!("../../default.toml");

/// Checks one number; NaN is out of every range.
pub(crate) fn within(key: &str, value: f64, min: f64, max: f64) -> Result<(), Error> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            key: key.to_owned(),
            value,
            min,
            max,
        })
    }
}

/// What computes finger and object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// This crate.
    #[default]
    Plant,
    /// MuJoCo: the crate `palpate-mujoco`.
    Mujoco,
}

impl std::str::FromStr for Engine {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "plant" => Ok(Self::Plant),
            "mujoco" => Ok(Self::Mujoco),
            _ => Err(format!(
                "there is no engine '{name}'; there are: plant, mujoco"
            )),
        }
    }
}

impl std::fmt::Display for Engine {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Plant => "plant",
            Self::Mujoco => "mujoco",
        })
    }
}

/// All parameters of the simulated world, SI units unless the name says otherwise.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Parameters {
    /// What computes finger and object; from [`World::engine`], not from the file.
    #[serde(skip)]
    pub engine: Engine,
    /// Name of the scene whose nominal values these are, or were before something was changed.
    pub scene: String,
    /// Motor.
    pub motor: Motor,
    /// Gearhead.
    pub gearhead: Gearhead,
    /// Worm and wheel.
    pub worm: Worm,
    /// Cable.
    pub cable: Cable,
    /// Changing friction.
    pub friction: Friction,
    /// Errors of the transmission.
    pub transmission: Transmission,
    /// Encoder.
    pub encoder: Encoder,
    /// Current sense.
    pub sense: Sense,
    /// Bridge.
    pub bridge: Bridge,
    /// Coil in series with the motor.
    pub choke: Choke,
    /// Supply.
    pub supply: Supply,
    /// Inputs of the converters.
    pub converter: Converter,
    /// Angle sensor at joint 2.
    pub hall: Hall,
    /// Object against phalanx.
    pub contact: Contact,
    /// How the object is held.
    pub object: Object,
    /// What all fingers have in common.
    pub mechanism: Mechanism,
    /// The finger.
    pub finger: FingerParameters,
}

impl Default for Parameters {
    /// The default scene in the default world.
    fn default() -> Self {
        // Both are embedded in the program; a test reads every scene.
        Self::from_toml("").expect("default.toml is valid")
    }
}

impl Parameters {
    /// Checks every value against its range, as [`Parameters::from_toml`] does: for values set in code.
    ///
    /// # Errors
    /// [`Error`] naming the first bad key, its value and its range.
    pub fn validate(&self) -> Result<(), Error> {
        self.motor.validate("motor")?;
        self.gearhead.validate("gearhead")?;
        self.worm.validate("worm")?;
        self.cable.validate("cable")?;
        self.friction.validate("friction")?;
        self.transmission.validate("transmission")?;
        self.encoder.validate("encoder")?;
        self.sense.validate("sense")?;
        self.bridge.validate("bridge")?;
        self.choke.validate("choke")?;
        self.supply.validate("supply")?;
        self.converter.validate("converter")?;
        self.hall.validate("hall")?;
        self.contact.validate("contact")?;
        self.object.validate("object")?;
        self.mechanism.validate("mechanism")?;
        self.finger.validate("finger")
    }

    /// Gear ratio from the motor to the input link.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.gearhead.ratio * self.worm.ratio
    }

    /// Encoder counts for a radian of the input link.
    #[must_use]
    pub fn counts_per_rad(&self) -> f64 {
        self.encoder.counts_per_rev * self.ratio() / std::f64::consts::TAU
    }

    /// Whether the current follows every edge of the PWM.
    #[must_use]
    pub fn has_edges(&self) -> bool {
        self.bridge.edges > 0.5
    }

    /// What the current sense shows of a current along the drive, relative to it, at a duty (0 to 1): gain, curvature and, without
    /// edges, the share that its delay loses; with them a delay moves the reading and leaves its mean.
    #[must_use]
    pub fn sensed_share(&self, current_a: f64, duty: f64) -> f64 {
        let sense = &self.sense;
        let late = if self.has_edges() {
            0.0
        } else {
            sense.settling_s * self.bridge.pwm_hz * (1.0 - duty)
        };
        let bent = sense.nonlinearity * current_a / sense.full_scale_a();
        (1.0 + sense.gain_error + bent) * (1.0 - late)
    }

    /// Elastic stiffness of the cable at the input link, newton metre per radian.
    #[must_use]
    pub fn cable_stiffness_nm_per_rad(&self) -> f64 {
        self.cable.stiffness_n_per_m * self.cable.pulley_radius_m * self.cable.pulley_radius_m
    }
}
