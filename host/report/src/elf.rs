//! Reading a firmware image: how much memory it takes, its functions, and the call graph from each.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

/// Where the chip's memories are.
const FLASH: std::ops::Range<u64> = 0x0800_0000..0x0802_0000;
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x2000_8000;
const CCM: std::ops::Range<u64> = 0x1000_0000..0x1000_2800;

/// A function or a static.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Demangled name without the hash.
    pub name: String,
    /// First byte.
    pub address: u64,
    /// Bytes.
    pub size: u64,
    /// Code, not data.
    pub is_code: bool,
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

/// A firmware image.
pub struct Image {
    /// What it takes.
    pub footprint: Footprint,
    symbols: BTreeMap<u64, Symbol>,
    debug_names: BTreeSet<String>,
    flash: Vec<(u64, Vec<u8>)>,
}

/// The texts of a table of strings that end with zero, demangled.
fn strings(table: &[u8]) -> BTreeSet<String> {
    table
        .split(|byte| *byte == 0)
        .filter_map(|text| std::str::from_utf8(text).ok())
        .map(|text| format!("{:#}", rustc_demangle::demangle(text)))
        .collect()
}

impl Image {
    /// Reads an ELF.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&bytes).with_context(|| format!("{} is not a firmware image", path.display()))
    }

    /// The same from memory.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let file = object::File::parse(bytes)?;
        let mut footprint = Footprint::default();
        let mut flash = Vec::new();
        for section in file.sections() {
            let (address, size) = (section.address(), section.size());
            if SRAM.contains(&address) {
                footprint.ram_bytes += size;
            } else if CCM.contains(&address) {
                footprint.ccm_bytes += size;
            } else if FLASH.contains(&address) && size > 0 {
                footprint.flash_bytes += size;
                flash.push((address, section.data()?.to_vec()));
                continue;
            } else {
                continue;
            }
            // Statics with a value and code that is copied are in flash as well; cortex-m-rt's `.uninit` is not, whatever
            // its type says.
            let is_copied = section.kind() == SectionKind::Text
                || section.kind() == SectionKind::Data
                    && section.name().is_ok_and(|name| name.starts_with(".data"));
            if is_copied {
                footprint.flash_bytes += size;
            }
        }
        let mut symbols = BTreeMap::new();
        for symbol in file.symbols() {
            let is_code = symbol.kind() == SymbolKind::Text;
            if symbol.size() == 0 || !(is_code || symbol.kind() == SymbolKind::Data) {
                continue;
            }
            // Bit 0 of a function's address says Thumb.
            let address = symbol.address() & if is_code { !1 } else { !0 };
            let name = format!(
                "{:#}",
                rustc_demangle::demangle(symbol.name().unwrap_or_default())
            );
            symbols.insert(
                address,
                Symbol {
                    name,
                    address,
                    size: symbol.size(),
                    is_code,
                },
            );
        }
        let debug_names = match file.section_by_name(".debug_str") {
            Some(section) => strings(&section.uncompressed_data()?),
            None => BTreeSet::new(),
        };
        Ok(Self {
            footprint,
            symbols,
            debug_names,
            flash,
        })
    }

    /// Every function and static with a size.
    pub fn symbols(&self) -> impl Iterator<Item = &Symbol> {
        self.symbols.values()
    }

    /// Every name that the image's code came from, demangled: its symbols, and what the debug information says of functions
    /// that were inlined and of the types that they are made for. Whether the compiler inlines a function does not matter
    /// here.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let symbols = self.symbols.values().map(|symbol| symbol.name.as_str());
        symbols.chain(self.debug_names.iter().map(String::as_str))
    }

    /// The function or static that an address lies in.
    pub fn symbol_at(&self, address: u64) -> Option<&Symbol> {
        let (_, symbol) = self.symbols.range(..=address).next_back()?;
        (address < symbol.address + symbol.size).then_some(symbol)
    }

    fn code(&self, symbol: &Symbol) -> &[u8] {
        self.flash
            .iter()
            .find_map(|(start, bytes)| {
                let from = usize::try_from(symbol.address.checked_sub(*start)?).ok()?;
                bytes.get(from..from + usize::try_from(symbol.size).ok()?)
            })
            .unwrap_or_default()
    }

    /// Text in flash that tells where the machine that built the image keeps its files, up to the end of the text.
    pub fn machine_paths(&self) -> Vec<String> {
        self.flash
            .iter()
            .flat_map(|(_, bytes)| machine_paths(bytes))
            .collect()
    }

    /// Every function that is reached from the one at `address` by calls and jumps to fixed places, and every static that
    /// it names, itself included. Calls through pointers are not followed.
    pub fn reached_from(&self, address: u64) -> Vec<&Symbol> {
        let mut found = BTreeSet::new();
        let mut open = vec![address & !1];
        while let Some(symbol) = open.pop().and_then(|address| self.symbol_at(address)) {
            if found.insert(symbol.address) && symbol.is_code {
                open.extend(
                    references(symbol.address, self.code(symbol))
                        .into_iter()
                        .filter(|&to| self.symbol_at(to).is_some()),
                );
            }
        }
        found
            .iter()
            .filter_map(|address| self.symbols.get(address))
            .collect()
    }
}

/// Parts of paths below which compilers keep sources and users their files.
const MACHINE_FOLDERS: &[&str] = &[
    "registry/src/",
    "rustlib/src/",
    "/root/",
    "/home/",
    "/Users/",
    "/target/",
];

fn machine_paths(bytes: &[u8]) -> Vec<String> {
    bytes
        .split(|byte| !(b' '..=b'~').contains(byte))
        .map(String::from_utf8_lossy)
        .filter_map(|text| {
            let at = MACHINE_FOLDERS
                .iter()
                .filter_map(|folder| text.find(folder))
                .min()?;
            text.get(at..).map(str::to_owned)
        })
        .collect()
}

/// Addresses that a function's code names: BL and B.W, MOVW with MOVT, and words (literals).
fn references(start: u64, code: &[u8]) -> Vec<u64> {
    let half = |at: usize| -> u32 {
        code.get(at..at + 2)
            .map_or(0, |two| u32::from(u16::from_le_bytes([two[0], two[1]])))
    };
    let mut found = Vec::new();
    // Lower halves that MOVW has put into registers.
    let mut low = [0u32; 16];
    let mut at = 0;
    while at + 1 < code.len() {
        let first = half(at);
        let is_wide = first >= 0xE800;
        if !is_wide {
            at += 2;
            continue;
        }
        let second = half(at + 2);
        let immediate16 =
            (first & 0xF) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xFF;
        let register = (second >> 8 & 0xF) as usize;
        if first & 0xF800 == 0xF000 && second & 0x9000 == 0x9000 {
            // BL (bit 14 set) and B.W.
            let sign = first >> 10 & 1;
            let (j1, j2) = (second >> 13 & 1, second >> 11 & 1);
            let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
            let offset =
                sign << 24 | i1 << 23 | i2 << 22 | (first & 0x3FF) << 12 | (second & 0x7FF) << 1;
            let offset = i64::from((offset << 7) as i32 >> 7);
            let next = i64::try_from(start).unwrap_or_default() + at as i64 + 4;
            found.push(u64::try_from(next + offset).unwrap_or_default());
        } else if first & 0xFBF0 == 0xF240 && second & 0x8000 == 0 {
            low[register] = immediate16;
        } else if first & 0xFBF0 == 0xF2C0 && second & 0x8000 == 0 {
            found.push(u64::from(immediate16 << 16 | low[register]) & !1);
        }
        at += 4;
    }
    // Literal pools: words that are addresses in flash. A misread instruction pair is no address of a symbol's start.
    for word in code.chunks_exact(4) {
        let value = u64::from(u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        if FLASH.contains(&value) {
            found.push(value & !1);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{machine_paths, references};

    #[test]
    fn paths_of_the_building_machine_among_other_text() {
        let bytes = b"rad/ssrc/board/mod.rs\0okok/home/me/.cargo/registry/src/i/a-1.0/src/lib.rs\x01/rustc/1/library";
        assert_eq!(
            machine_paths(bytes),
            ["/home/me/.cargo/registry/src/i/a-1.0/src/lib.rs"]
        );
    }

    #[test]
    fn calls_forwards_and_backwards() {
        // bl +0x100 at 0x0800_0000: offset 0xFC after the pipeline's 4.
        let forwards = [0x00, 0xF0, 0x7E, 0xF8];
        assert_eq!(references(0x0800_0000, &forwards), [0x0800_0100]);
        // b.w to itself: offset -4.
        let itself = [0xFF, 0xF7, 0xFE, 0xBF];
        assert_eq!(references(0x0800_0200, &itself), [0x0800_0200]);
    }

    #[test]
    fn an_address_in_two_halves() {
        // movw r0, #0x1234; movt r0, #0x0800
        let code = [0x41, 0xF2, 0x34, 0x20, 0xC0, 0xF6, 0x00, 0x00];
        assert_eq!(references(0x0800_0000, &code), [0x0800_1234]);
    }
}
