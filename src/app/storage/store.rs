//! The record in flash: which pages, how a save replaces it at once or not at all, and what is found after a power cut or
//! damage.
//!
//! A page holds one record: its number, the record, and in the last word of the page length and checksum of both. The whole
//! page with the highest number counts. A save erases the page behind that one, in the ring, and writes the next number
//! there; nothing else is touched, so that the old record stays until the new one is whole, and wear is level. What a power
//! cut leaves of an erasing or of a record is not whole, whatever it reads as, and is erased before it is written on.
//!
//! Why not a general store of keys and values: there is one key. `sequential-storage` took several times the flash, needed a
//! record's length of RAM, and took an erasing that was cut short for the page in use, or for a full one.

use crc::{CRC_32_ISCSI, Crc, NoTable};

/// Bit by bit: a table for whole bytes would be as large as the rest of this.
pub(super) const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// What can be erased, bytes.
pub const PAGE: usize = 2048;
/// What can be programmed, once after it was erased, bytes.
pub const WORD: usize = 8;
/// Number of pages: the one of the last record, the one that a save erases, and one more that may be worn out. Each endures 10,000
/// erasures (M) and a save erases one in turn: 30,000 saves, each of them a user's command. More pages would take flash that the
/// largest image needs.
pub const PAGES: usize = 3;
/// Longest record, bytes: a page without its number, length and checksum.
pub const RECORD_MAX: usize = PAGE - WORD - 4;

/// The pages of flash that hold records: [`PAGES`] of them, one behind the other.
///
/// Not for multithreaded executors: the futures need not be `Send`.
#[expect(async_fn_in_trait)]
pub trait Memory: Sized {
    /// Why the flash was not written.
    type Error;

    /// Looks at the pages as they are now.
    fn read<R>(&mut self, look: impl FnOnce(&[u8]) -> R) -> R;

    /// Does something with nothing else running that flash must not be written under.
    ///
    /// # Errors
    /// Flash cannot be written now, or what was done failed.
    fn undisturbed(
        &mut self,
        operation: impl FnOnce(&mut Self) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;

    /// Erases a page; [`undisturbed`](Self::undisturbed) only.
    ///
    /// # Errors
    /// The flash refused or failed.
    fn erase(&mut self, page: usize) -> Result<(), Self::Error>;

    /// Programs the word at an offset from the start of the first page; [`undisturbed`](Self::undisturbed) only.
    ///
    /// # Errors
    /// The flash refused or failed.
    fn program(&mut self, offset: usize, word: [u8; WORD]) -> Result<(), Self::Error>;

    /// Lets everything else run for a moment.
    async fn rest(&mut self);
}

/// Why a record was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError<E> {
    /// The flash refused or failed.
    Flash(E),
    /// Longer than [`RECORD_MAX`].
    TooLong,
    /// What was written cannot be read back, on any page: worn out.
    NotKept,
}

impl<E> From<E> for StoreError<E> {
    fn from(error: E) -> Self {
        Self::Flash(error)
    }
}

/// What is in the pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found<'p> {
    /// Nothing was ever saved, or it was forgotten.
    Nothing,
    /// Something was saved or begun to be, and no whole record is left.
    Unreadable,
    /// A whole record.
    Record {
        /// Its bytes.
        bytes: &'p [u8],
        /// Nothing newer is there; otherwise what is newer is damaged, or its save was cut short.
        newest: bool,
    },
}

/// A page with a whole record.
struct Whole<'p> {
    page: usize,
    number: u32,
    bytes: &'p [u8],
}

impl<'p> Whole<'p> {
    #[inline(never)]
    fn read(pages: &'p [u8], page: usize) -> Option<Self> {
        let (front, [a, b, c, d, checksum @ ..]) =
            page_of(pages, page).split_last_chunk::<WORD>()?;
        let content = front.get(..u32::from_le_bytes([*a, *b, *c, *d]) as usize)?;
        let (number, bytes) = content.split_first_chunk()?;
        (CHECKSUM.checksum(content) == u32::from_le_bytes(*checksum)).then_some(Self {
            page,
            number: u32::from_le_bytes(*number),
            bytes,
        })
    }

    #[inline(never)]
    fn newest(pages: &'p [u8]) -> Option<Self> {
        let mut newest: Option<Self> = None;
        for page in 0..PAGES {
            if let Some(whole) = Self::read(pages, page)
                && newest
                    .as_ref()
                    .is_none_or(|newest| newest.number <= whole.number)
            {
                newest = Some(whole);
            }
        }
        newest
    }
}

/// A page's bytes; none where there is no such page.
fn page_of(pages: &[u8], page: usize) -> &[u8] {
    let rest = pages.get(page * PAGE..).unwrap_or_default();
    rest.get(..PAGE).unwrap_or_default()
}

#[inline(never)]
fn is_blank(bytes: &[u8]) -> bool {
    bytes.iter().all(|&byte| byte == 0xFF)
}

/// Whether a page holds neither a record nor nothing: what was begun there was cut short, or is damaged.
fn is_torn(pages: &[u8], page: usize) -> bool {
    !is_blank(page_of(pages, page)) && Whole::read(pages, page).is_none()
}

/// The page behind one, in the ring.
const fn behind(page: usize) -> usize {
    if page + 1 < PAGES { page + 1 } else { 0 }
}

fn find(pages: &[u8]) -> Found<'_> {
    let Some(whole) = Whole::newest(pages) else {
        return if is_blank(pages) {
            Found::Nothing
        } else {
            Found::Unreadable
        };
    };
    // The next save would write behind it.
    let newest = !is_torn(pages, behind(whole.page));
    match (whole.bytes, newest) {
        ([], true) => Found::Nothing,
        ([], false) => Found::Unreadable,
        (bytes, newest) => Found::Record { bytes, newest },
    }
}

/// Where a record is written, a word at a time: what a record is encoded into.
pub struct Writer<'m, M: Memory> {
    memory: &'m mut M,
    /// Of the page, and behind its last word for a record.
    start: usize,
    place: usize,
    word: [u8; WORD],
    digest: crc::Digest<'static, u32, NoTable>,
    failed: Option<StoreError<M::Error>>,
}

impl<'m, M: Memory> Writer<'m, M> {
    fn new(memory: &'m mut M, page: usize) -> Self {
        static CHECKSUM: Crc<u32, NoTable> = self::CHECKSUM;
        Self {
            memory,
            start: page * PAGE,
            place: 0,
            word: [0xFF; WORD],
            digest: CHECKSUM.digest(),
            failed: None,
        }
    }

    /// Takes the next byte. Once one could not be written, the rest is ignored: [`Store::replace`] reports it.
    pub fn push(&mut self, byte: u8) {
        if self.failed.is_none() && self.place >= RECORD_MAX + 4 {
            self.failed = Some(StoreError::TooLong);
        }
        if self.failed.is_some() {
            return;
        }
        self.digest.update(&[byte]);
        self.word[self.place % WORD] = byte;
        self.place += 1;
        if self.place.is_multiple_of(WORD) {
            let word = core::mem::replace(&mut self.word, [0xFF; WORD]);
            self.program(self.place - WORD, word);
        }
    }

    fn program(&mut self, place: usize, word: [u8; WORD]) {
        if let Err(error) = self.memory.program(self.start + place, word) {
            self.failed = Some(StoreError::Flash(error));
        }
    }

    /// Writes what is left, length and checksum; whether all of it was taken.
    fn finish(mut self) -> Result<(), StoreError<M::Error>> {
        let length = self.place;
        if self.failed.is_none() && !length.is_multiple_of(WORD) {
            self.program(length - length % WORD, self.word);
        }
        if self.failed.is_none() {
            let [a, b, c, d] = (length as u32).to_le_bytes();
            let [e, f, g, h] = self.digest.clone().finalize().to_le_bytes();
            self.program(PAGE - WORD, [a, b, c, d, e, f, g, h]);
        }
        match self.failed {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

/// The pages. All futures must be run to their end.
#[derive(Debug)]
pub struct Store<M: Memory> {
    memory: M,
}

impl<M: Memory> Store<M> {
    /// Takes the flash.
    pub const fn new(memory: M) -> Self {
        Self { memory }
    }

    /// The flash.
    pub fn memory(&mut self) -> &mut M {
        &mut self.memory
    }

    /// Finds the last record saved that is whole; writes nothing.
    pub fn load<R>(&mut self, take: impl FnOnce(Found<'_>) -> R) -> R {
        self.memory.read(|pages| take(find(pages)))
    }

    /// Puts the record that `encode` writes in the place of the last one. Without `encode`, forgets that and what came before
    /// it. After a power cut at any moment the old record is there, whole, or the new one, or nothing if it was to be
    /// forgotten; beside a page that is worn out, forgetting that is cut short may leave damage instead of nothing.
    ///
    /// # Errors
    /// Nothing was saved: the flash failed, or the record does not fit or cannot be read back. Not all was forgotten: the
    /// flash failed.
    pub async fn replace(
        &mut self,
        mut encode: Option<impl FnMut(&mut Writer<'_, M>)>,
    ) -> Result<(), StoreError<M::Error>> {
        let forget = encode.is_none();
        let (mut page, number) = self.next();
        let mut result = Err(StoreError::NotKept);
        // The page of the old record is not among those that are tried.
        for _ in 1..PAGES {
            // A page that fails may be worn out as well as one that does not keep what it took.
            let done = self.put(page, number, forget, &mut encode).await;
            let kept = done.is_ok() && self.keeps(page, number);
            if kept || done.is_err() {
                result = done;
            }
            if kept {
                break;
            }
            page = behind(page);
        }
        if !forget {
            return result;
        }
        // The empty record hides the others while they are erased. Where it cannot be kept, everything goes.
        let hidden = result.is_ok();
        for other in 0..PAGES {
            let blank = |pages: &[u8]| is_blank(page_of(pages, other));
            if !(hidden && other == page || self.memory.read(blank)) {
                self.erase(other)?;
                self.memory.rest().await;
            }
        }
        Ok(())
    }

    /// Writes a record, or an empty one, to a page, with a rest behind every operation.
    async fn put(
        &mut self,
        page: usize,
        number: u32,
        forget: bool,
        encode: &mut Option<impl FnMut(&mut Writer<'_, M>)>,
    ) -> Result<(), StoreError<M::Error>> {
        self.clear(behind(page), forget)?;
        self.memory.rest().await;
        self.erase(page)?;
        self.memory.rest().await;
        let written = self.write(page, number, encode);
        self.memory.rest().await;
        written
    }

    /// Where the next record goes, and its number.
    fn next(&mut self) -> (usize, u32) {
        self.memory.read(|pages| match Whole::newest(pages) {
            Some(whole) => (behind(whole.page), whole.number.wrapping_add(1)),
            None => (0, 0),
        })
    }

    /// Whether what was written can be read back.
    fn keeps(&mut self, page: usize, number: u32) -> bool {
        self.memory.read(|pages| {
            Whole::newest(pages).is_some_and(|whole| (whole.page, whole.number) == (page, number))
        })
    }

    /// Clears the page behind that of a new record of what is torn there, which would be taken for a newer one; before
    /// forgetting of everything, whose erasing later would look the same when cut short.
    fn clear(&mut self, page: usize, all: bool) -> Result<(), StoreError<M::Error>> {
        if all || self.memory.read(|pages| is_torn(pages, page)) {
            self.erase(page)
        } else {
            Ok(())
        }
    }

    #[inline(never)]
    fn erase(&mut self, page: usize) -> Result<(), StoreError<M::Error>> {
        self.memory.undisturbed(|memory| memory.erase(page))?;
        Ok(())
    }

    fn write(
        &mut self,
        page: usize,
        number: u32,
        encode: &mut Option<impl FnMut(&mut Writer<'_, M>)>,
    ) -> Result<(), StoreError<M::Error>> {
        let mut result = Ok(());
        self.memory.undisturbed(|memory| {
            let mut writer = Writer::new(memory, page);
            for byte in number.to_le_bytes() {
                writer.push(byte);
            }
            if let Some(encode) = encode {
                encode(&mut writer);
            }
            result = writer.finish();
            Ok(())
        })?;
        if matches!(result, Err(StoreError::TooLong)) {
            // Not begun, for a later reader.
            self.erase(page)?;
        }
        result
    }
}
