//! The object and how it is held.

use palpate_plant::ObjectMount;

/// How an object is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Mount {
    /// It does not move.
    #[default]
    Fixed,
    /// On springs along both axes of the plane.
    Spring {
        /// Newton per metre.
        stiffness_n_per_m: f64,
        /// Newton second per metre.
        damping_n_s_per_m: f64,
    },
    /// It slides and turns in the plane; gravity acts on it as on the finger.
    Free,
}

/// The object, whatever its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// Mass of the object, kilogram.
    pub object_kg: f64,
    /// How the object is held.
    pub mount: Mount,
}

impl Default for Surroundings {
    /// A fixed object.
    fn default() -> Self {
        Self {
            object_kg: 0.1,
            mount: Mount::Fixed,
        }
    }
}

impl From<&palpate_plant::Object> for Surroundings {
    fn from(object: &palpate_plant::Object) -> Self {
        Self {
            object_kg: object.mass_kg,
            mount: match object.mount {
                ObjectMount::Fixed => Mount::Fixed,
                ObjectMount::Spring => Mount::Spring {
                    stiffness_n_per_m: object.stiffness_n_per_m,
                    damping_n_s_per_m: object.damping_n_s_per_m,
                },
                ObjectMount::Free => Mount::Free,
            },
        }
    }
}
