//! Handles failures of the program itself: the bridge goes off first, then the cause is written to RAM that survives
//! the reset, then the chip resets; the next boot reports it.
//!
//! A fault that cannot even enter its handler locks the core up: the timer's break input takes the bridge off in
//! hardware ([`super::bridge`]) and the watchdog resets.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use palpate::name_list::nth;

use super::{bridge, storage};

/// Length of the file name checked.
const FILE_BYTES: usize = 32;

/// Why the program stopped.
#[derive(Clone, Copy)]
pub enum Cause {
    /// A panic; file and line say where.
    Panic,
    /// A fault of the core.
    HardFault,
    /// A fault because a stack left RAM.
    StackOverflow,
    /// A non-maskable interrupt: two wrong bits in a word of flash outside the records, or a clock failure.
    NonMaskable,
    /// An interrupt or exception without a handler.
    Unhandled,
}

impl Cause {
    const ALL: [Self; 5] = [
        Self::Panic,
        Self::HardFault,
        Self::StackOverflow,
        Self::NonMaskable,
        Self::Unhandled,
    ];

    /// Name in the log.
    pub fn name(self) -> &'static str {
        // In the order of the enum.
        const NAMES: &str = "panic\nhard-fault\nstack-overflow\nnon-maskable\nunhandled\n";
        nth(NAMES, self as u8)
    }
}

/// What is kept across the reset.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Crash {
    /// Index into [`Cause::ALL`].
    cause: u32,
    /// Program counter, zero where unknown.
    pub pc: u32,
    /// Link register, zero where unknown.
    pub lr: u32,
    /// Configurable fault status register (for an unhandled exception its number).
    pub status: u32,
    /// Address of the access that failed, zero where unknown.
    pub address: u32,
    /// Line of a panic, zero otherwise.
    pub line: u32,
    length: u32,
    file: [u8; FILE_BYTES],
}

impl Crash {
    fn new(cause: Cause) -> Self {
        Self {
            cause: cause as u32,
            pc: 0,
            lr: 0,
            status: 0,
            address: 0,
            line: 0,
            length: 0,
            file: [0; FILE_BYTES],
        }
    }

    /// Why.
    pub fn cause(&self) -> Cause {
        Cause::ALL
            .get(self.cause as usize)
            .copied()
            .unwrap_or(Cause::Unhandled)
    }

    /// A panic's file without its folders, cut to what fits; empty otherwise.
    pub fn file(&self) -> &str {
        let file = self.file.get(..self.length as usize).unwrap_or(&[]);
        if file.iter().all(u8::is_ascii) {
            // SAFETY: ASCII is UTF-8.
            unsafe { core::str::from_utf8_unchecked(file) }
        } else {
            "?"
        }
    }

    fn checksum(&self) -> u32 {
        let mut sum = 0x7A1F_A7E5_u32;
        let mut mix = |word: u32| sum = (sum.rotate_left(5) ^ word).wrapping_mul(0x9E37_79B1);
        for word in [
            self.cause,
            self.pc,
            self.lr,
            self.status,
            self.address,
            self.line,
            self.length,
        ] {
            mix(word);
        }
        for &byte in &self.file {
            mix(byte.into());
        }
        sum
    }
}

#[derive(Clone, Copy)]
#[repr(C)]
struct Checked {
    crash: Crash,
    checksum: u32,
}

struct Retained(UnsafeCell<MaybeUninit<Checked>>);

// SAFETY: written by a handler that never returns, read once at boot.
unsafe impl Sync for Retained {}

/// Neither zeroed nor loaded at reset.
#[unsafe(link_section = ".uninit.crash")]
static RETAINED: Retained = Retained(UnsafeCell::new(MaybeUninit::uninit()));

/// What the last run left, once: the next call finds nothing.
pub fn take() -> Option<Crash> {
    // The compiler sees no one write it before: the pointer is hidden, so that it cannot conclude from that.
    let retained = core::hint::black_box(RETAINED.0.get().cast::<Checked>());
    // SAFETY: plain words, any bits are a value.
    let checked = unsafe { retained.read() };
    let valid = checked.checksum == checked.crash.checksum()
        && (checked.crash.cause as usize) < Cause::ALL.len()
        && checked.crash.length as usize <= FILE_BYTES;
    // SAFETY: within the cell. A flipped checksum fits nothing.
    unsafe { (*retained).checksum = !checked.checksum };
    valid.then_some(checked.crash)
}

/// Keeps the record and resets. The bridge is off already.
fn keep_and_reset(crash: Crash) -> ! {
    let checked = Checked {
        crash,
        checksum: crash.checksum(),
    };
    // SAFETY: this context never returns, and nothing else writes the cell.
    unsafe { core::hint::black_box(RETAINED.0.get().cast::<Checked>()).write(checked) };
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    // First of all the interrupt that could switch it on again.
    cortex_m::interrupt::disable();
    bridge::off();
    let mut crash = Crash::new(Cause::Panic);
    // The message would take the text formatting of every number that any panic of any library prints.
    if let Some(place) = info.location() {
        crash.line = place.line();
        let mut length = 0;
        for byte in place.file().bytes() {
            if byte == b'/' {
                length = 0;
            } else if let Some(room) = crash.file.get_mut(length) {
                *room = byte;
                length += 1;
            }
        }
        crash.length = length as u32;
    }
    keep_and_reset(crash)
}

/// Configurable fault status: a stack push failed (bus or memory fault on exception entry).
const STACKING_FAILED: u32 = 1 << 12 | 1 << 4;
/// Configurable fault status: the bus fault address, or the memory fault address, is valid.
const BUS_ADDRESS_VALID: u32 = 1 << 15;
const MEMORY_ADDRESS_VALID: u32 = 1 << 7;

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    bridge::off();
    // SAFETY: reads of status registers; no one else needs the peripheral any more.
    let scb = unsafe { &*SCB::PTR };
    let status = scb.cfsr.read();
    let at = core::ptr::from_ref(frame) as u32;
    // A frame outside the stacks was never written: reading it would be the next fault.
    let in_ram = (RAM_START..RAM_END - size_of::<ExceptionFrame>() as u32).contains(&at);
    let overflow = !in_ram || status & STACKING_FAILED != 0;
    let mut crash = Crash::new(if overflow {
        Cause::StackOverflow
    } else {
        Cause::HardFault
    });
    crash.status = status;
    if status & BUS_ADDRESS_VALID != 0 {
        crash.address = scb.bfar.read();
    } else if status & MEMORY_ADDRESS_VALID != 0 {
        crash.address = scb.mmfar.read();
    }
    if in_ram {
        crash.pc = frame.pc();
        crash.lr = frame.lr();
    }
    keep_and_reset(crash)
}

/// Bounds of RAM (SRAM1, SRAM2 and the alias of CCM SRAM).
const RAM_START: u32 = 0x2000_0000;
const RAM_END: u32 = 0x2000_8000;

#[exception]
unsafe fn NonMaskableInt() {
    // A power cut in the middle of a write can leave a record with two wrong bits: its reader asks and drops it.
    if storage::acknowledge_bad_word() {
        return;
    }
    bridge::off();
    keep_and_reset(Crash::new(Cause::NonMaskable))
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    bridge::off();
    let mut crash = Crash::new(Cause::Unhandled);
    crash.status = number as u16 as u32;
    keep_and_reset(crash)
}
