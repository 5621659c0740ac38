//! What a finger's builder states of it, because it was measured or is known of the material.

use super::{Contact, Parameters, Transmission};

/// What the finger's builder states; 0 leaves it to the scene.
fn stated(value: f64) -> Option<f64> {
    (value > 0.0).then_some(value)
}

impl Contact {
    /// The coefficient that the finger's builder sets, where it is known about the skin.
    #[must_use]
    pub fn stated(&self) -> Option<f64> {
        stated(self.stated_friction)
    }
}

impl Transmission {
    /// Error of the worm's angle that the finger's builder states, radian, where it was measured.
    #[must_use]
    pub fn stated(&self) -> Option<f64> {
        stated(self.stated_worm_error_rad)
    }
}

impl Parameters {
    /// What a user sets of how the finger hangs, by eye and kitchen scale: direction of gravity and how upright the plane of motion
    /// stands to ten degrees, the finger's mass to a gram. Direction, degree, and the weight that acts in that plane over what the scene
    /// states; `None` where it states none.
    #[must_use]
    pub fn stated_mounting(&self) -> Option<(f64, f64)> {
        const STANDARD_M_PER_S2: f64 = 9.81;
        let stated_kg: f64 = self.finger.stated_mass_kg.iter().sum();
        let by_eye = |deg: f64| 10.0 * (0.1 * deg).round();
        let turned = |deg: f64| (deg + 180.0).rem_euclid(360.0) - 180.0;
        let mechanism = &self.mechanism;
        let length_m: f64 = self.finger.length_m.iter().sum();
        let grams = (1e3 * mechanism.linear_density_kg_per_m * length_m).round();
        let upright = (mechanism.gravity_m_per_s2 / STANDARD_M_PER_S2).min(1.0);
        let acts = by_eye(upright.asin().to_degrees()).to_radians().sin();
        (stated_kg > 0.0).then(|| {
            (
                turned(by_eye(mechanism.mounting_deg)),
                acts * 1e-3 * grams / stated_kg,
            )
        })
    }
}
