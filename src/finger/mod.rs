//! Finger mechanics: geometry, springs, transmission; nothing of motors, time or noise.
//!
//! Numbers in brackets are the equations of the source paper; docs/MECHANICS.md derives and corrects them.
//! Lengths and torques may be in any consistent set of units; the names say metre and newton metre.

mod build;
mod configuration;
pub(crate) mod error;
mod fourbar;
mod inverse;
mod linkage;
mod mechanics;
mod path;
mod preshape;
mod statics;
mod tendon;
mod three_joint;
mod transmission;
mod two_joint;

pub use build::{AnyBase, Base, BaseJoint, Finger, Parameters, Springless};
pub use configuration::{Configuration, JointStep};
pub use error::{ConfigError, Parameter};
pub use fourbar::{Advance, Assembly, FourBar, Levers, Ratio};
pub use linkage::Linkage;
pub use mechanics::{
    Candidate, Class, Contact, Free, Inverse, MAX_PHALANGES, Mechanics, PathPoint,
};
pub use path::Path;
pub use tendon::Tendon;
pub use three_joint::ThreeJointContact;
pub use transmission::{Transmission, TransmissionFactors};
pub use two_joint::{Roots, TwoJointContact};
