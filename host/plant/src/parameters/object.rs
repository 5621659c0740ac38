//! How the object is held.

use super::within;
use crate::Error;
use serde::Deserialize;

/// What holds the object. This crate's own engine has no free ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ObjectMount {
    /// It does not move.
    #[default]
    Fixed,
    /// On springs: along both axes of the plane, in this crate's own engine along the contact's normal.
    Spring,
    /// Free in the plane; gravity acts on it as on the finger.
    Free,
}

impl std::str::FromStr for ObjectMount {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "fixed" => Ok(Self::Fixed),
            "spring" => Ok(Self::Spring),
            "free" => Ok(Self::Free),
            _ => Err(format!(
                "there is no mount '{name}'; there are: fixed, spring, free"
            )),
        }
    }
}

/// The object, whatever its shape.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Object {
    /// What holds it.
    pub mount: ObjectMount,
    /// Mass, kilogram.
    pub mass_kg: f64,
    /// Of the springs, newton per metre.
    pub stiffness_n_per_m: f64,
    /// Of the springs, newton second per metre.
    pub damping_n_s_per_m: f64,
}

impl Object {
    pub(super) fn validate(&self, section: &str) -> Result<(), Error> {
        let numbers = [
            ("mass_kg", self.mass_kg, 1e-3, 100.0),
            ("stiffness_n_per_m", self.stiffness_n_per_m, 1.0, 1e7),
            ("damping_n_s_per_m", self.damping_n_s_per_m, 0.0, 1e4),
        ];
        numbers.into_iter().try_for_each(|(key, value, min, max)| {
            within(&format!("{section}.{key}"), value, min, max)
        })
    }
}
