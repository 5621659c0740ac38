//! Flash as the chip has it: double words that can be programmed once after an erase (or overwritten with zeros), pages,
//! and what a power cut in the middle of an operation leaves of it.

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use palpate::app::store::{Found, Memory, Store, StoreError};

pub const WORD: usize = 8;
pub const PAGE: usize = 2048;
pub const PAGES: usize = 8;
/// Records do not begin at zero on the chip either.
pub const START: u32 = 0x1_C000;

/// Longest record with its key, rounded up to the word.
pub const BUFFER: usize = 1536;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    PowerLost,
    NotErased,
}

impl NorFlashError for Failure {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Random numbers that are the same on every machine (splitmix64).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Bits that are one with a probability of `share` / 256.
    fn bits(&mut self, share: u64) -> u64 {
        (0..64).fold(0, |bits, bit| {
            bits | u64::from(self.next() % 256 < share) << bit
        })
    }
}

/// What a power cut leaves of the operation that it hits.
#[derive(Clone, Debug)]
pub enum Cut {
    /// Nothing of it has happened.
    Before,
    /// Each bit in transition got there or not.
    During(Random),
}

/// A double word: its bits, and those of its error-correcting code. Erased is all ones, in both.
#[derive(Clone, Copy, Debug)]
struct Word {
    data: u64,
    code: u8,
}

impl Word {
    const ERASED: Self = Self {
        data: u64::MAX,
        code: u8::MAX,
    };

    fn is_erased(self) -> bool {
        self.data == u64::MAX && self.code == u8::MAX
    }
}

/// The pages. A clone is another chip with the same contents.
#[derive(Clone, Debug)]
pub struct Flash {
    words: Vec<Word>,
    pub erases: [u32; PAGES],
    /// Operations so far.
    pub operations: usize,
    /// Which of them erased a page.
    pub erasing: Vec<usize>,
    /// The power goes at this operation.
    pub cut: Option<(usize, Cut)>,
    off: bool,
}

impl Flash {
    pub fn blank() -> Self {
        Self {
            words: vec![Word::ERASED; PAGES * PAGE / WORD],
            erases: [0; PAGES],
            operations: 0,
            erasing: Vec::new(),
            cut: None,
            off: false,
        }
    }

    /// The power comes back.
    pub fn power_on(&mut self) {
        self.off = false;
        self.cut = None;
        self.operations = 0;
        self.erasing.clear();
    }

    pub fn cut_at(mut self, operation: usize, cut: Cut) -> Self {
        self.power_on();
        self.cut = Some((operation, cut));
        self
    }

    /// Flips a bit of the data; the code is not there to notice.
    pub fn flip(&mut self, bit: usize) {
        self.words[bit / 64].data ^= 1 << (bit % 64);
    }

    /// Programs bits into a double word that still reads as erased: its code is not.
    pub fn touch(&mut self, word: usize) {
        self.words[word].code = 0xFE;
    }

    pub fn is_blank(&self, word: usize) -> bool {
        self.words[word].is_erased()
    }

    /// One operation: true if it is to be carried out, else what is left of it.
    fn operate(&mut self) -> Result<(), Option<Random>> {
        if self.off {
            return Err(None);
        }
        self.operations += 1;
        let Some((_, cut)) = self
            .cut
            .take_if(|(operation, _)| *operation < self.operations)
        else {
            return Ok(());
        };
        self.off = true;
        Err(match cut {
            Cut::Before => None,
            Cut::During(random) => Some(random),
        })
    }

    fn program(&mut self, index: usize, data: u64) -> Result<(), Failure> {
        let word = self.words[index];
        if !self.off && !word.is_erased() && data != 0 {
            return Err(Failure::NotErased);
        }
        // Any code will do, as long as it is not that of an erased word.
        let new = Word {
            data,
            code: (data.wrapping_mul(0x0101_0101_0101_0101) >> 57) as u8,
        };
        match self.operate() {
            Ok(()) => {
                self.words[index] = new;
                return Ok(());
            }
            Err(Some(mut random)) => {
                let share = random.next() % 257;
                let (data, code) = (random.bits(share), random.bits(share) as u8);
                self.words[index] = Word {
                    data: word.data & (new.data | !data),
                    code: word.code & (new.code | !code),
                };
            }
            Err(None) => {}
        }
        Err(Failure::PowerLost)
    }
}

impl ErrorType for Flash {
    type Error = Failure;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        self.look(offset, bytes)
    }

    fn capacity(&self) -> usize {
        START as usize + PAGES * PAGE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failure> {
        let (from, to) = ((from - START) as usize, (to - START) as usize);
        assert!(from.is_multiple_of(PAGE) && to.is_multiple_of(PAGE) && from < to);
        for page in from / PAGE..to / PAGE {
            let words = page * PAGE / WORD..(page + 1) * PAGE / WORD;
            self.erasing.push(self.operations);
            match self.operate() {
                Ok(()) => {
                    self.erases[page] += 1;
                    self.words[words].fill(Word::ERASED);
                }
                Err(left) => {
                    if let Some(mut random) = left {
                        let share = random.next() % 257;
                        for word in &mut self.words[words] {
                            word.data |= random.bits(share);
                            word.code |= random.bits(share) as u8;
                        }
                    }
                    return Err(Failure::PowerLost);
                }
            }
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        let first = (offset - START) as usize;
        assert!(first.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        for (index, word) in (first / WORD..).zip(bytes.chunks(WORD)) {
            self.program(index, u64::from_le_bytes(word.try_into().unwrap()))?;
        }
        Ok(())
    }
}

impl Memory for Flash {
    fn look(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        if self.off {
            return Err(Failure::PowerLost);
        }
        let first = (offset - START) as usize;
        for (place, byte) in (first..).zip(bytes) {
            *byte = self.words[place / WORD].data.to_le_bytes()[place % WORD];
        }
        Ok(())
    }

    fn is_unfinished(error: &Failure) -> bool {
        *error == Failure::NotErased
    }
}

/// What is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kept {
    Nothing,
    Unreadable,
    Record(Vec<u8>, bool),
}

/// A store and the buffer that it needs.
pub struct Bench {
    pub store: Store<Flash>,
    buffer: [u8; BUFFER],
}

impl Bench {
    pub fn new(flash: Flash) -> Self {
        let store = Store::new(flash, START..START + (PAGES * PAGE) as u32);
        Self {
            store: store.expect("whole pages"),
            buffer: [0; BUFFER],
        }
    }

    pub fn flash(&mut self) -> Flash {
        self.store.memory().clone()
    }

    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreError<Failure>> {
        block_on(self.store.save(&mut self.buffer, |room| {
            room.get_mut(..record.len())?.copy_from_slice(record);
            Some(record.len())
        }))
    }

    pub fn load(&mut self) -> Result<Kept, StoreError<Failure>> {
        Ok(match block_on(self.store.load(&mut self.buffer))? {
            Found::Nothing => Kept::Nothing,
            Found::Unreadable => Kept::Unreadable,
            Found::Record { bytes, newest } => Kept::Record(bytes.to_vec(), newest),
        })
    }

    pub fn forget(&mut self) -> Result<(), StoreError<Failure>> {
        block_on(self.store.forget(&mut self.buffer))
    }
}
