//! Errors in the description of a world.

/// Why a plant cannot be built. Every variant names the key, what was found and what is allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The file is not TOML.
    #[error("not a TOML file: {0}")]
    Syntax(String),
    /// No such scene, or one with a wrong value.
    #[error("{0}")]
    Scene(String),
    /// No such parameter.
    #[error("unknown key `{key}`; expected one of: {expected}")]
    UnknownKey {
        /// Full path of the key.
        key: String,
        /// The keys that exist there.
        expected: String,
    },
    /// A value of another type than the default's.
    #[error("`{key}` is {found}, expected {expected}")]
    WrongType {
        /// Full path of the key.
        key: String,
        /// Type found.
        found: &'static str,
        /// Type needed.
        expected: &'static str,
    },
    /// A number outside its range, or not a number.
    #[error("`{key}` = {value} is out of range, allowed {min} to {max}")]
    OutOfRange {
        /// Full path of the key.
        key: String,
        /// What was given.
        value: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
    },
    /// A list of the wrong length.
    #[error("`{key}` has {found} numbers, expected {expected}")]
    WrongLength {
        /// Full path of the key.
        key: String,
        /// Number of values found.
        found: usize,
        /// Number of values needed.
        expected: usize,
    },
    /// A finger has none, or more than one, of pulleys, levers and motors at every joint.
    #[error(
        "`{key}` needs one of pulley_m, held_backlash_deg, or lever_m with coupler_m, driven_m, offset_deg and mode"
    )]
    Transmission {
        /// Path of the finger.
        key: String,
    },
    /// A four-bar that cannot be assembled somewhere in its joint's range.
    #[error(
        "four-bar {stage} of `{key}` does not close at {angle_deg} deg: change its lengths or the joint's range"
    )]
    Open {
        /// Path of the finger.
        key: String,
        /// First or second stage, from 1.
        stage: usize,
        /// Joint angle, degree.
        angle_deg: f64,
    },
    /// An engine of another crate is not available or refuses the model.
    #[error("{0}")]
    Engine(String),
    /// The given contact is not on the finger or never reached.
    #[error("no such contact: {0}")]
    Contact(String),
}

impl Error {
    /// The object overlaps the finger by this depth (metre).
    #[must_use]
    pub fn overlap(depth_m: f64) -> Self {
        Self::Contact(format!(
            "the object overlaps the finger by {:.1} mm",
            1e3 * depth_m
        ))
    }
}
