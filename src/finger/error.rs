//! Why a finger cannot be built, or a posture not taken.

/// The parameter that an error is about. Joints, phalanges and stages are numbered from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Length l_i of a phalanx.
    Length {
        /// Which phalanx.
        phalanx: u8,
    },
    /// Stiffness K_i of a joint's spring.
    Stiffness {
        /// Which joint.
        joint: u8,
    },
    /// Rest angle of a joint's spring.
    RestAngle {
        /// Which joint.
        joint: u8,
    },
    /// Opening stop of a joint.
    LowerStop {
        /// Which joint.
        joint: u8,
    },
    /// Closing stop of a joint.
    UpperStop {
        /// Which joint.
        joint: u8,
    },
    /// Angle of a joint.
    JointAngle {
        /// Which joint.
        joint: u8,
    },
    /// Radius r_i of a pulley.
    PulleyRadius {
        /// Which pulley, as the paper numbers them.
        pulley: u8,
    },
    /// Driving lever a of a four-bar stage.
    DrivingLever {
        /// Which stage; stage 1 drives phalanx 2.
        stage: u8,
    },
    /// Coupler b of a four-bar stage.
    Coupler {
        /// Which stage.
        stage: u8,
    },
    /// Driven lever c of a four-bar stage.
    DrivenLever {
        /// Which stage.
        stage: u8,
    },
    /// Offset angle psi of a stage's driven lever.
    LeverOffset {
        /// Which stage.
        stage: u8,
    },
    /// Distance between the tips of a stage's ground and driven lever at some angle of the joint range: with it the
    /// coupler does not reach.
    Closure {
        /// Which stage.
        stage: u8,
    },
    /// Stiffness of the cable between actuator and input link.
    CableStiffness,
    /// Torque with which a spring holds a joint at its stop.
    Preload,
    /// Radius of a return cable's pulley at joint 2 over that at joint 1.
    ReturnRatio,
    /// Torque of a return cable about joint 1 at rest.
    ReturnTorque,
    /// Stiffness of a return cable about joint 1.
    ReturnStiffness,
    /// Weight of a phalanx.
    Weight {
        /// Which phalanx.
        phalanx: u8,
    },
    /// Direction of gravity.
    Gravity,
}

/// A value outside its allowed range, whose limits belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    /// What was out of range.
    pub parameter: Parameter,
    /// The value given (or, for [`Parameter::Closure`], reached), in the parameter's unit.
    pub value: f32,
    /// Lower limit.
    pub min: f32,
    /// Upper limit.
    pub max: f32,
}

impl ConfigError {
    /// What was out of range, in words, for the compiler to say of a scene.
    pub const fn what(&self) -> &'static str {
        match self.parameter {
            Parameter::Length { .. } => "length of a phalanx",
            Parameter::Stiffness { .. } => "stiffness of a joint's spring",
            Parameter::RestAngle { .. } => "rest angle of a spring",
            Parameter::LowerStop { .. } => "opening stop of a joint",
            Parameter::UpperStop { .. } => "closing stop of a joint",
            Parameter::JointAngle { .. } => "angle of a joint",
            Parameter::PulleyRadius { .. } => "radius of a pulley",
            Parameter::DrivingLever { .. } => "driving lever of a stage",
            Parameter::Coupler { .. } => "coupler of a stage",
            Parameter::DrivenLever { .. } => "driven lever of a stage",
            Parameter::LeverOffset { .. } => "offset angle of a stage's driven lever",
            Parameter::Closure { stage: 1 } => "linkage 1 does not close: reach of its coupler",
            Parameter::Closure { stage: 2 } => "linkage 2 does not close: reach of its coupler",
            Parameter::Closure { .. } => {
                "linkage 3 or a later one does not close: reach of its coupler"
            }
            Parameter::CableStiffness => "stiffness of the cable",
            Parameter::Preload => "preload of a spring",
            Parameter::ReturnRatio => "ratio of the return cable's pulleys",
            Parameter::ReturnTorque => "torque of the return cable",
            Parameter::ReturnStiffness => "stiffness of the return cable",
            Parameter::Weight { .. } => "weight of a phalanx",
            Parameter::Gravity => "direction of gravity",
        }
    }
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            parameter,
            value,
            min,
            max,
        } = self;
        if let Parameter::Closure { stage } = parameter {
            return write!(
                f,
                "linkage {stage} does not close: its coupler's ends would be {value} apart as seen from joint {stage}, \
                 driving lever and coupler reach {min} to {max}"
            );
        }
        write!(
            f,
            "{parameter:?} is {value}, must lie within {min} and {max}"
        )
    }
}

impl core::error::Error for ConfigError {}

/// The value of a `Result`, or back with its error: what `?` does, which constants cannot.
macro_rules! try_const {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}
pub(crate) use try_const;

/// `value` if it is finite and `min <= value <= max`.
pub(crate) const fn check_range(
    parameter: Parameter,
    value: f32,
    min: f32,
    max: f32,
) -> Result<f32, ConfigError> {
    if value >= min && value <= max {
        Ok(value)
    } else {
        Err(ConfigError {
            parameter,
            value,
            min,
            max,
        })
    }
}
