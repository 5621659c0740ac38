//! From samples to events: friction, stiffness, contact, location, force, uncertainty.
//!
//! Passive: the same samples give the same events, live or replayed, whatever made the finger move.
//!
//! ```text
//! Sample -> block::BlockAverager -> Block -> friction::Pass -> Assessment -> Friction
//!                               \-> Detector -> Curve -> Locator (fit::Hypothesis ...) -> Event
//! ```

pub mod block;
pub mod calibration;
pub mod curve;
pub mod detector;
pub mod drivetrain;
pub mod event;
pub mod following;
pub mod friction;
pub mod location;
pub mod locator;
mod normal;
pub mod object;
pub mod second;
pub mod sensor;
pub mod settings;
pub mod step;
mod torque_constant;

pub use crate::joint_sensor::{HallSensor, JointSensor, NoJointSensor, Side};
pub use crate::sample::{self, Drive, Sample};
pub use calibration::{Calibration, Refusal};
pub use drivetrain::Drivetrain;
pub use event::{Event, NotLocated};
pub use following::{AfterContact, Change, Changes, FirstContactOnly, Follow, Followed, Grip};
pub use friction::Friction;
pub use location::{Cable, Rigid, SeriesElement, SoftObject};
pub use object::{Object, Relative};
pub use sensor::{Sensor, Suspicion};
pub use settings::{Directive, Settings};

#[cfg(test)]
mod tests;
