//! What is in a firmware image: how much flash and RAM it takes, which symbols it has, and what its control interrupt can
//! reach.
//!
//! The reach is a proof on the linked code, not on the source: from the handler's symbol every direct branch and call is
//! followed through the instructions themselves. A jump through a register or a trap instruction is a violation, since
//! nothing could then be said about where it ends, and so is reaching a function that panics, allocates, formats a log
//! record or computes in software double precision.

mod reach;
mod thumb;

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use object::elf::SHF_ALLOC;
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind};

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

/// How much of the chip an image takes, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Code, constants and initial values.
    pub flash: u64,
    /// Static data; the stacks are apart.
    pub ram: u64,
}

/// A linked image, read whole.
pub struct Image {
    size: Size,
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
            size: Size { flash: 0, ram: 0 },
            functions: Vec::new(),
            code: Vec::new(),
            marks: Vec::new(),
        };
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                return Err(anyhow!("not ELF"));
            };
            if (sh_flags & SHF_ALLOC).0 == 0 {
                continue;
            }
            let in_flash = section.address() < RAM_START;
            let initialised = section.kind() == object::SectionKind::Data;
            if in_flash || initialised {
                image.size.flash += section.size();
            }
            if !in_flash {
                image.size.ram += section.size();
            }
            if in_flash && section.kind() == object::SectionKind::Text {
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

    /// How much of the chip it takes.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All functions, by address.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// Routines for double precision, which the core computes in software.
    pub fn software_doubles(&self) -> Vec<&Function> {
        self.functions
            .iter()
            .filter(|f| is_software_double(&f.symbol))
            .collect()
    }

    /// Everything that `handler` can reach.
    ///
    /// # Errors
    /// There is no such function.
    pub fn reach(&self, handler: &str) -> Result<Reach> {
        reach::from(self, handler)
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

/// Where RAM begins; below it lies flash.
const RAM_START: u64 = 0x2000_0000;

/// `__aeabi_dadd` and its kin, and the names they have in compiler-builtins.
fn is_software_double(symbol: &str) -> bool {
    let runtime = symbol.strip_prefix("__aeabi_").is_some_and(|rest| {
        rest.starts_with('d') && !rest.starts_with("div") || rest.ends_with("2d")
    });
    let builtin = symbol.starts_with("__") && symbol.contains("df") && !symbol.contains("tdf");
    runtime || builtin
}

#[cfg(test)]
mod tests {
    use super::is_software_double;

    #[test]
    fn doubles_are_told_from_their_neighbours() {
        for symbol in [
            "__aeabi_dadd",
            "__aeabi_dcmplt",
            "__aeabi_f2d",
            "__aeabi_i2d",
            "__muldf3",
            "__floatsidf",
        ] {
            assert!(is_software_double(symbol), "{symbol}");
        }
        for symbol in [
            "__aeabi_memcpy",
            "__aeabi_uldivmod",
            "__aeabi_fadd",
            "main",
            "__mulsf3",
            "ADC1_2",
        ] {
            assert!(!is_software_double(symbol), "{symbol}");
        }
    }
}
