//! The record in the last pages of flash: the flash controller under a [`Store`].
//!
//! The chip has one bank: while it erases (25 ms at most) or programs (14 ms for the longest record), the core stalls on
//! every fetch from flash, and the control interrupt with it. So nothing is written unless the bridge is off, and the
//! control interrupt is masked while a page is erased or a record is written; between the two everything runs, long enough
//! for all to report to the watchdog.

use core::arch::global_asm;
use core::ops::Range;
use core::slice;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering, compiler_fence};

use embassy_stm32::Peri;
use embassy_stm32::flash::{Blocking, Error as FlashError, Flash};
use embassy_stm32::pac::FLASH;
use embassy_stm32::peripherals;
use embassy_time::{Duration, Timer};
use palpate::app::storage::store::{Memory, PAGE, PAGES, Store, StoreError, WORD};

use super::{bridge, control};

/// Where flash begins for the core, and from where on it is counted in registers and in [`RANGE`].
const FLASH_START: usize = 0x0800_0000;
const FLASH_BYTES: u32 = 128 * 1024;
/// Where the records lie, as offsets from the start of flash; `memory.x` keeps the linker out of it.
const RANGE: Range<u32> = FLASH_BYTES - (PAGES * PAGE) as u32..FLASH_BYTES;

// The linker compares: `memory.x` has the same bounds, or there is no image.
global_asm!(
    ".global _records_start",
    ".global _records_end",
    ".set _records_start, {start}",
    ".set _records_end, {end}",
    start = const RANGE.start,
    end = const RANGE.end,
);

/// Pause after an operation: long enough that every task reports, and the watchdog is fed, before the next one.
const PAUSE: Duration = Duration::from_millis(12);

/// Why the flash was not written.
#[derive(Clone, Copy)]
pub enum Error {
    /// The bridge is on: the motor must be off while flash is written.
    BridgeOn,
    /// What the controller said.
    Flash(FlashError),
}

/// Name of an error in the answer to `save`.
pub fn name(error: StoreError<Error>) -> &'static str {
    match error {
        StoreError::Flash(Error::BridgeOn) => "bridge-on",
        StoreError::Flash(Error::Flash(FlashError::Prog)) => "not-erased",
        StoreError::Flash(Error::Flash(FlashError::Protected)) => "write-protected",
        StoreError::Flash(Error::Flash(_)) => "flash",
        StoreError::TooLong => "too-long",
        StoreError::NotKept => "worn-out",
    }
}

/// Words with two wrong bits met since boot: left by a power cut in the middle of a write, or worn out.
static BAD_WORDS: AtomicU32 = AtomicU32::new(0);
/// A record is being read: a bad word is expected and harmless, since its checksum fails.
static READING: AtomicBool = AtomicBool::new(false);

/// Words with two wrong bits met since boot; a word counts as often as it is read.
pub fn bad_words() -> u32 {
    BAD_WORDS.load(Ordering::Relaxed)
}

/// For the non-maskable interrupt: if it came from a bad word while the records are read, acknowledges it and says so.
pub fn acknowledge_bad_word() -> bool {
    let status = FLASH.eccr().read();
    // Whatever the address: on related parts it is wrong after a reset that cut an operation short. While the records are read
    // nothing else of flash is but this code, whose own bad word would show as a wrong instruction before.
    if !status.eccd() || !READING.load(Ordering::Relaxed) {
        return false;
    }
    // Flags are cleared by writing the ones back.
    FLASH.eccr().write_value(status);
    BAD_WORDS.store(bad_words().wrapping_add(1), Ordering::Relaxed);
    true
}

/// The flash controller, whose pages are the store's.
pub struct Region(Flash<'static, Blocking>);

impl Region {
    /// Takes the flash controller.
    pub fn new(flash: Peri<'static, peripherals::FLASH>) -> Self {
        Self(Flash::new_blocking(flash))
    }
}

impl Memory for Region {
    type Error = Error;

    // By hand: the driver copies into a buffer as long as what is read, and does not expect words with two wrong bits.
    fn read<R>(&mut self, look: impl FnOnce(&[u8]) -> R) -> R {
        let start = (FLASH_START + RANGE.start as usize) as *const u8;
        // SAFETY: flash that holds nothing else, readable at any time, and not written while the slice lives, since that
        // takes this exclusively borrowed controller. A word that cannot be read is some value.
        let pages = unsafe { slice::from_raw_parts(start, PAGES * PAGE) };
        READING.store(true, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        let seen = look(pages);
        // The interrupt of a bad word comes a little after its load: let it come before the flag goes.
        compiler_fence(Ordering::SeqCst);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        READING.store(false, Ordering::Relaxed);
        seen
    }

    fn undisturbed(
        &mut self,
        operation: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        // Masked first: the interrupt cannot switch the bridge on behind the check.
        let _pause = control::pause();
        if !bridge::is_off() {
            return Err(Error::BridgeOn);
        }
        operation(self)
    }

    fn erase(&mut self, page: usize) -> Result<(), Error> {
        let from = RANGE.start + (page * PAGE) as u32;
        let erased = self.0.blocking_erase(from, from + PAGE as u32);
        erased.map_err(Error::Flash)
    }

    fn program(&mut self, offset: usize, word: [u8; WORD]) -> Result<(), Error> {
        let written = self.0.blocking_write(RANGE.start + offset as u32, &word);
        written.map_err(Error::Flash)
    }

    fn rest(&mut self) -> impl Future<Output = ()> {
        Timer::after(PAUSE)
    }
}

/// The record's place.
pub type Storage = Store<Region>;
