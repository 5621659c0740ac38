// SPDX-License-Identifier: GPL-2.0-only
//! Executed instructions as a table or as JSON lines.

use palpate_emulator::Machine;
use palpate_emulator::cortex::account::Calls;
use palpate_emulator::cortex::exception_name;
use serde_json::{Value, json};

struct Row<'a> {
    kind: &'static str,
    name: String,
    calls: &'a Calls,
}

impl Row<'_> {
    fn mean(&self, total: u64) -> f64 {
        total as f64 / self.calls.count.max(1) as f64
    }

    fn json(&self) -> Value {
        let Calls {
            count,
            total,
            min_instructions,
            max,
        } = self.calls;
        json!({
            "type": "count",
            "kind": self.kind,
            "name": self.name,
            "calls": count,
            "instructions_min": min_instructions,
            "instructions_mean": self.mean(total.instructions),
            "instructions_max": max.instructions,
            "cycles_low_mean": self.mean(total.cycles_low),
            "cycles_high_mean": self.mean(total.cycles_high),
            "cycles_low_max": max.cycles_low,
            "cycles_high_max": max.cycles_high,
        })
    }

    fn text(&self) -> String {
        let calls = self.calls;
        format!(
            "{:<10} {:>9} {:>8} {:>10.1} {:>8} {:>9} to {:<9} {}",
            self.kind,
            calls.count,
            calls.min_instructions,
            self.mean(calls.total.instructions),
            calls.max.instructions,
            calls.max.cycles_low,
            calls.max.cycles_high,
            self.name,
        )
    }
}

/// Prints interrupts, watched functions and the stacks.
pub fn print(machine: &Machine<'_>, as_json: bool) {
    let account = machine.account();
    let interrupts = account.exceptions().iter().map(|(&number, calls)| Row {
        kind: "interrupt",
        name: exception_name(number),
        calls,
    });
    let functions = account.functions().iter().flat_map(|(name, watched)| {
        let row = |kind, calls| Row {
            kind,
            name: name.clone(),
            calls,
        };
        let mut rows = vec![row("function", &watched.all)];
        if watched.with.count > 0 {
            rows.push(row("without", &watched.without));
            rows.push(row("with", &watched.with));
        }
        rows
    });
    if !as_json {
        println!(
            "\n{:<10} {:>9} {:>8} {:>10} {:>8} {:>22}",
            "", "calls", "min", "mean", "max", "cycles of the longest"
        );
    }
    for row in interrupts.chain(functions) {
        if as_json {
            println!("{}", row.json());
        } else {
            println!("{}", row.text());
        }
    }
    for stack in machine.stacks() {
        if as_json {
            println!(
                "{}",
                json!({ "type": "stack", "name": stack.name, "used_bytes": stack.used, "size_bytes": stack.size })
            );
        } else {
            println!(
                "stack      {:<10} {} of {} bytes used",
                stack.name, stack.used, stack.size
            );
        }
    }
}
