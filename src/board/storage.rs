//! The record in the last 16 KiB of flash, eight pages: the flash controller under a [`Store`].
//!
//! The chip has one bank: while it erases (25 ms at most) or programs, the core stalls on every fetch from flash, and
//! the control interrupt with it. So nothing is written unless the bridge is off, and the control interrupt is masked
//! for the duration of one operation; between two operations everything runs, long enough for all to report to the
//! watchdog.

use core::ops::Range;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering, compiler_fence};

use embassy_stm32::flash::{Blocking, Error as FlashError, Flash, MAX_ERASE_SIZE, WRITE_SIZE};
use embassy_stm32::pac::FLASH;
use embassy_stm32::{Peri, peripherals};
use embassy_time::{Duration, Timer};
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use palpate::app::store::{Found, Memory, Store, StoreError};
use static_cell::StaticCell;

use super::{bridge, control};

/// Where the records lie, as offsets from the start of flash; `memory.x` keeps the linker out of it.
const RANGE: Range<u32> = 0x1_C000..0x2_0000;

unsafe extern "C" {
    /// Bounds of the region in `memory.x`; their addresses are the values.
    static _storage_start: u8;
    static _storage_end: u8;
}

/// Pause after an operation: two samples.
const BREATH: Duration = Duration::from_millis(2);

/// Longest record with its key, rounded up to the flash word. A page holds 2,016 bytes.
const BUFFER_BYTES: usize = 1400;

/// Why the flash was not read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The bridge is on: the motor must be off while flash is written.
    BridgeOn,
    /// The flash controller refused or failed.
    Flash(FlashError),
}

/// Name of an error in the log.
pub fn name(error: StoreError<Error>) -> &'static str {
    match error {
        StoreError::Flash(Error::BridgeOn) => "bridge-on",
        StoreError::Flash(Error::Flash(FlashError::Prog)) => "not-erased",
        StoreError::Flash(Error::Flash(FlashError::Protected)) => "write-protected",
        StoreError::Flash(Error::Flash(_)) => "flash",
        StoreError::Layout => "layout",
        StoreError::NotKept => "worn-out",
    }
}

impl NorFlashError for Error {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Words with two wrong bits met since boot: left by a power cut in the middle of a write, or worn out.
static BAD_WORDS: AtomicU32 = AtomicU32::new(0);
/// A record is being read: a bad word is expected and harmless, since its checksum fails.
static READING: AtomicBool = AtomicBool::new(false);

/// Words with two wrong bits met since boot.
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

/// The region as the storage crate wants it.
struct Region {
    flash: Flash<'static, Blocking>,
}

impl Region {
    /// Runs one flash operation with the control interrupt out of the way, provided that the bridge is off.
    async fn undisturbed(
        &mut self,
        operation: impl FnOnce(&mut Flash<'static, Blocking>) -> Result<(), FlashError>,
    ) -> Result<(), Error> {
        let result = {
            // Masked first: the interrupt cannot switch the bridge on behind the check.
            let _pause = control::pause();
            if bridge::is_off() {
                operation(&mut self.flash).map_err(Error::Flash)
            } else {
                Err(Error::BridgeOn)
            }
        };
        Timer::after(BREATH).await;
        result
    }
}

impl ErrorType for Region {
    type Error = Error;
}

impl ReadNorFlash for Region {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.look(offset, bytes)
    }

    fn capacity(&self) -> usize {
        RANGE.end as usize
    }
}

impl NorFlash for Region {
    const WRITE_SIZE: usize = WRITE_SIZE;
    const ERASE_SIZE: usize = MAX_ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        for page in (from..to).step_by(Self::ERASE_SIZE) {
            self.undisturbed(|flash| flash.blocking_erase(page, page + Self::ERASE_SIZE as u32))
                .await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.undisturbed(|flash| flash.blocking_write(offset, bytes))
            .await
    }
}

impl Memory for Region {
    fn look(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        READING.store(true, Ordering::Relaxed);
        let result = self.flash.blocking_read(offset, bytes);
        // The interrupt of a bad word comes a little after its load: let it come before the flag goes.
        compiler_fence(Ordering::SeqCst);
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        READING.store(false, Ordering::Relaxed);
        result.map_err(Error::Flash)
    }

    fn is_unfinished(error: &Error) -> bool {
        *error == Error::Flash(FlashError::Prog)
    }
}

/// The record's place.
pub struct Storage {
    store: Store<Region>,
    buffer: &'static mut [u8; BUFFER_BYTES],
}

impl Storage {
    /// Takes the flash controller.
    pub fn new(flash: Peri<'static, peripherals::FLASH>) -> Self {
        let linked = (&raw const _storage_start) as u32..(&raw const _storage_end) as u32;
        assert!(linked == RANGE, "memory.x and storage.rs disagree");
        // Outside the struct: this moves through the stack on its way into its task.
        static BUFFER: StaticCell<[u8; BUFFER_BYTES]> = StaticCell::new();
        let flash = Flash::new_blocking(flash);
        Self {
            store: Store::new(Region { flash }, RANGE).expect("whole pages"),
            buffer: BUFFER.init([0; BUFFER_BYTES]),
        }
    }

    /// See [`Store::load`].
    pub async fn load(&mut self) -> Result<Found<'_>, StoreError<Error>> {
        self.store.load(self.buffer).await
    }

    /// See [`Store::save`].
    pub async fn save(
        &mut self,
        encode: impl Fn(&mut [u8]) -> Option<usize>,
    ) -> Result<(), StoreError<Error>> {
        self.store.save(self.buffer, encode).await
    }

    /// See [`Store::forget`].
    pub async fn forget(&mut self) -> Result<(), StoreError<Error>> {
        self.store.forget(self.buffer).await
    }
}
