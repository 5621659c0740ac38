//! Command lines carried out, one after the other, each answered.

use defmt::{Str, intern};
use embassy_stm32::usart::BufferedUartTx;

use palpate::app::command::{Command, Verb};
use palpate::app::conduct::{Conduct, Effect};
use palpate::app::kept;
use palpate::app::line::Line;
use palpate::app::record::{RecordError, decode, encode};
use palpate::app::sense::Sense;
use palpate::app::settings::{Overrides, Setting};
use palpate::app::store::{Found, Writer};
use palpate::drive::Fault;
use palpate::drive::sequence::{Notice, Refused};
use palpate::scene::Active;

use super::Shared;
use super::console::{self, Parsed};
use super::storage::{self, Storage};
use super::{control, telemetry};

/// Whose records count.
const MARK: u32 = kept::mark::<Active>();

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
        Found::Nothing => (Kept::Nothing, intern!("none")),
        Found::Unreadable => (Kept::Nothing, intern!("unreadable")),
        Found::Record { bytes, newest } => restore(bytes, newest, sense),
    });
    telemetry::record(what, storage::bad_words());
    kept
}

fn restore(bytes: &[u8], newest: bool, sense: &'static Shared<Sense<Active>>) -> (Kept, Str) {
    let mut kept = kept::Kept::nothing::<Active>();
    match decode(bytes, MARK, &mut kept) {
        Ok(()) => {
            let overrides = kept.overrides;
            let notice = sense.lock(|sense| sense.borrow_mut().restore(kept));
            let what = match newest {
                true => intern!("loaded"),
                false => intern!("older"),
            };
            (Kept::Restored { overrides, notice }, what)
        }
        Err(error) => (Kept::Unusable, why(error)),
    }
}

fn why(error: RecordError) -> Str {
    match error {
        RecordError::Damaged => intern!("damaged"),
        RecordError::Version { .. } => intern!("other-version"),
        RecordError::OtherScene => intern!("other-scene"),
        RecordError::Implausible => intern!("implausible"),
    }
}

/// Carries out commands.
#[embassy_executor::task]
pub async fn execute(
    mut port: BufferedUartTx<'static>,
    mut storage: Storage,
    sense: &'static Shared<Sense<Active>>,
    conduct: &'static Shared<Conduct<Active>>,
) {
    let mut line = Line::new();
    loop {
        let parsed = console::next().await;
        line.clear();
        let effect = carry_out(&mut line, parsed, conduct);
        if matches!(effect, Effect::Save | Effect::Factory) {
            let overrides = conduct.lock(|conduct| *conduct.borrow().overrides());
            let saves = effect == Effect::Save;
            let encode = |writer: &mut Writer<'_, _>| write_record(sense, overrides, writer);
            match storage.replace(saves.then_some(encode)).await {
                Ok(()) => line.text(if saves { "saved" } else { "forgotten" }),
                Err(error) => line.text("failed: ").text(storage::name(error)),
            };
        }
        let mut row = 0;
        loop {
            console::answer(&mut port, line.as_str()).await;
            row += 1;
            line.clear();
            if !list(&mut line, effect, row, conduct) {
                break;
            }
        }
    }
}

/// Carries a command out as far as flash is not concerned; the line says how that went, or begins the list that was asked for.
#[inline(never)]
fn carry_out(line: &mut Line, parsed: Parsed, conduct: &'static Shared<Conduct<Active>>) -> Effect {
    let effect = match parsed {
        Err(error) => {
            error.write(line.text("error: "));
            return Effect::Accepted;
        }
        // The sequence has taken a stop already, before this line's turn came.
        Ok(Command::Stop) => Effect::Accepted,
        Ok(command) => match conduct.lock(|conduct| conduct.borrow_mut().command(command)) {
            Ok(effect) => effect,
            Err(refused) => {
                refuse(line, refused);
                return Effect::Accepted;
            }
        },
    };
    match effect {
        Effect::Accepted => {
            line.text("ok");
        }
        Effect::Set { at_restart: false } => {
            line.text("ok; save keeps it");
        }
        Effect::Set { at_restart: true } => {
            line.text("ok; acts after save and a restart");
        }
        Effect::Status => status(line, conduct),
        Effect::Help | Effect::Show | Effect::Save | Effect::Factory => {
            list(line, effect, 0, conduct);
        }
    }
    effect
}

/// Apart from [`execute`], so that the record lies on the stack for the moment only.
#[inline(never)]
fn write_record(
    sense: &'static Shared<Sense<Active>>,
    overrides: Overrides,
    writer: &mut Writer<'_, storage::Region>,
) {
    sense.lock(|sense| {
        sense.borrow().keep(overrides, |kept| {
            encode(kept, MARK, |byte| writer.push(byte));
        });
    });
}

/// A row of what `help` and `show` list; false, and nothing written, behind the last one.
#[inline(never)]
fn list(
    line: &mut Line,
    effect: Effect,
    row: usize,
    conduct: &'static Shared<Conduct<Active>>,
) -> bool {
    match effect {
        Effect::Help => {
            let Some(verb) = Verb::ALL.get(row) else {
                return false;
            };
            let line = line.text(verb.name()).text(" ").text(verb.usage());
            line.text(": ").text(verb.summary());
        }
        Effect::Show => {
            let Some(setting) = Setting::ALL.get(row) else {
                return false;
            };
            show(line, *setting, conduct);
        }
        _ => return false,
    }
    true
}

fn refuse(line: &mut Line, refused: Refused) {
    let (why, what) = match refused {
        Refused::Faulted(fault) => (fault.name(), " is latched: clear first"),
        Refused::Busy(state) => (state.name(), " is going on: stop first"),
        Refused::NoFault => ("no fault", " is latched"),
        Refused::NoFriction => ("no friction", " is recorded: record-friction first"),
        Refused::NoCable => ("no cable", " is in this scene: use a pin"),
    };
    line.text("refused: ").text(why).text(what);
}

fn show(line: &mut Line, setting: Setting, conduct: &'static Shared<Conduct<Active>>) {
    let value_si = conduct.lock(|conduct| conduct.borrow().value(setting));
    let range = setting.range();
    let line = line.text(setting.name()).text(" ");
    let line = line.decimal(range.to_user(value_si)).text(" ");
    let line = line.text(setting.unit()).text(" (");
    range.write(line).text(")");
}

fn status(line: &mut Line, conduct: &'static Shared<Conduct<Active>>) {
    let status = control::status();
    let (state, fault) = conduct.lock(|conduct| {
        let conduct = conduct.borrow();
        (conduct.state(), conduct.fault())
    });
    telemetry::status(state, fault, &status);
    let line = line.text("state ").text(state.name());
    let line = line.text(", position ").integer(status.position_counts);
    let line = line
        .text(" counts, current ")
        .decimal(status.current_a * 1e3);
    let line = line.text(" mA, supply ").decimal(status.supply_v);
    let line = line.text(" V, winding ").decimal(status.winding_c);
    line.text(" C, fault ")
        .text(fault.map_or("none", Fault::name));
}
