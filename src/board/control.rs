//! The control interrupt: 20 kHz, highest priority, registers in, registers out.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};

use palpate::drive::io::{Inputs, Outputs};

use super::bridge::{self, Bridge};
use super::{encoder, sampling};

/// What belongs to the interrupt.
struct Control {
    bridge: Bridge,
    overrun: bool,
}

struct Owned(UnsafeCell<Option<Control>>);

// SAFETY: written once before the interrupt is enabled, then touched by the interrupt alone, which cannot preempt itself.
unsafe impl Sync for Owned {}

static CONTROL: Owned = Owned(UnsafeCell::new(None));

/// Control periods since boot; wraps.
static PERIODS: AtomicU32 = AtomicU32::new(0);

/// Control periods since boot; wraps.
pub fn periods() -> u32 {
    PERIODS.load(Ordering::Relaxed)
}

/// Gives the bridge to the interrupt and starts both.
pub fn start(bridge: Bridge) {
    // SAFETY: the interrupt is not enabled yet.
    unsafe {
        *CONTROL.0.get() = Some(Control {
            bridge,
            overrun: false,
        })
    };
    interrupt::ADC1_2.set_priority(Priority::P0);
    // SAFETY: its state is in place.
    unsafe { interrupt::ADC1_2.enable() };
    bridge::start();
}

#[interrupt]
fn ADC1_2() {
    let (current, supply) = sampling::read();
    // SAFETY: see `Owned`.
    let Some(control) = (unsafe { &mut *CONTROL.0.get() }) else {
        return;
    };
    let inputs = Inputs {
        current,
        supply,
        encoder: encoder::read(),
        bridge_fault: control.bridge.fault(),
        overrun: control.overrun,
    };
    control.bridge.apply(step(inputs));
    PERIODS.store(
        PERIODS.load(Ordering::Relaxed).wrapping_add(1),
        Ordering::Relaxed,
    );
    control.overrun = sampling::pending();
}

/// Stands in for the controller: the bridge stays off.
fn step(_inputs: Inputs) -> Outputs {
    Outputs::Off
}
