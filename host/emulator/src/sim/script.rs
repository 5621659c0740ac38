// SPDX-License-Identifier: GPL-2.0-only
//! Script of the user's actions at the bench.

use palpate::app::console::command::{Calibrate, Command};
use palpate::app::console::settings::Setting;

/// One thing the user does.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Presses the button.
    Button,
    /// Types a command.
    Command(String),
}

impl Step {
    /// The command as the firmware reads it; none for the button and for what the firmware refuses.
    fn command(&self) -> Option<Command> {
        match self {
            Self::Button => None,
            Self::Command(line) => Command::parse(line.as_bytes()).ok().flatten(),
        }
    }

    /// The firmware answers with a motion that ends in `sequence done`, unless it refuses.
    #[must_use]
    pub fn moves(&self) -> bool {
        match self.command() {
            None => *self == Self::Button,
            Some(Command::Calibrate(calibrate)) => calibrate != Calibrate::Forget,
            Some(command) => matches!(
                command,
                Command::Run
                    | Command::Home
                    | Command::RecordFriction
                    | Command::Close
                    | Command::Open
            ),
        }
    }

    /// Takes the bridge off the motor, whatever is going on.
    #[must_use]
    pub fn stops(&self) -> bool {
        self.command() == Some(Command::Stop)
    }

    /// Clears a fault, so that what comes after it can be carried out.
    #[must_use]
    pub fn clears(&self) -> bool {
        self.command() == Some(Command::Clear)
    }

    /// The setting that is changed, and its value, SI units.
    #[must_use]
    pub fn sets(&self) -> Option<(Setting, f32)> {
        match self.command() {
            Some(Command::Set(setting, value_si)) => Some((setting, value_si)),
            _ => None,
        }
    }
}

/// As a script has it.
impl std::fmt::Display for Step {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Button => "button",
            Self::Command(line) => line,
        })
    }
}

/// Steps in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Script(pub Vec<Step>);

impl Script {
    /// The button once.
    #[must_use]
    pub fn button() -> Self {
        Self(vec![Step::Button])
    }

    /// The guided calibration: friction, with the press on the closing stop that follows it, a pin at each of these places, what was
    /// learned is kept; then a grasp.
    #[must_use]
    pub fn calibration(places_mm: &[f64]) -> Self {
        let commands = places_mm.iter().map(|place| format!("calibrate {place}"));
        let all = core::iter::once("record-friction".to_owned())
            .chain(commands)
            .chain(["save", "run"].map(str::to_owned));
        Self(all.map(Step::Command).collect())
    }

    /// Commands separated by semicolons; the word `button` presses it.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let commands = text
            .split(';')
            .map(str::trim)
            .filter(|command| !command.is_empty());
        Self(
            commands
                .map(|c| {
                    if c == "button" {
                        Step::Button
                    } else {
                        Step::Command(c.to_owned())
                    }
                })
                .collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_is_a_script() {
        assert_eq!(
            Script::calibration(&[20.0, 45.5]),
            Script::parse("record-friction;calibrate 20;calibrate 45.5;save;run")
        );
    }

    #[test]
    fn motions_are_awaited() {
        let script = Script::parse("record-friction; calibrate 40;run ; status; button");
        assert_eq!(script.0.iter().filter(|step| step.moves()).count(), 4);
    }

    /// A line means what it means to the firmware: any case, with its unit or without.
    #[test]
    fn a_line_is_read_as_the_firmware_reads_it() {
        let pin = |text: &str| Script::parse(text).0[0].command();
        assert!(pin("calibrate 40").is_some());
        assert_eq!(pin("Calibrate 40mm"), pin("calibrate 40"));
        assert_eq!(pin("calibrate 40 mm"), pin("calibrate 40"));
        assert!(Step::Command("RUN".into()).moves());
        assert!(Step::Command(" Stop".into()).stops());
        for still in ["calibrate forget", "calibrate here", "status", "walk"] {
            assert!(!Step::Command(still.into()).moves(), "{still}");
        }
    }
}
