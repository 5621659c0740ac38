//! The control interrupt: 20 kHz, highest priority, registers in, registers out.
//!
//! In between runs [`Controller::step`], the same code as in the host's simulation. Nothing here waits, allocates, logs or
//! can panic; `palpate-reach` proves it on the linked image.
//!
//! It runs from CCM SRAM, without the wait states of the flash, which would cost it more cycles than its instructions:
//! `palpate-reach` proves as well that nothing that it reaches lies elsewhere.
#![allow(
    clippy::unit_arg,
    clippy::let_unit_value,
    reason = "a reading of joint 2 is nothing in a scene without its sensor"
)]

use core::cell::{Cell, UnsafeCell};
use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering, compiler_fence};

use cortex_m::peripheral::NVIC;
use cortex_m::{asm, interrupt as mask};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{Interrupt, InterruptExt, Priority};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

use palpate::drive::io::Inputs;
use palpate::drive::joint::JointInput;
use palpate::drive::{Controller, Demand, Status};
use palpate::scene::{Active, JointPin, SampleOf};

use super::bridge::{self, Bridge};
use super::watchdog::{self, Reporter};
use super::{encoder, sampling};

/// What the interrupt hands out: joint 2 is still a code.
type Sample = palpate::sample::Sample<<JointPin<Active> as JointInput>::Raw>;

/// Samples on their way to the sensing task, one a millisecond. The longest time for which it does not run is well
/// below this many milliseconds; if it is not, the loss is a fault.
const QUEUE_SAMPLES: usize = 16;

/// Hands a value from one context to another. The lock masks interrupts for the few instructions of the copy.
type Handover<T> = Mutex<CriticalSectionRawMutex, Cell<T>>;

static DEMAND: Handover<Demand> = Mutex::new(Cell::new(Demand::REST));
static SAMPLED: Signal<CriticalSectionRawMutex, ()> = Signal::new();
/// Samples that found the queue full; wraps.
static LOST: AtomicU32 = AtomicU32::new(0);

/// The queue: a ring of places, each empty or not, which both ends go round by themselves. Not a library's, which is a call
/// to flash where it is not inlined.
static QUEUE: [Handover<Option<Sample>>; QUEUE_SAMPLES] =
    [const { Mutex::new(Cell::new(None)) }; QUEUE_SAMPLES];

/// The place in the queue of one who has gone so many places.
#[inline(always)]
fn place(gone: usize) -> &'static Handover<Option<Sample>> {
    &QUEUE[gone % QUEUE_SAMPLES]
}

/// What belongs to the interrupt.
struct Control {
    bridge: Bridge,
    controller: Controller,
    samples: usize,
    overrun: bool,
}

/// Not an `Option`, whose `None` would be no zero, and so the whole an image in flash.
struct Owned {
    control: UnsafeCell<MaybeUninit<Control>>,
    there: AtomicBool,
}

// SAFETY: written once before the interrupt is enabled; then touched by the interrupt alone, which cannot preempt itself, and
// read while it is masked.
unsafe impl Sync for Owned {}

static CONTROL: Owned = Owned {
    control: UnsafeCell::new(MaybeUninit::zeroed()),
    there: AtomicBool::new(false),
};

/// The receiving end of the samples.
pub struct Samples {
    taken: usize,
    joint: JointPin<Active>,
    lost: u32,
}

impl Samples {
    /// Waits until the control interrupt has made a sample.
    pub fn wait(&mut self) -> impl Future<Output = ()> {
        SAMPLED.wait()
    }

    /// The oldest sample, if there is one.
    pub fn next(&mut self) -> Option<SampleOf<Active>> {
        let sample = place(self.taken).lock(Cell::take)?;
        self.taken = self.taken.wrapping_add(1);
        let reading = self.joint.reading(sample.joint);
        Some(sample.with_joint(reading))
    }

    /// Whether samples were lost since the last call.
    pub fn overflowed(&mut self) -> bool {
        let lost = LOST.load(Ordering::Relaxed);
        let overflowed = lost != self.lost;
        self.lost = lost;
        overflowed
    }
}

/// Tells the controller what is wanted from the next control period on.
pub fn demand(demand: Demand) {
    DEMAND.lock(|cell| cell.set(demand));
}

/// The state of the motor.
#[inline(never)]
pub fn status() -> Status {
    if !CONTROL.there.load(Ordering::Relaxed) {
        return Status::default();
    }
    // SAFETY: see `Owned`; it is there, and within the critical section its interrupt is masked.
    mask::free(|_| unsafe {
        *(*CONTROL.control.get())
            .assume_init_ref()
            .controller
            .status()
    })
}

/// Copies the interrupt's code to where it is linked to run. Call once, first of all.
pub fn load() {
    // `memory.x` defines them; only their addresses mean something.
    unsafe extern "C" {
        static mut _control_start: u32;
        static _control_end: u32;
        static _control_load: u32;
    }
    // SAFETY: the linker aligns the three to words and reserves the region from start to end for this code, of which nothing
    // runs before its interrupt is enabled.
    unsafe {
        let start = &raw mut _control_start;
        let words = (&raw const _control_end).offset_from(start);
        ptr::copy_nonoverlapping(&raw const _control_load, start, words as usize);
    }
    // What was written is there before it is fetched.
    asm::dsb();
    asm::isb();
}

/// Gives bridge and controller to the interrupt and starts it, once; `joint` reads joint 2.
pub fn start(bridge: Bridge, controller: Controller, joint: JointPin<Active>) -> Samples {
    // SAFETY: the interrupt is not enabled yet.
    unsafe {
        (*CONTROL.control.get()).write(Control {
            bridge,
            controller,
            samples: 0,
            overrun: false,
        });
    }
    // Of one core the compiler alone could have it in another order.
    compiler_fence(Ordering::Release);
    CONTROL.there.store(true, Ordering::Relaxed);
    interrupt::ADC1_2.set_priority(Priority::P0);
    interrupt::FMAC.set_priority(Priority::P6);
    // SAFETY: what they need is in place.
    unsafe {
        interrupt::FMAC.enable();
        interrupt::ADC1_2.enable();
    }
    bridge::start();
    Samples {
        taken: 0,
        joint,
        lost: 0,
    }
}

/// Keeps the control interrupt from running until it is dropped.
pub struct Pause(());

/// Masks the control interrupt: for a flash operation, with the bridge off.
pub fn pause() -> Pause {
    interrupt::ADC1_2.disable();
    Pause(())
}

impl Drop for Pause {
    fn drop(&mut self) {
        // SAFETY: the state is in place, or the handler returns at once.
        unsafe { interrupt::ADC1_2.enable() };
    }
}

/// The vector table takes it by its name; `#[interrupt]` would put a call from flash before it.
#[unsafe(export_name = "ADC1_2")]
#[unsafe(link_section = ".control")]
extern "C" fn control() {
    let (current, supply) = sampling::read();
    if !CONTROL.there.load(Ordering::Relaxed) {
        return;
    }
    compiler_fence(Ordering::Acquire);
    // SAFETY: see `Owned`; it is there.
    let control = unsafe { (*CONTROL.control.get()).assume_init_mut() };
    let inputs = Inputs {
        current,
        supply,
        encoder: encoder::read(),
        bridge_fault: control.bridge.fault(),
        overrun: control.overrun,
    };
    let demand = DEMAND.lock(Cell::get);
    let outputs = control.controller.step(&inputs, &demand);
    control.bridge.apply(outputs);
    if let Some(sample) = control.controller.sample() {
        let sample = sample.with_joint(JointPin::<Active>::take(sampling::read_joint));
        place(control.samples).lock(|place| {
            if place.get().is_none() {
                place.set(Some(sample));
                control.samples = control.samples.wrapping_add(1);
            } else {
                let lost = LOST.load(Ordering::Relaxed).wrapping_add(1);
                LOST.store(lost, Ordering::Relaxed);
            }
        });
        // Waking a task runs code of the executor, behind a pointer: a lower interrupt does that.
        NVIC::pend(Interrupt::FMAC);
        watchdog::report(Reporter::Control);
    }
    control.overrun = sampling::pending();
}

/// Not the filter accelerator, which is unused, but its vector: wakes the sensing task on behalf of the control interrupt.
#[interrupt]
fn FMAC() {
    SAMPLED.signal(());
}
