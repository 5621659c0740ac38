// SPDX-License-Identifier: GPL-2.0-only
//! Images of the firmware, which `cargo xtask test` builds and names in variables of the environment. A test whose image is not
//! there says so and passes.

use std::path::PathBuf;

use palpate_emulator::Firmware;
use palpate_emulator::log::{Event, Line};
use palpate_emulator::sim::{CONTROL_INSTRUCTIONS, Session};

/// The default scene, `p70`.
pub const DEFAULT: &str = "PALPATE_ELF";
/// The same, built with the feature `fault-injection`.
pub const FAULTY: &str = "PALPATE_FAULT_ELF";
/// The scene `tendon3`, built with it.
pub const FAULTY_TENDON3: &str = "PALPATE_FAULT_TENDON3_ELF";
/// The default scene, built with the feature `serial-log`.
pub const SERIAL: &str = "PALPATE_SERIAL_ELF";
/// The scene `tendon2-hall`: a sensor at joint 2.
pub const HALL: &str = "PALPATE_HALL_ELF";
/// The scene `p70-rigid`: no cable.
pub const RIGID: &str = "PALPATE_RIGID_ELF";
/// The scene `p70-shunt`: a signed current sense.
pub const SHUNT: &str = "PALPATE_SHUNT_ELF";
/// The scene `p70-grasp`: a second contact.
pub const GRASP: &str = "PALPATE_GRASP_ELF";
/// The scene `tendon3-grasp`: a second contact on three phalanges.
pub const GRASP_TENDON3: &str = "PALPATE_GRASP_TENDON3_ELF";
/// The scene `linkage3-grasp`: the same with a linkage of two stages.
pub const GRASP_LINKAGE3: &str = "PALPATE_GRASP_LINKAGE3_ELF";
/// The scene `direct2`: a motor at every joint.
pub const DIRECT: &str = "PALPATE_DIRECT_ELF";

/// Where an image lies.
pub fn path(variable: &str) -> Option<PathBuf> {
    let path = std::env::var_os(variable);
    if path.is_none() {
        eprintln!("{variable} is not set: nothing tested");
    }
    path.map(PathBuf::from)
}

/// The image of the default scene.
pub fn firmware() -> Option<Firmware> {
    image(DEFAULT)
}

/// An image.
pub fn image(variable: &str) -> Option<Firmware> {
    path(variable).map(|path| Firmware::load(&path).expect("the image loads"))
}

/// Runs a session until its script is over.
#[track_caller]
pub fn run_out(session: &mut Session<'_>) {
    while !session.over() {
        session.millisecond().expect("a sound run");
    }
}

/// Checks that the control interrupt stayed within its bound and was never late.
pub fn keeps_up(session: &Session<'_>) {
    let control = session.machine.account().exceptions()[&34];
    assert!(
        control.max.instructions <= CONTROL_INSTRUCTIONS,
        "{control:?}"
    );
    assert_eq!(session.machine.chip().missed_triggers(), 0);
}

/// What the log tells from the last closing on. The first closing presses on the closing stop.
pub fn last_closing<'s>(session: &'s Session<'_>) -> impl DoubleEndedIterator<Item = Event<'s>> {
    let closes = |line: &Line| {
        let event = line.event();
        event.name == "state" && event.field("name") == Some("close")
    };
    let from = session.lines.iter().rposition(closes).unwrap_or(0);
    session.lines[from..].iter().map(Line::event)
}
