//! Command lines carried out, one after the other, each answered.

use palpate::app::command::{COMMANDS, Command};
use palpate::app::conduct::{Conduct, Effect};
use palpate::app::decimal::Decimal;
use palpate::app::kept::{self, mark};
use palpate::app::record::{RecordError, decode, encode};
use palpate::app::sense::Sense;
use palpate::app::settings::{Overrides, Setting};
use palpate::app::store::{Found, StoreError, Writer};
use palpate::drive::sequence::{Notice, Refused};
use palpate::scene::Active;

use super::console::{self, Speaker};
use super::slow::Shared;
use super::storage::{self, Storage};
use super::{control, telemetry};

/// What the record, if there is one, says.
pub enum Kept {
    /// Nothing was ever saved, or nothing is left of it; the log says which.
    Nothing,
    /// A whole record of this scene; sensing has taken over its part.
    Restored {
        /// What the user has set.
        overrides: Overrides,
        /// Whether friction is known.
        notice: Notice,
    },
    /// Something that must not be used.
    Unusable,
}

/// Reads the record, hands it over, and says so in the log.
#[inline(never)]
pub fn load(storage: &mut Storage, sense: &'static Shared<Sense<Active>>) -> Kept {
    let (kept, what) = storage.load(|found| match found {
        Found::Nothing => (Kept::Nothing, "none"),
        Found::Unreadable => (Kept::Nothing, "unreadable"),
        Found::Record { bytes, newest } => restore(bytes, newest, sense),
    });
    telemetry::record(what, storage::bad_words());
    kept
}

fn restore(
    bytes: &[u8],
    newest: bool,
    sense: &'static Shared<Sense<Active>>,
) -> (Kept, &'static str) {
    let mut kept = kept::Kept::nothing::<Active>();
    match decode(bytes, mark::<Active>(), &mut kept) {
        Ok(()) => {
            let overrides = kept.overrides;
            let notice = sense.lock(|sense| sense.borrow_mut().restore(kept));
            let what = if newest { "loaded" } else { "older" };
            (Kept::Restored { overrides, notice }, what)
        }
        Err(error) => (Kept::Unusable, why(error)),
    }
}

fn why(error: RecordError) -> &'static str {
    match error {
        RecordError::Damaged => "damaged",
        RecordError::Version { .. } => "other-version",
        RecordError::OtherScene => "other-scene",
        RecordError::Implausible => "implausible",
    }
}

/// Carries out commands.
pub async fn execute(
    mut speaker: Speaker,
    mut storage: Storage,
    sense: &'static Shared<Sense<Active>>,
    conduct: &'static Shared<Conduct<Active>>,
) {
    loop {
        let command = match console::next().await {
            Ok(command) => command,
            Err(error) => {
                speaker.answer(format_args!("error: {error}")).await;
                continue;
            }
        };
        // The sequence has taken a stop already, before this line's turn came.
        let effect = if command == Command::Stop {
            Ok(Effect::Accepted)
        } else {
            conduct.lock(|conduct| conduct.borrow_mut().command(command))
        };
        match effect {
            Err(refused) => refuse(&mut speaker, refused).await,
            Ok(Effect::Accepted) => speaker.answer(format_args!("ok")).await,
            Ok(Effect::Set { at_restart: false }) => {
                speaker.answer(format_args!("ok; save keeps it")).await
            }
            Ok(Effect::Set { at_restart: true }) => {
                speaker
                    .answer(format_args!("ok; acts after save and a restart"))
                    .await;
            }
            Ok(Effect::Help) => help(&mut speaker).await,
            Ok(Effect::Status) => status(&mut speaker, conduct).await,
            Ok(Effect::Show) => show(&mut speaker, conduct).await,
            Ok(Effect::Save) => {
                let result = save(&mut storage, sense, conduct).await;
                written(&mut speaker, "saved", result).await;
            }
            Ok(Effect::Factory) => {
                let result = storage.forget().await;
                written(&mut speaker, "forgotten", result).await;
            }
        }
    }
}

async fn refuse(speaker: &mut Speaker, refused: Refused) {
    let (why, what) = match refused {
        Refused::Faulted(fault) => (fault.name(), "is latched: clear first"),
        Refused::Busy(state) => (state.name(), "is going on: stop first"),
        Refused::NoFault => ("no fault", "is latched"),
        Refused::NoFriction => ("no friction", "is recorded: record-friction first"),
    };
    speaker.answer(format_args!("refused: {why} {what}")).await;
}

async fn written(
    speaker: &mut Speaker,
    done: &str,
    result: Result<(), StoreError<storage::Error>>,
) {
    match result {
        Ok(()) => speaker.answer(format_args!("{done}")).await,
        Err(error) => {
            speaker
                .answer(format_args!("failed: {}", storage::name(error)))
                .await
        }
    }
}

async fn save(
    storage: &mut Storage,
    sense: &'static Shared<Sense<Active>>,
    conduct: &'static Shared<Conduct<Active>>,
) -> Result<(), StoreError<storage::Error>> {
    let overrides = conduct.lock(|conduct| *conduct.borrow().overrides());
    storage
        .save(|writer| write_record(sense, overrides, writer))
        .await
}

/// Apart from [`save`], so that the record lies on the stack for the moment only.
#[inline(never)]
fn write_record(
    sense: &'static Shared<Sense<Active>>,
    overrides: Overrides,
    writer: &mut Writer<'_, storage::Region>,
) {
    let mut kept = sense.lock(|sense| sense.borrow().keep(overrides));
    encode(&mut kept, mark::<Active>(), |byte| writer.push(byte));
}

async fn help(speaker: &mut Speaker) {
    for (name, usage, what) in COMMANDS {
        speaker.answer(format_args!("{name} {usage}: {what}")).await;
    }
}

async fn show(speaker: &mut Speaker, conduct: &'static Shared<Conduct<Active>>) {
    for row in &Setting::TABLE {
        let value = conduct.lock(|conduct| conduct.borrow().value(row.setting));
        let value = Decimal(row.to_user(value));
        let (min, max) = (Decimal(row.min), Decimal(row.max));
        speaker
            .answer(format_args!(
                "{} {value} {} ({min} to {max})",
                row.name, row.unit
            ))
            .await;
    }
}

async fn status(speaker: &mut Speaker, conduct: &'static Shared<Conduct<Active>>) {
    let status = control::status();
    let (state, fault) = conduct.lock(|conduct| {
        let conduct = conduct.borrow();
        (conduct.state(), conduct.fault())
    });
    telemetry::status(state, fault, &status);
    let fault = fault.map_or("none", |fault| fault.name());
    let current_ma = Decimal(status.current_a * 1e3);
    let (supply_v, winding_c) = (Decimal(status.supply_v), Decimal(status.winding_c));
    speaker
        .answer(format_args!(
            "state {}, position {} counts, current {current_ma} mA, supply {supply_v} V, winding {winding_c} C, fault {fault}",
            state.name(),
            status.position_counts
        ))
        .await;
}
