//! Reads an ELF file for the chip.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use crate::paths::machine_paths;
use crate::reach::{self, Reach};
use crate::sleeps::Sleeps;
use crate::thumb::{self, Flow};
use crate::uses;

/// Where the chip's memories are.
pub(crate) const FLASH: Range<u32> = 0x0800_0000..0x0802_0000;
const SRAM: Range<u32> = 0x2000_0000..0x2000_8000;
/// The CCM SRAM, by the address at which the core fetches from it without wait states.
pub const CCM: Range<u32> = 0x1000_0000..0x1000_2800;

/// A function or a static.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Mangled name.
    pub symbol: String,
    /// First byte.
    pub address: u32,
    /// Bytes; zero where the assembler was not told.
    pub size: u32,
    /// Code, not data.
    pub is_code: bool,
}

impl Symbol {
    /// Name as the source has it, without the hash.
    #[must_use]
    pub fn name(&self) -> String {
        demangled(&self.symbol)
    }
}

fn demangled(symbol: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(symbol))
}

/// What of the chip's memories is taken before the first call.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Footprint {
    /// Code, that which is copied to CCM SRAM included, constants and the initial values of statics.
    pub flash_bytes: u64,
    /// Statics in SRAM.
    pub ram_bytes: u64,
    /// Code that runs from CCM SRAM.
    pub ccm_bytes: u64,
}

impl Footprint {
    fn add(&mut self, section: &object::Section<'_, '_>, address: u32) {
        let size = section.size();
        if FLASH.contains(&address) {
            self.flash_bytes += size;
            return;
        }
        if SRAM.contains(&address) {
            self.ram_bytes += size;
        } else if CCM.contains(&address) {
            self.ccm_bytes += size;
        } else {
            return;
        }
        // Statics with a value and code that is copied are in flash as well; cortex-m-rt's `.uninit` is not, whatever its type
        // says.
        let is_copied = section.kind() == SectionKind::Text
            || section.kind() == SectionKind::Data
                && section.name().is_ok_and(|name| name.starts_with(".data"));
        if is_copied {
            self.flash_bytes += size;
        }
    }
}

/// A linked image, read whole.
pub struct Image {
    /// What it takes.
    pub footprint: Footprint,
    /// Address of the first instruction after a reset.
    entry: u32,
    /// Functions, and statics with a size, by address.
    symbols: Vec<Symbol>,
    debug_names: BTreeSet<String>,
    /// Contents by address: start and bytes.
    flash: Vec<(u32, Vec<u8>)>,
    code: Vec<(u32, Vec<u8>)>,
    /// Starts of code (true) and data (false) inside functions, by address.
    marks: Vec<(u32, bool)>,
}

impl Image {
    /// Reads an ELF file for the chip.
    ///
    /// # Errors
    /// The file cannot be read, or is no ELF file with symbols.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&bytes).with_context(|| format!("{} is not a firmware image", path.display()))
    }

    /// Reads the bytes of one.
    ///
    /// # Errors
    /// They are no ELF file with symbols.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let file = object::File::parse(bytes)?;
        let mut image = Self {
            footprint: Footprint::default(),
            entry: 0,
            symbols: Vec::new(),
            debug_names: BTreeSet::new(),
            flash: Vec::new(),
            code: Vec::new(),
            marks: Vec::new(),
        };
        let word = |value: u64| u32::try_from(value).context("an address above 4 GiB");
        image.entry = word(file.entry())? & !1;
        for section in file.sections() {
            let address = word(section.address())?;
            image.footprint.add(&section, address);
            if FLASH.contains(&address) && section.size() > 0 {
                image.flash.push((address, section.data()?.to_vec()));
            }
            if section.kind() == SectionKind::Text {
                image.code.push((address, section.data()?.to_vec()));
            }
        }
        for symbol in file.symbols() {
            let (name, address) = (symbol.name()?, word(symbol.address())?);
            let is_code = symbol.kind() == SymbolKind::Text && !symbol.is_undefined();
            let is_static = symbol.kind() == SymbolKind::Data && symbol.size() > 0;
            match name.get(..2) {
                Some("$t") => image.marks.push((address, true)),
                Some("$d") => image.marks.push((address, false)),
                _ if is_code || is_static => image.symbols.push(Symbol {
                    symbol: name.to_owned(),
                    // Bit 0 of a function's address says Thumb.
                    address: address & if is_code { !1 } else { !0 },
                    size: word(symbol.size())?,
                    is_code,
                }),
                _ => {}
            }
        }
        // Of several at one address the last is found: not one without a size.
        image.symbols.sort_by_key(|s| (s.address, s.size > 0));
        image.marks.sort_unstable();
        if let Some(section) = file.section_by_name(".debug_str") {
            image.debug_names = strings(&section.uncompressed_data()?);
        }
        Ok(image)
    }

    /// What flash holds at which address.
    pub fn flash(&self) -> impl Iterator<Item = (u32, &[u8])> {
        self.flash
            .iter()
            .map(|(address, bytes)| (*address, bytes.as_slice()))
    }

    /// Every function and static.
    pub fn symbols(&self) -> impl Iterator<Item = &Symbol> {
        self.symbols.iter()
    }

    /// Every name that the image's code came from, demangled: its symbols, and what the debug information says of functions
    /// that were inlined and of the types that they are made for. Whether the compiler inlines a function does not matter
    /// here.
    pub fn names(&self) -> impl Iterator<Item = String> {
        let symbols = self.symbols.iter().map(Symbol::name);
        symbols.chain(self.debug_names.iter().cloned())
    }

    /// The function or static that an address lies in.
    #[must_use]
    pub fn symbol_at(&self, address: u32) -> Option<&Symbol> {
        let end = self.symbols.partition_point(|s| s.address <= address);
        let symbol = self.symbols.get(end.checked_sub(1)?)?;
        (address < symbol.address + symbol.size.max(1)).then_some(symbol)
    }

    /// The function that the first instruction after a reset calls; `None` if it calls none.
    #[must_use]
    pub fn first_call(&self) -> Option<&Symbol> {
        let [first, second] = [0, 2].map(|offset| self.halfword(self.entry + offset));
        // BL.
        let (first, second) = (first?, second.filter(|second| second & 0xD000 == 0xD000)?);
        match thumb::flow32(first, second, self.entry) {
            Flow::To(address) => self.symbol_at(address),
            _ => None,
        }
    }

    /// Everything that the function at `address` uses, itself included: functions that it calls or jumps to at fixed places,
    /// and statics that it names. Calls through pointers are not followed.
    #[must_use]
    pub fn used_from(&self, address: u32) -> Vec<&Symbol> {
        uses::from(self, address)
    }

    /// Everything that `handler` can reach; all of it must lie in `home`.
    ///
    /// # Errors
    /// There is no such function.
    pub fn reach(&self, handler: &str, home: &Range<u32>) -> Result<Reach> {
        reach::from(self, handler, home)
    }

    /// Panics that functions of these modules, named as in the source, can reach; what they call through a register is not followed.
    #[must_use]
    pub fn panics(&self, modules: &[&str]) -> Reach {
        reach::panics(self, modules)
    }

    /// Where it lets the core sleep.
    pub fn sleeps(&self) -> Sleeps {
        Sleeps::of(self)
    }

    /// Text in flash that tells where the machine that built the image keeps its files.
    #[must_use]
    pub fn machine_paths(&self) -> Vec<String> {
        let sections = self.flash.iter();
        sections
            .flat_map(|(_, bytes)| machine_paths(bytes))
            .collect()
    }

    /// The instructions and literals of a function.
    pub(crate) fn code(&self, function: &Symbol) -> &[u8] {
        self.bytes(function.address, function.size as usize)
            .unwrap_or_default()
    }

    pub(crate) fn halfword(&self, address: u32) -> Option<u16> {
        let bytes = self.bytes(address, 2)?;
        Some(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    fn bytes(&self, address: u32, size: usize) -> Option<&[u8]> {
        self.code.iter().find_map(|(start, bytes)| {
            let from = address.checked_sub(*start)? as usize;
            bytes.get(from..from + size)
        })
    }

    /// Whether the bytes at `address` are instructions.
    pub(crate) fn is_code(&self, address: u32) -> bool {
        let end = self.marks.partition_point(|(start, _)| *start <= address);
        end.checked_sub(1).is_none_or(|last| self.marks[last].1)
    }
}

/// The texts of a table of strings that end with zero, demangled.
fn strings(table: &[u8]) -> BTreeSet<String> {
    table
        .split(|byte| *byte == 0)
        .filter_map(|text| std::str::from_utf8(text).ok())
        .map(demangled)
        .collect()
}
