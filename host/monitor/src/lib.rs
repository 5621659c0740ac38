//! A live view of a finger in the terminal: its posture, the contact, the torque curve, the log, and a command line.
//!
//! Lines come in ([`source`], [`stream`]), change what is known ([`state`]), and are drawn ([`screen`], [`page`]) from the
//! same strokes and curves ([`figure`]). The mechanics that draws the finger is the library's own ([`posture`]).

pub mod command_line;
pub mod ending;
pub mod figure;
pub mod losses;
pub mod page;
pub mod posture;
pub mod recording;
pub mod scenes;
pub mod screen;
pub mod source;
pub mod state;
pub mod stream;
pub mod svg;
pub mod watch;
pub mod wire;
