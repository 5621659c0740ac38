// SPDX-License-Identifier: GPL-2.0-only
//! What did not go as it was asked for, at the end of `sim`.

use palpate_emulator::sim::{Injected, Session, Step};

/// Says it; `fault` is one that was not injected.
pub fn tell(session: &Session<'_>, fault: Option<Injected>, max_s: f64) {
    if !session.resets.is_empty() {
        eprintln!(
            "error: the chip was reset {} times; the lines `crash`, `watchdog` and `chip:` above say why",
            session.resets.len()
        );
    }
    if session.timed_out() && !session.completed() {
        eprintln!(
            "error: the firmware did not reach its final state within {max_s} s; --max-s allows more"
        );
    }
    if let Some(Injected { fault, at_s }) = fault {
        let (name, end_s) = (fault.name, session.machine.time_s());
        eprintln!(
            "error: {name}@{at_s} not injected: the run ended at {end_s:.3} s; --max-s and --keep-running make it longer"
        );
    }
    for (step, answer) in &session.refused {
        eprintln!("error: the firmware did not carry out '{step}': {answer}");
    }
    if let Some(left) = left(session) {
        eprintln!("error: {left}");
    }
}

/// Commands that were not entered, why not, and how to go on.
fn left(session: &Session<'_>) -> Option<String> {
    let steps = session.not_entered();
    if steps.is_empty() {
        return None;
    }
    let names: Vec<String> = steps.iter().map(Step::to_string).collect();
    let names = names.join("; ");
    Some(match session.faults.last() {
        Some((_, fault)) if !session.ended() => format!(
            "the fault {fault} ended the run, so these commands were not entered: {names}; with --keep-running, or with `clear` among \
             them, it goes on after a fault"
        ),
        _ => format!("the run ended before these commands were entered: {names}"),
    })
}
