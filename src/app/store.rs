//! The record in flash: which pages, how a save replaces it at once or not at all, and what is found after a power cut or
//! damage.
//!
//! `sequential-storage` appends records to a ring of pages, each with a checksum, and erases the page ahead of the one in
//! use: wear is level, and the old record stays until the new one is whole. Three things are added:
//! - [`Store::load`] first finishes what a power cut left half done. A page whose erasing was cut short may read as any
//!   state at all; taken for the page in use, it would hide the record.
//! - A word whose writing was cut short may read as erased although it is not. The flash refuses to program it; it is
//!   overwritten with zeros, which flash with an error-correcting code always takes, and the save goes on behind it.
//! - A record that is older than what was saved last is told apart from the last one.

use core::cell::Cell;
use core::ops::Range;

use crc::{CRC_32_ISCSI, Crc};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage, SerializationError, Value};

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// Key of the one record.
const RECORD: u8 = 1;
/// Zero bits in the first and last byte of a page from which on `sequential-storage` takes it for marked.
const MARKED_BITS: u32 = 4;
/// Tries of a save: each that meets an unfinished word gets past it. One power cut leaves one; damage may leave more.
const TRIES: u8 = 32;
/// What is saved to hide a record that shall be forgotten: shorter than any record.
const FORGOTTEN: [u8; 4] = *b"none";
/// Bytes compared at once.
const CHUNK: usize = 64;
/// Longest word of a flash that is supported, bytes.
const WORD_MAX: usize = 32;

/// Flash that holds records.
pub trait Memory: NorFlash {
    /// Reads without waiting: what is looked at here is in the address space.
    ///
    /// # Errors
    /// The flash failed.
    fn look(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error>;

    /// Whether a write failed because what it was to write on is not erased. It may read as if it were.
    fn is_unfinished(error: &Self::Error) -> bool;
}

/// Why a record was not read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError<E> {
    /// The flash refused or failed.
    Flash(E),
    /// The record does not fit, or the pages make no sense; `factory` starts anew.
    Layout,
    /// What was written cannot be read back: worn out.
    NotKept,
}

impl<E> From<sequential_storage::Error<E>> for StoreError<E> {
    fn from(error: sequential_storage::Error<E>) -> Self {
        match error {
            sequential_storage::Error::Storage { value } => Self::Flash(value),
            _ => Self::Layout,
        }
    }
}

/// What is in the pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found<'b> {
    /// Nothing was ever saved, or it was forgotten.
    Nothing,
    /// Something was saved or begun to be, and no whole record is left.
    Unreadable,
    /// A whole record.
    Record {
        /// Its bytes.
        bytes: &'b [u8],
        /// Nothing newer is there; otherwise what is newer is damaged, or its save was cut short.
        newest: bool,
    },
}

/// State of a page as `sequential-storage` reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Page {
    Open,
    InUse,
    Full,
    /// The end is marked and the start is not.
    Broken,
}

/// The pages. All futures must be run to their end.
#[derive(Debug)]
pub struct Store<F: Memory> {
    map: Map<F>,
    range: Range<u32>,
}

/// `MapStorage` shows nothing of itself.
struct Map<F: Memory>(MapStorage<u8, Spoiling<F>, Cache<Uncached, Uncached, Uncached, u8>>);

impl<F: Memory> core::fmt::Debug for Map<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Map")
    }
}

impl<F: Memory> Store<F> {
    /// Takes the flash and the part of it that holds records: whole pages, three at least. `None` where they are not.
    pub fn new(memory: F, range: Range<u32>) -> Option<Self> {
        let pages = range.end.checked_sub(range.start)? / F::ERASE_SIZE as u32;
        if pages < 3 || F::WRITE_SIZE > WORD_MAX {
            return None;
        }
        let config = MapConfig::try_new(range.clone()).ok()?;
        let map = MapStorage::new(Spoiling(memory), config, Cache::new_uncached());
        Some(Self {
            map: Map(map),
            range,
        })
    }

    /// The flash.
    pub fn memory(&mut self) -> &mut F {
        &mut self.map.0.flash().0
    }

    /// Finishes what a power cut left half done, then reads the last record saved that is whole. `buffer` must hold the
    /// longest record and a word more.
    ///
    /// # Errors
    /// The flash failed, or a record is there that `buffer` cannot hold.
    pub async fn load<'b>(
        &mut self,
        buffer: &'b mut [u8],
    ) -> Result<Found<'b>, StoreError<F::Error>> {
        self.mend().await?;
        let Some(bytes) = self.map.0.fetch_item::<&[u8]>(buffer, &RECORD).await? else {
            return Ok(match self.newest_page(None)? {
                None => Found::Nothing,
                Some(_) => Found::Unreadable,
            });
        };
        let newest = self.newest_page(Some(bytes))?.unwrap_or(true);
        if let Some(page) = self.moved_from(bytes)? {
            self.erase(page).await?;
        }
        Ok(match (bytes == FORGOTTEN, newest) {
            (true, true) => Found::Nothing,
            (true, false) => Found::Unreadable,
            (false, _) => Found::Record { bytes, newest },
        })
    }

    /// Saves the record that `encode` writes, of as many bytes as it says (`None`: it does not fit). After a power cut at
    /// any moment the old record is there, or the new one, whole.
    ///
    /// # Errors
    /// Nothing was saved: the flash failed, or the record does not fit or cannot be read back.
    pub async fn save(
        &mut self,
        buffer: &mut [u8],
        encode: impl Fn(&mut [u8]) -> Option<usize>,
    ) -> Result<(), StoreError<F::Error>> {
        let encoder = Encoder {
            encode,
            checksum: Cell::new(0),
        };
        let mut tries = TRIES;
        loop {
            tries -= 1;
            match self.map.0.store_item(buffer, &RECORD, &encoder).await {
                Err(sequential_storage::Error::Storage { value })
                    if tries > 0 && F::is_unfinished(&value) => {}
                result => {
                    result?;
                    break;
                }
            }
        }
        let kept = self.map.0.fetch_item::<&[u8]>(buffer, &RECORD).await?;
        match kept {
            Some(bytes) if CHECKSUM.checksum(bytes) == encoder.checksum.get() => Ok(()),
            _ => Err(StoreError::NotKept),
        }
    }

    /// Forgets the record and what came before it. After a power cut at any moment the record is there, whole, or nothing.
    ///
    /// # Errors
    /// The flash failed.
    pub async fn forget(&mut self, buffer: &mut [u8]) -> Result<(), StoreError<F::Error>> {
        // A record of nothing hides the old ones while they are erased, from ahead of it on round the ring. Where even that
        // cannot be saved, everything is erased.
        let nothing = |room: &mut [u8]| {
            room.get_mut(..FORGOTTEN.len())?.copy_from_slice(&FORGOTTEN);
            Some(FORGOTTEN.len())
        };
        let hidden = self.save(buffer, nothing).await.is_ok();
        let mut in_use = self.range.start;
        for page in self.pages() {
            if self.state(page)? == Page::InUse {
                in_use = page;
            }
        }
        let around = (in_use..self.range.end).chain(self.range.start..in_use);
        for page in around.step_by(F::ERASE_SIZE) {
            if !hidden || page != in_use {
                self.erase(page).await?;
            }
        }
        Ok(())
    }

    /// Finishes erasing what a power cut left half erased.
    async fn mend(&mut self) -> Result<(), StoreError<F::Error>> {
        while let Some(page) = self.half_erased()? {
            self.erase(page).await?;
        }
        Ok(())
    }

    /// A page that is not in use and not blank, or that wrongly claims to be in use.
    fn half_erased(&mut self) -> Result<Option<u32>, StoreError<F::Error>> {
        for page in self.pages() {
            match self.state(page)? {
                Page::Broken => return Ok(Some(page)),
                Page::Open if !self.is_blank(page, page + F::ERASE_SIZE as u32)? => {
                    return Ok(Some(page));
                }
                Page::InUse => {
                    let behind = self.behind(page)?;
                    if behind == page || self.state(behind)? != Page::InUse {
                        continue;
                    }
                    // Two claim to be in use: one is half erased. A save erases ahead of the page in use, and leaves full
                    // ones behind it; forgetting comes last to the page right behind it, when no other is left.
                    if self.behind(behind)? != page {
                        return Ok(Some(page));
                    } else if behind == self.before(page) {
                        return Ok(Some(behind));
                    }
                }
                Page::Open | Page::Full => {}
            }
        }
        Ok(None)
    }

    /// The page that the record was moved away from, if it is still to be erased.
    ///
    /// A save that finds the record on the page ahead moves it to the page in use before it erases the one ahead. Were the
    /// erasing cut short such that it still reads as full, `sequential-storage` would take the moving for unfinished, erase
    /// what was moved and look for it where it no longer is.
    fn moved_from(&mut self, bytes: &[u8]) -> Result<Option<u32>, StoreError<F::Error>> {
        let word = F::WRITE_SIZE as u32;
        for ahead in self.pages() {
            let page = self.before(ahead);
            let (start, end) = (page + word, page + F::ERASE_SIZE as u32 - word);
            if self.state(page)? == Page::InUse
                && self.state(ahead)? != Page::Open
                && self.holds(start, end, bytes, false)?
            {
                return Ok(Some(ahead));
            }
        }
        Ok(None)
    }

    /// The nearest page behind one, in the ring, that is not open; the page itself if there is no other.
    fn behind(&mut self, page: u32) -> Result<u32, StoreError<F::Error>> {
        let mut behind = self.before(page);
        while behind != page && self.state(behind)? == Page::Open {
            behind = self.before(behind);
        }
        Ok(behind)
    }

    /// Whether the newest page with anything in it ends with these bytes; `None` without such a page.
    fn newest_page(&mut self, bytes: Option<&[u8]>) -> Result<Option<bool>, StoreError<F::Error>> {
        let mut newest = self.range.start;
        for page in self.pages() {
            match self.state(page)? {
                Page::InUse => {
                    newest = page;
                    break;
                }
                Page::Open if self.state(self.before(page))? == Page::Full => {
                    newest = self.before(page);
                }
                _ => {}
            }
        }
        let word = F::WRITE_SIZE as u32;
        for _ in self.pages() {
            let (start, end) = (newest + word, newest + F::ERASE_SIZE as u32 - word);
            if !self.is_blank(start, end)? {
                return match bytes {
                    Some(bytes) => self.holds(start, end, bytes, true).map(Some),
                    None => Ok(Some(false)),
                };
            }
            newest = self.before(newest);
        }
        Ok(None)
    }

    /// Whether the bytes stand there, behind a key, from the beginning of a word on, and nothing behind them if they are to be
    /// the last.
    fn holds(
        &mut self,
        start: u32,
        end: u32,
        bytes: &[u8],
        last: bool,
    ) -> Result<bool, StoreError<F::Error>> {
        let word = F::WRITE_SIZE as u32;
        let item = 1 + bytes.len() as u32;
        let mut place = start;
        while place + item <= end {
            let behind = place + item.next_multiple_of(word);
            if self.matches(place + 1, bytes)? && (!last || self.is_blank(behind, end)?) {
                return Ok(true);
            }
            place += word;
        }
        Ok(false)
    }

    fn matches(&mut self, place: u32, bytes: &[u8]) -> Result<bool, StoreError<F::Error>> {
        let mut chunk = [0; CHUNK];
        let mut place = place;
        for part in bytes.chunks(CHUNK) {
            let (read, _) = chunk.split_at_mut(part.len());
            self.look(place, read)?;
            if read != part {
                return Ok(false);
            }
            place += CHUNK as u32;
        }
        Ok(true)
    }

    fn is_blank(&mut self, start: u32, end: u32) -> Result<bool, StoreError<F::Error>> {
        let mut byte = [0];
        for place in start..end {
            self.look(place, &mut byte)?;
            if byte != [0xFF] {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn state(&mut self, page: u32) -> Result<Page, StoreError<F::Error>> {
        let start = self.is_marked(page)?;
        let end = self.is_marked(page + F::ERASE_SIZE as u32 - 1)?;
        Ok(match (start, end) {
            (false, false) => Page::Open,
            (true, false) => Page::InUse,
            (true, true) => Page::Full,
            (false, true) => Page::Broken,
        })
    }

    fn is_marked(&mut self, place: u32) -> Result<bool, StoreError<F::Error>> {
        let mut byte = [0];
        self.look(place, &mut byte)?;
        Ok(u8::from_le_bytes(byte).count_zeros() >= MARKED_BITS)
    }

    fn look(&mut self, place: u32, bytes: &mut [u8]) -> Result<(), StoreError<F::Error>> {
        self.memory().look(place, bytes).map_err(StoreError::Flash)
    }

    async fn erase(&mut self, page: u32) -> Result<(), StoreError<F::Error>> {
        self.memory()
            .erase(page, page + F::ERASE_SIZE as u32)
            .await
            .map_err(StoreError::Flash)
    }

    /// Where each page begins.
    fn pages(&self) -> impl Iterator<Item = u32> + use<F> {
        self.range.clone().step_by(F::ERASE_SIZE)
    }

    /// The page before one, in the ring.
    fn before(&self, page: u32) -> u32 {
        let after = if page > self.range.start {
            page
        } else {
            self.range.end
        };
        after - F::ERASE_SIZE as u32
    }
}

/// Flash that overwrites a single word that it cannot program with zeros, so that it is not tried again. Only a record's
/// header is written as a single word that decides where the next try begins.
struct Spoiling<F>(F);

impl<F: Memory> ErrorType for Spoiling<F> {
    type Error = F::Error;
}

impl<F: Memory> ReadNorFlash for Spoiling<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        self.0.read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl<F: Memory> NorFlash for Spoiling<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        self.0.erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), F::Error> {
        let result = self.0.write(offset, bytes).await;
        if let Err(error) = &result
            && F::is_unfinished(error)
            && bytes.len() == F::WRITE_SIZE
            && let Some((zeros, _)) = [0; WORD_MAX].split_at_checked(F::WRITE_SIZE)
        {
            self.0.write(offset, zeros).await?;
        }
        result
    }
}

/// Lets a record be written straight into the storage crate's buffer, and remembers its checksum.
struct Encoder<E> {
    encode: E,
    checksum: Cell<u32>,
}

impl<'a, E: Fn(&mut [u8]) -> Option<usize>> Value<'a> for Encoder<E> {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        let length = (self.encode)(buffer).ok_or(SerializationError::BufferTooSmall)?;
        let written = buffer
            .get(..length)
            .ok_or(SerializationError::BufferTooSmall)?;
        self.checksum.set(CHECKSUM.checksum(written));
        Ok(length)
    }

    fn deserialize_from(_: &'a [u8]) -> Result<(Self, usize), SerializationError> {
        // Records are read as bytes.
        Err(SerializationError::InvalidFormat)
    }
}
