// SPDX-License-Identifier: GPL-2.0-only
//! The firmware image: what goes into flash, its symbols, its log format tables.

use std::path::{Path, PathBuf};

use defmt_decoder::{Locations, Table};
use object::{Object, ObjectSymbol, SymbolKind};
use palpate::app::storage::store::{PAGE, PAGES};

use crate::Error;
use crate::chip::FLASH_SIZE;
use crate::cortex::Map;

/// A function of the firmware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Address of its first instruction.
    pub address: u32,
    /// Length in bytes.
    pub size: u32,
    /// Demangled name.
    pub name: String,
}

/// An ELF file of the firmware.
#[derive(Debug)]
pub struct Firmware {
    /// Contents of the flash after programming it into an erased chip.
    pub(crate) image: Vec<u8>,
    functions: Vec<Function>,
    symbols: Vec<(String, u32)>,
    pub(crate) table: Option<Table>,
    pub(crate) locations: Locations,
}

impl Firmware {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// The file cannot be read, is no 32-bit Arm ELF, does not fit the flash, or its log tables do not parse.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let data = std::fs::read(path).map_err(|source| Error::Read {
            path: path.to_owned(),
            source,
        })?;
        let bad = |why: String| Error::Elf {
            path: path.to_owned(),
            why: format!("{why}; `cargo xtask build` makes an image and prints its path"),
        };
        let elf = object::File::parse(&*data).map_err(|e| bad(e.to_string()))?;
        if elf.architecture() != object::Architecture::Arm {
            return Err(bad(format!(
                "built for {:?}, not for Arm",
                elf.architecture()
            )));
        }
        let mut image = vec![0xFF; FLASH_SIZE];
        load_segments(&data, &mut image).map_err(bad)?;
        let mut functions: Vec<Function> = Vec::new();
        let mut symbols = Vec::new();
        for symbol in elf.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let address = symbol.address() as u32;
            if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                let name = format!("{:#}", rustc_demangle::demangle(name));
                functions.push(Function {
                    address: address & !1,
                    size: symbol.size() as u32,
                    name,
                });
            }
            symbols.push((name.to_owned(), address));
        }
        functions.sort_by_key(|f| f.address);
        let table = Table::parse(&data).map_err(|e| bad(format!("log tables: {e}")))?;
        let locations = match &table {
            Some(table) => table
                .get_locations(&data)
                .map_err(|e| bad(format!("log locations: {e}")))?,
            None => Locations::default(),
        };
        Ok(Self {
            image,
            functions,
            symbols,
            table,
            locations,
        })
    }

    /// A flash image without symbols or log tables, for tests of the chip. Shorter than the flash: the rest is erased.
    #[must_use]
    pub fn raw(mut image: Vec<u8>) -> Self {
        image.resize(FLASH_SIZE, 0xFF);
        Self {
            image,
            functions: Vec::new(),
            symbols: Vec::new(),
            table: None,
            locations: Locations::default(),
        }
    }

    /// Contents of the flash after this program is put onto a chip that had these: the pages of records stay, as when a board is
    /// flashed.
    #[must_use]
    pub fn flashed_over(&self, flash: &[u8]) -> Vec<u8> {
        let mut image = self.image.clone();
        let records = FLASH_SIZE - PAGES * PAGE..;
        if let (Some(pages), Some(kept)) = (image.get_mut(records.clone()), flash.get(records))
            && kept.len() == pages.len()
        {
            pages.copy_from_slice(kept);
        }
        image
    }

    /// Address of a symbol by its exact name in the file.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.iter().find(|s| s.0 == name).map(|s| s.1)
    }

    /// Address of the first symbol with `part` in its name, mangled as in the file.
    #[must_use]
    pub fn symbol_with(&self, part: &str) -> Option<u32> {
        self.symbols
            .iter()
            .find(|s| s.0.contains(part))
            .map(|s| s.1)
    }

    /// The function an address lies in.
    #[must_use]
    pub fn function_at(&self, address: u32) -> Option<&Function> {
        let index = self
            .functions
            .partition_point(|f| f.address <= address)
            .checked_sub(1)?;
        self.functions
            .get(index)
            .filter(|f| address < f.address + f.size)
    }

    /// Functions whose demangled name contains `part`.
    pub fn functions<'a>(&'a self, part: &'a str) -> impl Iterator<Item = &'a Function> {
        self.functions.iter().filter(move |f| f.name.contains(part))
    }
}

/// Copies segments to their load addresses in flash, not to where they run.
fn load_segments(data: &[u8], image: &mut [u8]) -> Result<(), String> {
    use object::read::elf::{FileHeader, ProgramHeader};
    let header =
        object::elf::FileHeader32::<object::Endianness>::parse(data).map_err(|e| e.to_string())?;
    let endian = header.endian().map_err(|e| e.to_string())?;
    for segment in header
        .program_headers(endian, data)
        .map_err(|e| e.to_string())?
    {
        let bytes = segment
            .data(endian, data)
            .map_err(|()| "a segment lies outside the file".to_owned())?;
        if segment.p_type(endian) != object::elf::PT_LOAD || bytes.is_empty() {
            continue;
        }
        let address = segment.p_paddr(endian);
        let start = address.wrapping_sub(Map::FLASH) as usize;
        let place = start
            .checked_add(bytes.len())
            .and_then(|end| image.get_mut(start..end));
        let place = place.ok_or_else(|| {
            format!(
                "{} bytes at {address:#010x} lie outside the flash",
                bytes.len()
            )
        })?;
        place.copy_from_slice(bytes);
    }
    Ok(())
}

/// A place in the firmware, for messages.
pub(crate) fn place(firmware: &Firmware, address: u32) -> String {
    match firmware.function_at(address) {
        Some(function) => format!("{address:#010x} in {}", function.name),
        None => format!("{address:#010x}"),
    }
}

/// Where the firmware is, unless told otherwise.
#[must_use]
pub fn default_path() -> PathBuf {
    PathBuf::from("target/thumbv7em-none-eabihf/release/palpate")
}
