//! Log records out and command bytes in over RTT (SEGGER's real-time transfer: ring buffers in RAM that the debug
//! probe reads and writes while the core runs).
//!
//! Why not a ready-made logger: `defmt-rtt` overwrites records that a slow reader has not fetched or, with
//! `drop-on-contention`, drops them uncounted, and has no channel towards the chip; `rtt-target` has one, but obeys the
//! mode flag that the host writes, so `probe-rs` attaching in blocking mode can stop the writer inside a critical
//! section. Here a record is staged behind the public write cursor and published whole or not at all, the mode flag
//! is never read, no interrupt is masked, and what did not fit is counted.
//!
//! Only thread mode may log: it is one context, so no lock is needed. A record from an interrupt is counted as dropped.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering, compiler_fence};

use cortex_m::peripheral::SCB;
use cortex_m::peripheral::scb::VectActive;

/// Room for records, some 15 bytes each: a grasp makes some dozens a second at most; `help`, the longest answer, is some 900 bytes (I).
/// probe-rs looks every 100 milliseconds, `monitor` every few.
const UP_BYTES: usize = 896;
/// Room for command bytes; the command task empties it every few milliseconds.
const DOWN_BYTES: usize = 64;

/// A word that the host reads or writes through the debug port: every access is volatile, so that the compiler, which
/// sees no other writer in the program, does not take it for a constant.
#[repr(transparent)]
struct Shared(UnsafeCell<u32>);

impl Shared {
    const fn new(value: u32) -> Self {
        Self(UnsafeCell::new(value))
    }

    fn get(&self) -> usize {
        // SAFETY: aligned, always valid, and any word is a valid value.
        let value = unsafe { self.0.get().read_volatile() };
        compiler_fence(Ordering::Acquire);
        value as usize
    }

    fn set(&self, value: usize) {
        compiler_fence(Ordering::Release);
        // SAFETY: as above; one context of the program writes (thread mode).
        unsafe { self.0.get().write_volatile(value as u32) };
    }
}

/// One direction, as the host expects it in memory.
#[repr(C)]
struct Channel {
    name: *const u8,
    buffer: *mut u8,
    size: u32,
    write: Shared,
    read: Shared,
    /// Blocking or not: written by the host, ignored here.
    flags: Shared,
}

/// What the host looks for: by symbol name or by scanning RAM for `id`.
#[repr(C)]
struct ControlBlock {
    id: [u8; 16],
    up_channels: u32,
    down_channels: u32,
    up: Channel,
    down: Channel,
}

/// Bytes shared with the host through the debug port.
struct Bytes<const N: usize>(UnsafeCell<[u8; N]>);

// SAFETY: the up buffer is written by thread mode alone, in the part that the host does not read; the down buffer is
// only read here.
unsafe impl<const N: usize> Sync for Bytes<N> {}
// SAFETY: the pointers never change; of each channel's cursors the host writes one and thread mode the other.
unsafe impl Sync for ControlBlock {}

static UP: Bytes<UP_BYTES> = Bytes(UnsafeCell::new([0; UP_BYTES]));
static DOWN: Bytes<DOWN_BYTES> = Bytes(UnsafeCell::new([0; DOWN_BYTES]));

/// Non-blocking, skip: what this writer does anyway.
const MODE_SKIP: u32 = 0;

#[unsafe(export_name = "_SEGGER_RTT")]
static CONTROL_BLOCK: ControlBlock = ControlBlock {
    id: *b"SEGGER RTT\0\0\0\0\0\0",
    up_channels: 1,
    down_channels: 1,
    up: Channel {
        name: c"defmt".as_ptr().cast(),
        buffer: UP.0.get().cast(),
        size: UP_BYTES as u32,
        write: Shared::new(0),
        read: Shared::new(0),
        flags: Shared::new(MODE_SKIP),
    },
    down: Channel {
        name: c"commands".as_ptr().cast(),
        buffer: DOWN.0.get().cast(),
        size: DOWN_BYTES as u32,
        write: Shared::new(0),
        read: Shared::new(0),
        flags: Shared::new(MODE_SKIP),
    },
};

/// Records that found no room (or came from an interrupt) since boot; wraps.
static DROPPED: AtomicU32 = AtomicU32::new(0);

/// Records lost since boot; wraps.
pub fn dropped() -> u32 {
    DROPPED.load(Ordering::Relaxed)
}

/// Sets the count back to `dropped`: a record that was dropped since does not count. Returns whether there was one.
pub fn take_back(dropped: u32) -> bool {
    let now = self::dropped();
    DROPPED.store(dropped, Ordering::Relaxed);
    now != dropped
}

/// The serial port as a second reader of the up buffer (feature `serial-log`). It is the one that records must not overtake: a
/// probe beside it that reads slower loses some.
#[cfg(feature = "serial-log")]
pub mod serial {
    use super::{CONTROL_BLOCK, Ordering, UP, UP_BYTES};
    use core::sync::atomic::AtomicUsize;

    /// How far it has read.
    static READ: AtomicUsize = AtomicUsize::new(0);

    /// How far it has read.
    pub(super) fn read() -> usize {
        READ.load(Ordering::Relaxed)
    }

    /// The next bytes, at most `most`; they stay until they are [`sent`].
    pub fn chunk(most: usize) -> &'static [u8] {
        let (from, write) = (read(), CONTROL_BLOCK.up.write.get() % UP_BYTES);
        let end = if write < from { UP_BYTES } else { write };
        let length = (end - from).min(most);
        // SAFETY: from `from` to `end` lie published records inside the buffer, which the writer leaves alone until the
        // cursor has passed them; the host only reads here.
        unsafe { core::slice::from_raw_parts(UP.0.get().cast::<u8>().add(from), length) }
    }

    /// That many bytes of the chunk are sent.
    pub fn sent(count: usize) {
        READ.store((read() + count) % UP_BYTES, Ordering::Relaxed);
    }
}

/// Reads one command byte sent by the host, if there is one.
pub fn read_byte() -> Option<u8> {
    let channel = &CONTROL_BLOCK.down;
    let read = channel.read.get();
    let write = channel.write.get();
    // The host writes the other cursor: both are checked, whatever it wrote.
    if read >= DOWN_BYTES || write >= DOWN_BYTES {
        channel.read.set(0);
        return None;
    }
    if read == write {
        return None;
    }
    // SAFETY: `read` is inside the buffer; volatile because the debug port changes it behind the compiler's back.
    let byte = unsafe { DOWN.0.get().cast::<u8>().add(read).read_volatile() };
    channel.read.set((read + 1) % DOWN_BYTES);
    Some(byte)
}

/// A record being staged.
struct Stage {
    encoder: defmt::Encoder,
    room: Room,
}

/// Where the record goes.
struct Room {
    /// Next byte to write, beyond the public cursor while a record is under way.
    cursor: usize,
    /// How far the host had read when the record began. Looked up once: this is called for every byte.
    read: usize,
    /// The record no longer fits: swallow the rest.
    overflow: bool,
}

struct Staging(UnsafeCell<Stage>);

// SAFETY: touched from thread mode alone (`in_thread_mode`), which does not preempt itself.
unsafe impl Sync for Staging {}

static STAGING: Staging = Staging(UnsafeCell::new(Stage {
    encoder: defmt::Encoder::new(),
    room: Room {
        cursor: 0,
        read: 0,
        overflow: false,
    },
}));

/// How far the reader has got that decides what room there is.
fn reader() -> usize {
    #[cfg(feature = "serial-log")]
    let read = serial::read();
    #[cfg(not(feature = "serial-log"))]
    let read = CONTROL_BLOCK.up.read.get() % UP_BYTES;
    read
}

fn in_thread_mode() -> bool {
    SCB::vect_active() == VectActive::ThreadMode
}

impl Room {
    /// Copies encoded bytes behind the public cursor as long as there is room.
    fn stage(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let after = self.cursor + 1;
            let next = if after < UP_BYTES { after } else { 0 };
            if next == self.read {
                self.overflow = true;
            }
            if self.overflow {
                return;
            }
            // SAFETY: the cursor is inside the buffer, in the part that belongs to the writer.
            unsafe {
                UP.0.get()
                    .cast::<u8>()
                    .add(self.cursor)
                    .write_volatile(byte)
            };
            self.cursor = next;
        }
    }
}

#[defmt::global_logger]
struct Logger;

// SAFETY: defmt calls acquire, write and release in that order; all of it happens in thread mode, which is one context.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        if !in_thread_mode() {
            DROPPED.fetch_add(1, Ordering::Relaxed);
            return;
        }
        // SAFETY: thread mode alone comes here.
        let staging = unsafe { &mut *STAGING.0.get() };
        staging.room = Room {
            cursor: CONTROL_BLOCK.up.write.get() % UP_BYTES,
            read: reader(),
            overflow: false,
        };
        let room = &mut staging.room;
        staging.encoder.start_frame(|bytes| room.stage(bytes));
    }

    unsafe fn flush() {
        // The firmware never waits for a reader.
    }

    unsafe fn release() {
        if !in_thread_mode() {
            return;
        }
        // SAFETY: thread mode alone comes here.
        let staging = unsafe { &mut *STAGING.0.get() };
        let room = &mut staging.room;
        staging.encoder.end_frame(|bytes| room.stage(bytes));
        if staging.room.overflow {
            DROPPED.fetch_add(1, Ordering::Relaxed);
        } else {
            CONTROL_BLOCK.up.write.set(staging.room.cursor);
        }
    }

    unsafe fn write(bytes: &[u8]) {
        if !in_thread_mode() {
            return;
        }
        // SAFETY: thread mode alone comes here.
        let staging = unsafe { &mut *STAGING.0.get() };
        let room = &mut staging.room;
        staging.encoder.write(bytes, |bytes| room.stage(bytes));
    }
}
