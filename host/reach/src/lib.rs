//! Code that the control interrupt of a firmware image can reach: a proof on the linked code, not on the source.
//!
//! From the handler's symbol every direct branch and call is followed through the instructions themselves. A jump through
//! a register or a trap instruction is a violation, since nothing could then be said about where it ends, and so is
//! reaching a function that panics, allocates or formats text or a log record, or one outside the memory that the handler
//! is meant to run from.

mod reach;
mod thumb;

use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

pub use reach::{Reach, Violation};

/// A function of the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Mangled name.
    pub symbol: String,
    /// First instruction.
    pub address: u32,
    /// Bytes.
    pub size: u32,
}

impl Function {
    /// Name as the source has it.
    pub fn name(&self) -> String {
        format!("{:#}", rustc_demangle::demangle(&self.symbol))
    }
}

/// A linked image, read whole.
pub struct Image {
    functions: Vec<Function>,
    /// Code by address: start and bytes.
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
        Self::parse(&bytes).with_context(|| format!("{} is no firmware image", path.display()))
    }

    fn parse(bytes: &[u8]) -> Result<Self> {
        let file = object::File::parse(bytes)?;
        let address = |value: u64| u32::try_from(value).context("an address above 4 GiB");
        let mut image = Self {
            functions: Vec::new(),
            code: Vec::new(),
            marks: Vec::new(),
        };
        for section in file.sections() {
            if section.kind() == SectionKind::Text {
                image
                    .code
                    .push((address(section.address())?, section.data()?.to_vec()));
            }
        }
        for symbol in file.symbols() {
            let name = symbol.name()?;
            match name.get(..2) {
                Some("$t") => image.marks.push((address(symbol.address())?, true)),
                Some("$d") => image.marks.push((address(symbol.address())?, false)),
                _ if symbol.kind() == SymbolKind::Text && !symbol.is_undefined() => {
                    image.functions.push(Function {
                        symbol: name.to_owned(),
                        // Bit 0 says Thumb.
                        address: address(symbol.address())? & !1,
                        size: address(symbol.size())?,
                    });
                }
                _ => {}
            }
        }
        image.functions.sort_by_key(|f| (f.address, f.size));
        image.marks.sort_unstable();
        Ok(image)
    }

    /// All functions, by address.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// Everything that `handler` can reach; all of it must lie in `home`.
    ///
    /// # Errors
    /// There is no such function.
    pub fn reach(&self, handler: &str, home: &Range<u32>) -> Result<Reach> {
        reach::from(self, handler, home)
    }

    /// The function that contains `address`.
    fn function_at(&self, address: u32) -> Option<&Function> {
        let end = self.functions.partition_point(|f| f.address <= address);
        self.functions[..end]
            .iter()
            .rev()
            .find(|f| address < f.address + f.size.max(2))
    }

    fn halfword(&self, address: u32) -> Option<u16> {
        let (start, bytes) = self
            .code
            .iter()
            .find(|(start, bytes)| (*start..*start + bytes.len() as u32).contains(&address))?;
        let at = (address - start) as usize;
        Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]))
    }

    /// Whether the bytes at `address` are instructions.
    fn is_code(&self, address: u32) -> bool {
        let end = self.marks.partition_point(|(start, _)| *start <= address);
        end.checked_sub(1).is_none_or(|last| self.marks[last].1)
    }
}
