//! Follows control flow from a handler through the linked instructions.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};

use crate::thumb::{self, Flow};
use crate::{Function, Image};

/// Something that the handler can reach and must not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Address of the instruction.
    pub address: u32,
    /// Functions from the handler to it.
    pub path: Vec<String>,
    /// What is wrong.
    pub what: String,
}

/// What a handler can reach.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Functions, with the handler itself first.
    pub functions: Vec<Function>,
    /// Instructions in them.
    pub instructions: usize,
    /// What it must not.
    pub violations: Vec<Violation>,
}

/// What no handler may call, as parts of mangled names.
const FORBIDDEN: &[(&str, &str)] = &[
    ("panic", "can panic"),
    ("rust_begin_unwind", "can panic"),
    ("unwrap_failed", "can panic"),
    ("expect_failed", "can panic"),
    ("__rust_alloc", "allocates"),
    ("__rust_realloc", "allocates"),
    ("_defmt_", "formats a log record"),
    ("core3fmt", "formats text"),
];

pub fn from(image: &Image, handler: &str) -> Result<Reach> {
    let first = image
        .functions()
        .iter()
        .find(|f| f.symbol == handler)
        .with_context(|| format!("no function {handler}"))?;
    let mut walk = Walk {
        image,
        callers: BTreeMap::new(),
        violations: Vec::new(),
        instructions: 0,
    };
    let mut order = Vec::new();
    let mut seen = BTreeSet::from([first.address]);
    let mut open = vec![first];
    while let Some(function) = open.pop() {
        order.push(function.clone());
        for callee in walk.scan(function) {
            if seen.insert(callee.address) {
                walk.callers.insert(callee.address, function.address);
                open.push(callee);
            }
        }
    }
    let Walk {
        violations,
        instructions,
        ..
    } = walk;
    Ok(Reach {
        functions: order,
        instructions,
        violations,
    })
}

struct Walk<'a> {
    image: &'a Image,
    /// Who was first seen to call a function.
    callers: BTreeMap<u32, u32>,
    violations: Vec<Violation>,
    instructions: usize,
}

impl<'a> Walk<'a> {
    /// Decodes one function; returns what it calls.
    fn scan(&mut self, function: &Function) -> Vec<&'a Function> {
        let mut callees = Vec::new();
        if let Some((_, what)) = FORBIDDEN
            .iter()
            .find(|(part, _)| function.symbol.contains(part))
        {
            self.violate(function, function.address, what);
            return callees;
        }
        if function.size == 0 {
            self.violate(
                function,
                function.address,
                "has no size: its end is unknown",
            );
            return callees;
        }
        let end = function.address + function.size;
        let mut at = function.address;
        while at < end {
            if !self.image.is_code(at) {
                at += 2;
                continue;
            }
            let Some(instruction) = self.image.halfword(at) else {
                self.violate(function, at, "lies outside the code");
                return callees;
            };
            let length = thumb::length(instruction);
            let flow = if length == 2 {
                thumb::flow16(instruction, at)
            } else {
                match self.image.halfword(at + 2) {
                    Some(second) => thumb::flow32(instruction, second, at),
                    None => Flow::Trap,
                }
            };
            match flow {
                Flow::Local => {}
                Flow::To(target) if (function.address..end).contains(&target) => {}
                Flow::To(target) => match self.image.function_at(target) {
                    Some(callee) => callees.push(callee),
                    None => self.violate(
                        function,
                        at,
                        &format!("branches to {target:#010x}, no function"),
                    ),
                },
                Flow::Indirect => self.violate(function, at, "jumps through a register"),
                Flow::Trap => self.violate(function, at, "traps"),
            }
            self.instructions += 1;
            at += length;
        }
        callees
    }

    fn violate(&mut self, function: &Function, address: u32, what: &str) {
        let mut path = vec![function.name()];
        let mut at = function.address;
        while let Some(caller) = self.callers.get(&at) {
            at = *caller;
            path.extend(self.image.function_at(at).map(Function::name));
        }
        path.reverse();
        self.violations.push(Violation {
            address,
            path,
            what: what.to_owned(),
        });
    }
}
