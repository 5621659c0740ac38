//! Command lines carried out, one after the other, each answered.

use core::fmt::{self, Write};

use heapless::String;

use palpate::app::command::{COMMANDS, Command, CommandError};
use palpate::app::conduct::{Conduct, Effect};
use palpate::app::decimal::Decimal;
use palpate::app::kept::{self, mark};
use palpate::app::record::{RecordError, decode, encode};
use palpate::app::sense::Sense;
use palpate::app::settings::{Description, Overrides, Setting};
use palpate::app::store::{Found, StoreError, Writer};
use palpate::drive::sequence::{Notice, Refused};
use palpate::scene::Active;

use super::console::{self, Said};
use super::serial::Sender;
use super::shared::{Shared, Turn};
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
pub fn load(storage: &mut Storage, sense: &'static Shared<Sense<Active>>, turn: &mut Turn) -> Kept {
    let (kept, what) = storage.load(|found| match found {
        Found::Nothing => (Kept::Nothing, "none"),
        Found::Unreadable => (Kept::Nothing, "unreadable"),
        Found::Record { bytes, newest } => restore(bytes, newest, sense, turn),
    });
    telemetry::record(what, storage::bad_words());
    kept
}

fn restore(
    bytes: &[u8],
    newest: bool,
    sense: &'static Shared<Sense<Active>>,
    turn: &mut Turn,
) -> (Kept, &'static str) {
    let mut kept = kept::Kept::nothing::<Active>();
    match decode(bytes, mark::<Active>(), &mut kept) {
        Ok(()) => {
            let overrides = kept.overrides;
            let notice = sense.lock(turn, |sense| sense.restore(kept));
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

/// Longest answer line; longer ones are cut.
const ANSWER_BYTES: usize = 120;

/// What a command is answered with: one line or more.
enum Answer {
    Error(CommandError),
    Refused(Refused),
    Done(Effect),
    /// What was done to flash, or why not.
    Written(&'static str, Result<(), StoreError<storage::Error>>),
}

/// Carries out commands.
#[embassy_executor::task]
pub async fn execute(
    mut port: Sender,
    mut storage: Storage,
    sense: &'static Shared<Sense<Active>>,
    conduct: &'static Shared<Conduct<Active>>,
    mut turn: Turn,
) {
    loop {
        let said = console::next(&mut turn).await;
        let answer = match carry_out(said, conduct, &mut turn) {
            Answer::Done(Effect::Save) => {
                let overrides = conduct.lock(&mut turn, |conduct| *conduct.overrides());
                let result = storage
                    .save(|writer| write_record(sense, &mut turn, overrides, writer))
                    .await;
                Answer::Written("saved", result)
            }
            Answer::Done(Effect::Factory) => Answer::Written("forgotten", storage.forget().await),
            answer => answer,
        };
        let mut row = 0;
        while let Some(line) = line(&answer, row, conduct, &mut turn) {
            console::answer(&mut port, &line).await;
            row += 1;
        }
    }
}

fn carry_out(said: Said, conduct: &'static Shared<Conduct<Active>>, turn: &mut Turn) -> Answer {
    match said {
        Err(error) => Answer::Error(error),
        // The sequence has taken a stop already, before this line's turn came.
        Ok(Command::Stop) => Answer::Done(Effect::Accepted),
        Ok(command) => match conduct.lock(turn, |conduct| conduct.command(command)) {
            Ok(effect) => Answer::Done(effect),
            Err(refused) => Answer::Refused(refused),
        },
    }
}

/// Apart from [`execute`], so that the record lies on the stack for the moment only.
#[inline(never)]
fn write_record(
    sense: &'static Shared<Sense<Active>>,
    turn: &mut Turn,
    overrides: Overrides,
    writer: &mut Writer<'_, storage::Region>,
) {
    sense.lock(turn, |sense| {
        sense.keep(overrides, |kept| {
            encode(kept, mark::<Active>(), |byte| writer.push(byte));
        });
    });
}

/// A line of an answer; `None` behind the last one.
#[inline(never)]
fn line(
    answer: &Answer,
    row: usize,
    conduct: &'static Shared<Conduct<Active>>,
    turn: &mut Turn,
) -> Option<String<ANSWER_BYTES>> {
    let mut line = String::new();
    // What does not fit is cut.
    let _ = match answer {
        Answer::Done(Effect::Help) => {
            let (name, usage, what) = COMMANDS.get(row)?;
            write!(line, "{name} {usage}: {what}")
        }
        Answer::Done(Effect::Show) => show(&mut line, Setting::TABLE.get(row)?, conduct, turn),
        _ if row > 0 => return None,
        Answer::Error(error) => write!(line, "error: {error}"),
        Answer::Refused(refused) => refuse(&mut line, *refused),
        Answer::Done(Effect::Status) => status(&mut line, conduct, turn),
        Answer::Done(Effect::Set { at_restart: false }) => line.write_str("ok; save keeps it"),
        Answer::Done(Effect::Set { at_restart: true }) => {
            line.write_str("ok; acts after save and a restart")
        }
        Answer::Done(_) => line.write_str("ok"),
        Answer::Written(done, Ok(())) => line.write_str(done),
        Answer::Written(_, Err(error)) => write!(line, "failed: {}", storage::name(*error)),
    };
    Some(line)
}

fn refuse(line: &mut impl Write, refused: Refused) -> fmt::Result {
    let (why, what) = match refused {
        Refused::Faulted(fault) => (fault.name(), "is latched: clear first"),
        Refused::Busy(state) => (state.name(), "is going on: stop first"),
        Refused::NoFault => ("no fault", "is latched"),
        Refused::NoFriction => ("no friction", "is recorded: record-friction first"),
        Refused::NoCable => ("no cable", "is in this scene: use a pin"),
    };
    write!(line, "refused: {why} {what}")
}

fn show(
    line: &mut impl Write,
    row: &Description,
    conduct: &'static Shared<Conduct<Active>>,
    turn: &mut Turn,
) -> fmt::Result {
    let value = conduct.lock(turn, |conduct| conduct.value(row.setting));
    let value = Decimal(row.to_user(value));
    let (min, max) = (Decimal(row.min), Decimal(row.max));
    write!(line, "{} {value} {} ({min} to {max})", row.name, row.unit)
}

fn status(
    line: &mut impl Write,
    conduct: &'static Shared<Conduct<Active>>,
    turn: &mut Turn,
) -> fmt::Result {
    let status = control::status();
    let (state, fault) = conduct.lock(turn, |conduct| (conduct.state(), conduct.fault()));
    telemetry::status(state, fault, &status);
    let fault = fault.map_or("none", |fault| fault.name());
    let current_ma = Decimal(status.current_a * 1e3);
    let (supply_v, winding_c) = (Decimal(status.supply_v), Decimal(status.winding_c));
    write!(
        line,
        "state {}, position {} counts, current {current_ma} mA, supply {supply_v} V, winding {winding_c} C, fault {fault}",
        state.name(),
        status.position_counts
    )
}
