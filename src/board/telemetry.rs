//! The firmware's log: the lines of [`palpate::app::log`], written with defmt.

use palpate::app::log::Log;
use palpate::log_lines;

/// Writes lines to RTT. Thread mode only.
pub struct Telemetry;

macro_rules! implement {
    ($($(#[$doc:meta])* $function:ident $level:ident $format:literal ($($key:ident: $type:ty),*);)*) => {
        impl Log for Telemetry {
            $(fn $function(&mut self, $($key: $type),*) {
                defmt::$level!($format, $($key),*);
            })*
        }
    };
}
log_lines!(implement);

/// By how much joint 2 has turned since contact, with every place.
// A symbol of its own: its absence shows that a scene without the sensor does not carry this.
#[inline(never)]
pub fn branch(change_mrad: f32, side: &str) {
    Telemetry.branch(change_mrad, side);
}
