//! Finger mechanics: geometry, springs, transmission; nothing of motors, time or noise.
//!
//! Numbers in brackets are the equations of the source paper; docs/MECHANICS.md and docs/FINGERS.md derive and correct them.
//! Lengths and torques may be in any consistent set of units; the names say metre and newton metre.
//!
//! A finger has two to six phalanges; the questions are the same for any number ([`Mechanics`]):
//!
//! ```
//! use palpate::finger::{Class, Finger, Mechanics, Parameters, Tendon};
//!
//! let finger: Finger<4, Tendon<4>> = Finger::new(
//!     Parameters {
//!         lengths_m: [0.060, 0.045, 0.030, 0.020],
//!         stiffness_nm_per_rad: [0.1; 4],
//!         rest_rad: [0.3; 4],
//!         range_rad: [[-0.5, 2.0]; 4],
//!     },
//!     [0.010, 0.008, 0.010, 0.008, 0.010, 0.008],
//! )?;
//! let at = finger.free_at_torque(0.05, &finger.rest()).expect("a posture");
//! let compliance = finger.contact_compliance(&at, 0.05, 4, 0.012).expect("stable");
//! let places = finger.locate(&at, 0.05, compliance);
//! assert!(places.candidates().iter().any(|c| c.phalanx == 4 && (c.k_m - 0.012).abs() < 1e-6));
//! # Ok::<(), palpate::finger::ConfigError>(())
//! ```

mod actuated;
mod bent;
mod break_away;
mod build;
mod chain;
mod configuration;
mod direct;
pub(crate) mod error;
mod fourbar;
mod held;
mod inverse;
mod linkage;
mod long_linkage;
mod mechanics;
mod path;
mod preshape;
mod quadratic;
mod return_cable;
mod rubbed;
mod second_posterior;
mod statics;
mod tendon;
mod three_joint;
mod transmission;
mod turned;
mod two_contacts;
mod two_joint;
mod weight;
mod weighted;

pub use actuated::{ActuatedFinger, ActuatedPlace};
pub use break_away::StoppedContact;
pub use build::{
    AnyBase, Base, BaseJoint, Finger, HiddenBase, KnownBase, Parameters, Preloaded, Springless,
};
pub use configuration::{Configuration, JointStep};
pub use direct::Direct;
pub use error::{ConfigError, Parameter};
pub use fourbar::{Advance, Assembly, FourBar, Levers, Ratio};
pub(crate) use held::VAGUE;
pub use held::{HeldForces, HoldsTwice, NoSecondContact, TwoContacts, Weighing, Weighs};
pub use linkage::Linkage;
pub use mechanics::{
    Candidate, Candidates, Class, Contact, Free, Inverse, JointPoint, LONGEST_FINGER,
    MAX_PHALANGES, MOST_CANDIDATES, Mechanics, PathPoint,
};
pub use path::{Path, Pressed};
pub use return_cable::ReturnCable;
pub use second_posterior::SecondWeights;
pub use tendon::Tendon;
pub use three_joint::ThreeJointContact;
pub use transmission::{Transmission, TransmissionFactors};
pub use two_contacts::{SecondMeasured, SecondPlace, TwoContactForces};
pub use two_joint::{Roots, TwoJointContact};
pub use weight::{Mounting, Weight, Weighted};
