//! Friction of the unloaded drivetrain over the angle of the input link, both ways, and how well it repeats.
//!
//! All torques here are motor torques seen from the input link as if nothing were lost: what the motor spends on a free
//! motion, the springs of the finger included where it has one at joint 1.

mod alignment;
mod record;
mod recorder;
mod statistics;
mod track;

pub use alignment::{Aligned, Alignment};
pub use record::Friction;
pub use recorder::Recorder;
pub use track::{BINS, Track};
