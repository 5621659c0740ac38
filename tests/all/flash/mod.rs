//! Flash as the chip has it: double words that can be programmed once after an erase (or overwritten with zeros), pages,
//! and the state after a power cut in the middle of an operation.

use embassy_futures::block_on;
use palpate::app::storage::store::{Found, Memory, PAGE, PAGES, Store, StoreError, WORD, Writer};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    PowerLost,
    NotErased,
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
    /// A page that is worn out: it takes nothing but zeros.
    pub stuck: Option<usize>,
    /// The same where the controller says so.
    pub refused: Option<usize>,
    off: bool,
    undisturbed: bool,
}

impl Flash {
    pub fn blank() -> Self {
        Self {
            words: vec![Word::ERASED; PAGES * PAGE / WORD],
            erases: [0; PAGES],
            operations: 0,
            erasing: Vec::new(),
            cut: None,
            stuck: None,
            refused: None,
            off: false,
            undisturbed: false,
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
}

impl Memory for Flash {
    type Error = Failure;

    fn read<R>(&mut self, look: impl FnOnce(&[u8]) -> R) -> R {
        let bytes = self.words.iter().flat_map(|word| word.data.to_le_bytes());
        look(&bytes.collect::<Vec<u8>>())
    }

    fn undisturbed(
        &mut self,
        operation: impl FnOnce(&mut Self) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        assert!(!self.undisturbed);
        self.undisturbed = true;
        let result = operation(self);
        self.undisturbed = false;
        result
    }

    fn erase(&mut self, page: usize) -> Result<(), Failure> {
        assert!(self.undisturbed && page < PAGES);
        let words = page * PAGE / WORD..(page + 1) * PAGE / WORD;
        self.erasing.push(self.operations);
        match self.operate() {
            Ok(()) => {
                self.erases[page] += 1;
                self.words[words].fill(Word::ERASED);
                Ok(())
            }
            Err(left) => {
                if let Some(mut random) = left {
                    let share = random.next() % 257;
                    for word in &mut self.words[words] {
                        word.data |= random.bits(share);
                        word.code |= random.bits(share) as u8;
                    }
                }
                Err(Failure::PowerLost)
            }
        }
    }

    fn program(&mut self, offset: usize, word: [u8; WORD]) -> Result<(), Failure> {
        assert!(self.undisturbed && offset.is_multiple_of(WORD));
        let index = offset / WORD;
        let data = match self.stuck {
            Some(page) if offset / PAGE == page => 0,
            _ => u64::from_le_bytes(word),
        };
        let word = self.words[index];
        let is_refused = self.refused == Some(offset / PAGE);
        if !self.off && (is_refused || !word.is_erased() && data != 0) {
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

    async fn rest(&mut self) {
        assert!(!self.undisturbed);
    }
}

/// What is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StoredRecord {
    Nothing,
    Unreadable,
    Record(Vec<u8>, bool),
}

/// A store at the bench.
pub struct Bench(Store<Flash>);

impl Bench {
    pub fn new(flash: Flash) -> Self {
        Self(Store::new(flash))
    }

    pub fn flash(&mut self) -> Flash {
        self.0.memory().clone()
    }

    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreError<Failure>> {
        block_on(self.0.replace(Some(|writer: &mut Writer<'_, Flash>| {
            record.iter().for_each(|&byte| writer.push(byte));
        })))
    }

    pub fn load(&mut self) -> StoredRecord {
        self.0.load(|found| match found {
            Found::Nothing => StoredRecord::Nothing,
            Found::Unreadable => StoredRecord::Unreadable,
            Found::Record { bytes, newest } => StoredRecord::Record(bytes.to_vec(), newest),
        })
    }

    pub fn forget(&mut self) -> Result<(), StoreError<Failure>> {
        block_on(self.0.replace(None::<fn(&mut Writer<'_, Flash>)>))
    }
}
