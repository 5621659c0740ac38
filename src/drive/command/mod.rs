//! Commands as text lines, from RTT or the serial port: no heap, every line answered.

/// A command, parsed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command<'a> {
    /// List the commands.
    Help,
    /// State, position, current, temperatures, fault.
    Status,
    /// The whole sequence.
    Run,
    /// Close until contact, probe, hold.
    Close,
    /// Open to the rest position.
    Open,
    /// Motor off.
    Stop,
    /// Clear a latched fault.
    Clear,
    /// Measure the offset and find the opening stop.
    Home,
    /// Record friction anew.
    RecordFriction,
    /// Close on a pin at a known place and learn from it.
    Calibrate {
        /// Place of the pin from the joint of the last phalanx, metre.
        k_m: f32,
    },
    /// List the settings.
    Show,
    /// Change a setting.
    Set {
        /// Name of the setting.
        name: &'a str,
        /// Its new value, in the setting's unit.
        value: f32,
    },
    /// Write settings, friction and calibration to flash.
    Save,
    /// Forget everything stored.
    Factory,
}
