//! The second simulated world: finger and object computed by MuJoCo, on the plant's drivetrain.
//!
//! Joints, springs, stops, four-bars, contact and friction are the engine's; motor, gears, worm, backlash, cable,
//! encoder and current sense are the plant's, which sees no difference: it steps a [`palpate_plant::Mechanics`] either
//! way. Nothing of the estimator took part. Where the plant's finger has no mass, this one has, and so it bounces.
//!
//! | module | what it does |
//! |---|---|
//! | `assembly` | where the links of a four-bar stand |
//! | `model`, `outline` | the engine's model of a finger and an object, as text |
//! | `stiffness` | constraints with a stiffness in newton per metre instead of the engine's own measure |
//! | `finger` | steps it |
//!
//! The engine needs its library, which only [`Engine::Mujoco`] asks for: see the feature `engine`.

#[cfg(feature = "engine")]
mod assembly;
#[cfg(feature = "engine")]
mod finger;
#[cfg(feature = "engine")]
mod model;
#[cfg(feature = "engine")]
mod outline;
#[cfg(feature = "engine")]
mod stiffness;
#[cfg(feature = "engine")]
mod surroundings;

#[cfg(feature = "engine")]
pub use finger::MujocoFinger;
#[cfg(feature = "engine")]
pub use surroundings::{Mount, Surroundings};

use palpate_plant::{Engine, Error, Grasp, Parameters, Plant};

/// A world whose finger the engine of `parameters` computes; otherwise [`Plant::new`].
///
/// # Errors
/// As [`Plant::new`]; MuJoCo is asked for and this program was built without it, or refuses the model.
pub fn plant(parameters: &Parameters, grasp: &Grasp, seed: u64) -> Result<Plant, Error> {
    match parameters.engine {
        Engine::Plant => Plant::new(parameters, grasp, seed),
        Engine::Mujoco => mujoco(parameters, grasp, seed),
    }
}

#[cfg(feature = "engine")]
fn mujoco(parameters: &Parameters, grasp: &Grasp, seed: u64) -> Result<Plant, Error> {
    let finger = MujocoFinger::new(parameters, &Surroundings::from(&parameters.object))?;
    Plant::with_mechanics(parameters, Box::new(finger), grasp, seed)
}

#[cfg(not(feature = "engine"))]
fn mujoco(_: &Parameters, _: &Grasp, _: u64) -> Result<Plant, Error> {
    Err(Error::Engine(
        "this program was built without MuJoCo; `cargo xtask` builds it with MuJoCo where --engine mujoco is given"
            .into(),
    ))
}
