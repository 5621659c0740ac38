//! Faults on command, for the tests of fault handling alone: `inject panic|hardfault|stack-overflow|starve-task|hang`.
//! Compiled only with the feature `fault-injection`, which no released firmware has.

use core::hint::black_box;
use core::sync::atomic::{AtomicBool, Ordering};

static STARVED: AtomicBool = AtomicBool::new(false);

/// For the sensing task: never returns once it is to starve.
pub async fn starve() {
    if STARVED.load(Ordering::Relaxed) {
        core::future::pending().await
    }
}

/// Watches the command bytes for its own lines.
#[derive(Default)]
pub struct Injector {
    line: heapless::Vec<u8, 32>,
}

impl Injector {
    /// Takes a byte; at the end of a line that asks for a fault, there is one. True if the line was one of these.
    pub fn push(&mut self, byte: u8) -> bool {
        if !matches!(byte, b'\n' | b'\r') {
            // Longer lines are none of these.
            let _ = self.line.push(byte);
            return false;
        }
        let line = core::mem::take(&mut self.line);
        match line.as_slice() {
            b"inject panic" => panic!("injected"),
            b"inject hardfault" => bus_fault(),
            b"inject stack-overflow" => {
                black_box(descend(black_box(1)));
            }
            b"inject starve-task" => STARVED.store(true, Ordering::Relaxed),
            b"inject hang" => loop {
                cortex_m::asm::nop();
            },
            _ => return false,
        }
        true
    }
}

/// Reads where nothing answers.
fn bus_fault() {
    const NOWHERE: *const u32 = 0x6000_0000 as *const u32;
    // SAFETY: none: the fault is what is wanted.
    unsafe { NOWHERE.read_volatile() };
}

/// Calls itself until the stack leaves RAM.
#[expect(unconditional_recursion, reason = "the overflow is what is wanted")]
fn descend(depth: u32) -> u32 {
    let frame = black_box([depth; 16]);
    frame[0].wrapping_add(descend(black_box(depth.wrapping_add(1))))
}
