//! Follows control flow from a handler, or from all functions of some modules, through the linked instructions.
//!
//! From the handler's symbol every direct branch and call is followed. A jump through a register or a trap instruction is a
//! violation, since nothing could then be said about where it ends, and so is reaching a function that panics, allocates or
//! formats text or a log record, or one outside the memory that the handler is meant to run from.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use anyhow::{Context, Result};

use crate::thumb::{self, Flow};
use crate::{Image, Symbol};

/// Something that the handler can reach and must not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Address of the instruction.
    pub address: u32,
    /// Functions from the handler, or from one of the modules', to it.
    pub path: Vec<String>,
    /// What is wrong.
    pub what: String,
}

/// What a handler, or some modules, can reach.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Functions, with the handler itself first, or those of the modules.
    pub functions: Vec<Symbol>,
    /// Instructions in them.
    pub instructions: usize,
    /// What it must not.
    pub violations: Vec<Violation>,
}

/// What is said of a function that panics.
const PANICS: &str = "can panic";

/// What no handler may call, as parts of mangled names.
const FORBIDDEN: &[(&str, &str)] = &[
    ("panic", PANICS),
    ("rust_begin_unwind", PANICS),
    ("unwrap_failed", PANICS),
    ("expect_failed", PANICS),
    ("__rust_alloc", "allocates"),
    ("__rust_realloc", "allocates"),
    ("_defmt_", "formats a log record"),
    ("core3fmt", "formats text"),
];

pub fn from(image: &Image, handler: &str, home: &Range<u32>) -> Result<Reach> {
    let first = image
        .symbols()
        .find(|s| s.is_code && s.symbol == handler)
        .with_context(|| format!("no function {handler}"))?;
    Ok(walk(image, vec![first], home))
}

/// Panics that functions of these modules can reach. What is called through a register, and what the compiler has put into functions of
/// others, goes unseen; traps behind calls that do not return, and texts that are formatted, are no matter.
pub fn panics(image: &Image, modules: &[&str]) -> Reach {
    let is_within = |name: &str| modules.iter().any(|module| name.contains(module));
    let first = image
        .symbols()
        .filter(|s| s.is_code && is_within(&s.name()));
    let mut reach = walk(image, first.collect(), &(0..u32::MAX));
    reach.violations.retain(|found| found.what == PANICS);
    reach
}

fn walk(image: &Image, first: Vec<&Symbol>, home: &Range<u32>) -> Reach {
    let mut walk = Walk {
        image,
        home,
        callers: BTreeMap::new(),
        violations: Vec::new(),
        instructions: 0,
    };
    let mut order = Vec::new();
    let (mut seen, mut open) = (BTreeSet::new(), first);
    // Functions with the same instructions share an address.
    open.retain(|function| seen.insert(function.address));
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
    Reach {
        functions: order,
        instructions,
        violations,
    }
}

struct Walk<'a> {
    image: &'a Image,
    /// The memory that all of it must lie in.
    home: &'a Range<u32>,
    /// Who was first seen to call a function.
    callers: BTreeMap<u32, u32>,
    violations: Vec<Violation>,
    instructions: usize,
}

impl<'a> Walk<'a> {
    /// Decodes one function; returns what it calls.
    fn scan(&mut self, function: &Symbol) -> Vec<&'a Symbol> {
        let mut callees = Vec::new();
        if let Some((_, what)) = FORBIDDEN
            .iter()
            .find(|(part, _)| function.symbol.contains(part))
        {
            self.violate(function, function.address, what);
            return callees;
        }
        if !self.home.contains(&function.address) {
            self.violate(function, function.address, "lies in another memory");
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
                Flow::To(target) => match self.image.symbol_at(target) {
                    Some(callee) if callee.is_code => callees.push(callee),
                    _ => self.violate(
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

    fn violate(&mut self, function: &Symbol, address: u32, what: &str) {
        let mut path = vec![function.name()];
        let mut at = function.address;
        while let Some(caller) = self.callers.get(&at) {
            at = *caller;
            path.extend(self.image.symbol_at(at).map(Symbol::name));
        }
        path.reverse();
        self.violations.push(Violation {
            address,
            path,
            what: what.to_owned(),
        });
    }
}

#[cfg(test)]
mod tests {
    use object::write::{Object, StandardSection, Symbol, SymbolSection};
    use object::{Architecture, BinaryFormat, Endianness, SymbolFlags, SymbolKind, SymbolScope};

    use super::*;

    /// Name, code, and how many halfwords at its end are data.
    type Function<'a> = (&'a str, &'a [u16], u32);

    const RETURN: u16 = 0x4770;
    const NOP: u16 = 0xBF00;
    const UNDEFINED: u16 = 0xDE00;
    const CALL_R3: u16 = 0x4798;

    /// A function at one address that calls one at a higher address (`bl`) and returns.
    fn calling(from: u32, to: u32) -> [u16; 3] {
        let halfwords = u16::try_from((to - (from + 4)) / 2).expect("near");
        [0xF000, 0xF800 | halfwords, RETURN]
    }

    /// A handler of three halfwords, and the function that it calls at address 6.
    fn with_callee(handler: &[u16; 3]) -> [Function<'_>; 2] {
        [("ADC1_2", handler, 0), ("compute", &[NOP, RETURN], 0)]
    }

    /// An image of these functions, one after the other from address 0, each with the last `data` halfwords marked as data.
    fn image(functions: &[Function<'_>]) -> Image {
        let mut object = Object::new(BinaryFormat::Elf, Architecture::Arm, Endianness::Little);
        let text = object.section_id(StandardSection::Text);
        let symbol = |object: &mut Object<'_>, name: &str, value, size, kind| {
            object.add_symbol(Symbol {
                name: name.into(),
                value,
                size,
                kind,
                scope: SymbolScope::Compilation,
                weak: false,
                section: SymbolSection::Section(text),
                flags: SymbolFlags::None,
            });
        };
        for (name, code, data) in functions {
            let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
            let size = bytes.len() as u64;
            let at = object.append_section_data(text, &bytes, 2);
            // Bit 0 says Thumb.
            symbol(&mut object, name, at | 1, size, SymbolKind::Text);
            symbol(&mut object, "$t", at, 0, SymbolKind::Label);
            if *data > 0 {
                let start = at + size - 2 * u64::from(*data);
                symbol(&mut object, "$d", start, 0, SymbolKind::Label);
            }
        }
        Image::parse(&object.write().expect("an image")).expect("readable")
    }

    /// Where [`image`] puts functions.
    const EVERYWHERE: Range<u32> = 0..u32::MAX;

    fn wrong(functions: &[Function<'_>]) -> Vec<Violation> {
        let reach = image(functions)
            .reach("ADC1_2", &EVERYWHERE)
            .expect("there is a handler");
        reach.violations
    }

    #[test]
    fn a_handler_that_only_computes_passes() {
        let handler = calling(0, 6);
        let mut functions = Vec::from(with_callee(&handler));
        functions.push(("core9panicking5panic", &[UNDEFINED], 0));
        let reach = image(&functions)
            .reach("ADC1_2", &EVERYWHERE)
            .expect("a handler");
        assert_eq!(reach.violations, []);
        assert_eq!((reach.functions.len(), reach.instructions), (2, 4));
    }

    #[test]
    fn a_panic_is_found_behind_another_function() {
        let found = wrong(&[
            ("ADC1_2", &calling(0, 6), 0),
            ("compute", &calling(6, 12), 0),
            ("_ZN4core9panicking5panic17h0E", &[UNDEFINED], 0),
        ]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].what, "can panic");
        assert_eq!(found[0].path[..2], ["ADC1_2", "compute"]);
        assert_eq!(found[0].path.len(), 3);
    }

    #[test]
    fn a_panic_is_found_from_a_module_and_not_from_others() {
        let functions: &[Function<'_>] = &[
            (
                "_ZN7palpate7sensing4pass17h0123456789abcdefE",
                &calling(0, 6),
                0,
            ),
            ("_ZN4core3fmt5write17h0E", &calling(6, 12), 0),
            ("_ZN4core9panicking5panic17h0E", &[UNDEFINED], 0),
        ];
        // What formats text is not asked what it calls.
        let image = image(functions);
        assert_eq!(image.panics(&["palpate::sensing"]).violations, []);
        let functions = [functions[0], ("compute", functions[1].1, 0), functions[2]];
        let image = self::image(&functions);
        let found = image.panics(&["palpate::finger", "palpate::sensing"]);
        assert_eq!(found.violations.len(), 1);
        assert_eq!(
            found.violations[0].path[..2],
            ["palpate::sensing::pass", "compute"]
        );
        assert_eq!(image.panics(&["palpate::finger"]).functions, []);
    }

    #[test]
    fn log_records_text_and_memory_are_refused() {
        for (name, what) in [
            ("_defmt_acquire", "formats a log record"),
            ("_RNvNtCs0_4core3fmt5write", "formats text"),
            ("__rust_alloc", "allocates"),
        ] {
            let found = wrong(&[("ADC1_2", &calling(0, 6), 0), (name, &[RETURN], 0)]);
            assert_eq!(found.len(), 1, "{name}");
            assert_eq!(found[0].what, what, "{name}");
        }
    }

    #[test]
    fn a_trap_and_a_call_through_a_register_are_refused() {
        for (instruction, what) in [(UNDEFINED, "traps"), (CALL_R3, "jumps through a register")] {
            let found = wrong(&[("ADC1_2", &[NOP, instruction, RETURN], 0)]);
            assert_eq!(found.len(), 1);
            assert_eq!((found[0].address, found[0].what.as_str()), (2, what));
        }
    }

    #[test]
    fn constants_are_no_instructions() {
        let functions: &[Function<'_>] = &[("ADC1_2", &[NOP, RETURN, UNDEFINED, CALL_R3], 2)];
        assert_eq!(wrong(functions), []);
        assert_eq!(wrong(&[("ADC1_2", functions[0].1, 0)]).len(), 2);
    }

    #[test]
    fn an_image_without_the_handler_proves_nothing() {
        assert!(
            image(&[("main", &[RETURN], 0)])
                .reach("ADC1_2", &EVERYWHERE)
                .is_err()
        );
    }

    #[test]
    fn a_function_in_another_memory_is_refused() {
        let handler = calling(0, 6);
        let functions = with_callee(&handler);
        let reach = |home: Range<u32>| image(&functions).reach("ADC1_2", &home).expect("a handler");
        assert_eq!(reach(0..10).violations, []);
        let [far] = &reach(0..6).violations[..] else {
            panic!("one function lies beyond");
        };
        assert_eq!(
            (far.address, far.what.as_str()),
            (6, "lies in another memory")
        );
        assert_eq!(far.path, ["ADC1_2", "compute"]);
        assert_eq!(reach(6..10).violations.len(), 1, "the handler itself");
    }
}
