//! The simulated world: an underactuated finger, its drivetrain, bridge and sensors, and an object in its way.
//!
//! Computes in f64 with its own physics and imports nothing of the library that it tests. [`Plant`] is stepped with the levels on
//! the bridge's [`Pins`] and returns what a chip can measure; [`Plant::truth`] gives the hidden state. Simulated: nothing here
//! was checked against a real finger.
//!
//! | module | what it models |
//! |---|---|
//! | `bridge` | H-bridge, winding, its temperature, unsigned current sense |
//! | `switching` | the winding between the edges of the PWM, the mirror of the low sides |
//! | `supply`, `converter` | what the supply's capacitor stores; what a converter's input does to a pin |
//! | `drivetrain` | rotor, gearhead, worm: friction of a screw, self-locking, backlash |
//! | `transmission`, `wander` | angle errors of worm, wheel and gears, hysteresis; non-periodic errors |
//! | `cable` | stiffening, creep |
//! | `encoder` | disc, wires and their faults |
//! | `finger`, `linkage` | joints, springs, stops, tendon or four-bar transmission by loop closure, contact |
//! | `mechanics` | interface to finger and object, so that another engine can compute them |
//! | `object` | cylinders and convex polygons, thick phalanges |

mod bridge;
mod cable;
mod converter;
mod drivetrain;
mod encoder;
mod error;
mod finger;
mod last;
mod linkage;
mod mechanics;
mod object;
mod parameters;
mod pins;
mod plant;
mod supply;
mod switching;
mod transmission;
mod truth;
mod wander;
mod worlds;

pub use converter::{Converter, Probe, Source};
pub use drivetrain::worm_efficiency;
pub use encoder::EncoderFault;
pub use error::Error;
pub use mechanics::{CableEnd, FingerState, Mechanics, Quasistatic, placed};
pub use object::{Body, Grasp, Point, Shape};
pub use parameters::{
    Bridge, Cable, Contact as ContactParameters, Converter as ConverterParameters, DEFAULT_TOML,
    Encoder, Engine, FingerParameters, Friction, Gearhead, Hall, Mechanism, Motor, Object,
    ObjectMount, Parameters, Sense, Supply, Transmission, World, Worm, default_scene, scenes,
};
pub use pins::{Faults, Pins};
pub use plant::{MAX_STEP_S, Plant};
pub use truth::{Contact, FirstContact, TrueCalibration, Truth};
pub use worlds::world_names;
