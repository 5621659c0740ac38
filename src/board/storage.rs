//! The record in the last 16 KiB of flash, eight pages: the flash controller under a [`Store`].
//!
//! The chip has one bank: while it erases (25 ms at most) or programs (14 ms for the longest record), the core stalls on
//! every fetch from flash, and the control interrupt with it. So nothing is written unless the bridge is off, and the
//! control interrupt is masked while a page is erased or a record is written; between the two everything runs, long enough
//! for all to report to the watchdog.

use core::arch::global_asm;
use core::ops::Range;
use core::slice;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering, compiler_fence};

use embassy_stm32::pac::FLASH;
use embassy_stm32::{Peri, peripherals};
use embassy_time::Duration;
use palpate::app::store::{Memory, PAGE, PAGES, Store, StoreError, WORD};

use super::{bridge, control, pace};

/// Where flash begins for the core, and from where on it is counted in registers and in [`RANGE`].
const FLASH_START: usize = 0x0800_0000;
/// Where the records lie, as offsets from the start of flash; `memory.x` keeps the linker out of it.
const RANGE: Range<u32> = 0x1_C000..0x2_0000;

const _: () = assert!(RANGE.end - RANGE.start == (PAGES * PAGE) as u32);
// The linker compares: `memory.x` has the same bounds, or there is no image.
global_asm!(
    ".global _records_start",
    ".global _records_end",
    ".set _records_start, {start}",
    ".set _records_end, {end}",
    start = const RANGE.start,
    end = const RANGE.end,
);

/// Pause after an operation: two samples.
const BREATH: Duration = Duration::from_millis(2);

/// The two keys that unlock the flash controller (reference manual RM0440).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// Why the flash was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The bridge is on: the motor must be off while flash is written.
    BridgeOn,
    /// What was to be programmed is not erased.
    NotErased,
    /// The page is protected.
    Protected,
    /// Another error of the flash controller.
    Flash,
}

/// Name of an error in the log.
pub fn name(error: StoreError<Error>) -> &'static str {
    match error {
        StoreError::Flash(Error::BridgeOn) => "bridge-on",
        StoreError::Flash(Error::NotErased) => "not-erased",
        StoreError::Flash(Error::Protected) => "write-protected",
        StoreError::Flash(Error::Flash) => "flash",
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

/// For the non-maskable interrupt: if it came from a bad word among the records, acknowledges it and says so.
pub fn acknowledge_bad_word() -> bool {
    let status = FLASH.eccr().read();
    if !status.eccd() || !READING.load(Ordering::Relaxed) || !RANGE.contains(&status.addr_ecc()) {
        return false;
    }
    // Flags are cleared by writing the ones back.
    FLASH.eccr().write_value(status);
    BAD_WORDS.store(bad_words().wrapping_add(1), Ordering::Relaxed);
    true
}

/// The flash controller, whose pages are the store's.
pub struct Region {
    /// No one else has it.
    _flash: Peri<'static, peripherals::FLASH>,
}

impl Region {
    /// Takes the flash controller.
    pub fn new(flash: Peri<'static, peripherals::FLASH>) -> Self {
        Self { _flash: flash }
    }

    /// Waits for the end of an operation; how it ended.
    #[inline(never)]
    fn wait(&mut self) -> Result<(), Error> {
        let status = loop {
            let status = FLASH.sr().read();
            if !status.bsy() {
                break status;
            }
        };
        // Flags are cleared by writing the ones back.
        FLASH.sr().write_value(status);
        if status.progerr() {
            Err(Error::NotErased)
        } else if status.wrperr() {
            Err(Error::Protected)
        } else if status.pgaerr() || status.sizerr() || status.pgserr() {
            Err(Error::Flash)
        } else {
            Ok(())
        }
    }

    /// Unlocks the controller, and waits for it.
    #[inline(never)]
    fn open(&mut self) -> Result<(), Error> {
        for key in KEYS {
            FLASH.keyr().write_value(key);
        }
        // The data cache would go on showing what was there before.
        FLASH.acr().modify(|w| w.set_dcen(false));
        self.wait()
    }

    /// Locks it again.
    #[inline(never)]
    fn close(&mut self) {
        FLASH.acr().modify(|w| w.set_dcrst(true));
        FLASH.acr().modify(|w| w.set_dcrst(false));
        FLASH.acr().modify(|w| w.set_dcen(true));
        FLASH.cr().modify(|w| w.set_lock(true));
    }
}

impl Memory for Region {
    type Error = Error;

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
        let result = self.open().and_then(|()| operation(self));
        self.close();
        result
    }

    fn erase(&mut self, page: usize) -> Result<(), Error> {
        let page = RANGE.start as usize / PAGE + page;
        FLASH.cr().modify(|w| {
            w.set_per(true);
            w.set_pnb(page as u8);
        });
        FLASH.cr().modify(|w| w.set_strt(true));
        let result = self.wait();
        FLASH.cr().modify(|w| w.set_per(false));
        result
    }

    fn program(&mut self, offset: usize, word: [u8; WORD]) -> Result<(), Error> {
        // Beyond the records there is nothing, but what is written must not depend on that.
        if offset >= PAGES * PAGE {
            return Err(Error::Flash);
        }
        let [a, b, c, d, e, f, g, h] = word;
        let halves = [[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes);
        let place = (FLASH_START + RANGE.start as usize + offset) as *mut u32;
        FLASH.cr().modify(|w| w.set_pg(true));
        // SAFETY: flash that holds nothing else; the controller answers a wrong address or state with an error.
        unsafe {
            place.write_volatile(halves[0]);
            place.add(1).write_volatile(halves[1]);
        }
        let result = self.wait();
        FLASH.cr().modify(|w| w.set_pg(false));
        result
    }

    fn rest(&mut self) -> impl Future<Output = ()> {
        pace::after(BREATH)
    }
}

/// The record's place.
pub type Storage = Store<Region>;
