//! Carries command lines out, one after the other, and answers each.

use core::fmt::Write;

use embassy_stm32::usart::BufferedUartTx;

use crate::scene::Active;
use palpate::app::console::command::{Command, Verb};
use palpate::app::console::settings::{Overrides, Setting};
use palpate::app::console::text::{Answer, Decimal, Plain, Whole};
use palpate::app::grasp::coordinator::{Action, Coordinator};
use palpate::app::grasp::sensing::ContactSensing;
use palpate::app::log::{self, Log};
use palpate::app::storage::record::{self, Record};
use palpate::app::storage::store::{Found, Writer};
use palpate::drive::Fault;
use palpate::drive::identify::Identified;
use palpate::drive::sequence::{Notice, Refused};
use palpate::scene::Scene;
use palpate::sensing::SeriesElement;

use super::Series;
use super::console::{self, Parsed};
use super::control;
use super::shared::Shared;
use super::storage::{self, Storage};
use super::telemetry::Telemetry;
use super::trace;

/// The scene that a record must be of.
const SCENE_ID: u32 = record::scene_id::<Active>();

/// Bytes of a record told at once: in an answer there is room for their digits.
const PIECE_BYTES: usize = 24;

/// What was found in flash at start.
pub enum Loaded {
    /// Nothing was ever saved, or nothing is left of it; the log says which.
    Nothing,
    /// A whole record of this scene; sensing has taken over its part.
    Restored {
        /// What the user has set.
        overrides: Overrides,
        /// What was identified of the motor.
        identified: Option<Identified>,
        /// Whether friction is known.
        notice: Notice,
    },
    /// Something that must not be used.
    Unusable,
}

/// Reads the record, hands it over, and says so in the log.
#[inline(never)]
pub fn load(storage: &mut Storage, sensing: &Shared<ContactSensing<Active>>) -> Loaded {
    let (loaded, state) = storage.load(|found| match found {
        Found::Nothing => (Loaded::Nothing, "none"),
        Found::Unreadable => (Loaded::Nothing, "unreadable"),
        Found::Record { bytes, newest } => {
            let restored = Record::decode::<{ Active::IDENTIFIES }, _>(bytes, SCENE_ID, |record| {
                Loaded::Restored {
                    overrides: *record.overrides,
                    identified: record.identified.copied(),
                    notice: sensing.with(|sensing| sensing.restore(record)),
                }
            });
            match restored {
                Ok(restored) => (restored, if newest { "loaded" } else { "older" }),
                Err(error) => (Loaded::Unusable, error.name()),
            }
        }
    });
    Telemetry.record(state, storage::bad_words());
    loaded
}

/// What commands work on.
#[derive(Clone, Copy)]
pub struct Application {
    /// The sensing half of the slow loop.
    pub sensing: &'static Shared<ContactSensing<Active>>,
    /// The motion half.
    pub coordinator: &'static Shared<Coordinator<Active>>,
}

/// Carries out commands.
#[embassy_executor::task]
pub async fn execute(
    mut port: BufferedUartTx<'static>,
    mut storage: Storage,
    application: Application,
) {
    let mut answer = Answer::new();
    loop {
        let parsed = console::next(&mut port).await;
        answer.clear();
        let action = application.command(&mut answer, parsed);
        if matches!(action, Action::Save | Action::Factory) {
            let saves = action == Action::Save;
            let encode =
                |writer: &mut Writer<'_, _>| application.encode(&mut |byte| writer.push(byte));
            let done = match storage.replace(saves.then_some(encode)).await {
                Ok(()) if saves => answer.push_str("saved"),
                Ok(()) => answer.push_str("forgotten"),
                Err(error) => (answer.push_str("failed: "))
                    .and_then(|()| answer.push_str(storage::name(error))),
            };
            // An answer that is too long is cut: here and below.
            let _ = done;
        }
        if action == Action::SelfTest {
            application.selftest(&mut port, &mut answer).await;
        }
        #[cfg(identify)]
        if action == Action::Identify {
            application.identify(&mut port, &mut answer).await;
        }
        let mut row = 0;
        loop {
            console::answer(&mut port, &answer).await;
            row += 1;
            answer.clear();
            if !application.list(&mut answer, action, row) {
                break;
            }
        }
    }
}

impl Application {
    /// Carries a command out except for what concerns flash. The answer says how that went, or begins the list that was
    /// asked for.
    #[inline(never)]
    fn command(self, answer: &mut Answer, parsed: Parsed) -> Action {
        let action = match parsed {
            Err(error) => {
                let _ = write!(answer, "error: {error}");
                return Action::Accepted;
            }
            Ok(command) => {
                let accepted = self.coordinator.with(|coordinator| {
                    if command == Command::Stop {
                        // Taken here, so that it does not stop what is asked for after it.
                        console::stop_requested();
                    }
                    coordinator.command(command)
                });
                match accepted {
                    Ok(action) => action,
                    Err(refused) => {
                        refuse(answer, refused);
                        return Action::Accepted;
                    }
                }
            }
        };
        let text = match action {
            Action::Accepted => "ok",
            Action::Trace(every) => {
                trace::stream(every);
                "ok"
            }
            Action::Set { at_restart: false } => "ok; save keeps it",
            Action::Set { at_restart: true } => "ok; takes effect after save and a restart",
            Action::Status => {
                self.status(answer);
                ""
            }
            Action::SelfTest | Action::Identify => "",
            Action::Help | Action::Show | Action::Save | Action::Factory => {
                self.list(answer, action, 0);
                ""
            }
        };
        let _ = answer.push_str(text);
        action
    }

    /// Encodes what is to be kept.
    #[inline(never)]
    fn encode(self, put: &mut dyn FnMut(u8)) {
        let (overrides, identified, friction_known) = self.coordinator.with(|coordinator| {
            let identified = coordinator.identified().copied();
            (
                *coordinator.overrides(),
                identified,
                coordinator.friction_known(),
            )
        });
        self.sensing.with(|sensing| {
            let record = Record {
                overrides: &overrides,
                calibration: sensing.calibration(),
                // One of another speed or mounting, or one that is stale, would count as known after a restart.
                friction: sensing.sensor().friction().filter(|_| friction_known),
                identified: identified.as_ref(),
            };
            record.encode(SCENE_ID, put);
        });
    }

    /// A piece of what `save` would keep, its bytes as numbers behind the piece's own, so that a recording tells what was known
    /// when it began; false after the last one.
    fn kept(self, answer: &mut Answer, piece: usize) -> bool {
        let _ = write!(answer, "kept {}", Whole(piece as i32));
        let (mut place, from) = (0, piece * PIECE_BYTES);
        self.encode(&mut |byte| {
            if (from..from + PIECE_BYTES).contains(&place) {
                let _ = write!(answer, " {}", Whole(byte.into()));
            }
            place += 1;
        });
        from < place
    }

    /// A row of what `help` and `show` list and of what `trace on` tells; false, and nothing written, after the last one.
    #[inline(never)]
    fn list(self, answer: &mut Answer, action: Action, row: usize) -> bool {
        let _ = match action {
            Action::Help => {
                let Some(verb) = Verb::ALL.get(row) else {
                    return false;
                };
                write!(
                    answer,
                    "{} {}: {}",
                    Plain(verb.name()),
                    Plain(verb.usage()),
                    Plain(verb.summary())
                )
            }
            Action::Show => {
                let Some(&setting) = Setting::ALL.get(row) else {
                    return false;
                };
                let value_si = self
                    .coordinator
                    .with(|coordinator| coordinator.value(setting));
                let (name, unit) = (Plain(setting.name()), Plain(setting.unit()));
                let range = setting.range();
                let value = Decimal(range.to_user(value_si));
                write!(answer, "{name} {value} {unit} ({range})")
            }
            Action::Trace(every) if every > 0 => return self.kept(answer, row - 1),
            _ => return false,
        };
        true
    }

    fn status(self, answer: &mut Answer) {
        let status = control::status();
        let (state, fault) = self
            .coordinator
            .with(|coordinator| (coordinator.state(), coordinator.fault()));
        log::status(&mut Telemetry, state, fault, &status);
        let _ = write!(
            answer,
            "state {}, position {} counts, current {} mA, supply {} V, winding {} C, fault {}",
            Plain(state.name()),
            Whole(status.position_counts),
            Decimal(status.current_a * 1e3),
            Decimal(status.supply_v),
            Decimal(status.winding_c),
            Plain(fault.map_or("none", Fault::name))
        );
    }
}

fn refuse(answer: &mut Answer, refused: Refused) {
    let (what, why) = match refused {
        Refused::Faulted(fault) => (fault.name(), " is latched: clear first"),
        Refused::StillThere(fault) => (fault.name(), " is still there"),
        Refused::Busy(state) => (state.name(), " is going on: stop first"),
        Refused::NoFault => ("no fault", " is latched"),
        Refused::NoFriction => ("no friction", " is recorded: record-friction first"),
        Refused::NoCable if !Series::FLEXIBLE => ("no cable", " is in this scene: use a pin"),
        // Where there is a cable nothing is refused for want of it, and its text is left out.
        Refused::NotFitted | Refused::NoCable => {
            ("identify", " is not in this scene: set identify.fitted")
        }
    };
    let _ = write!(answer, "refused: {}{}", Plain(what), Plain(why));
}
