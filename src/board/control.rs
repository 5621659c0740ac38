//! The control interrupt: 20 kHz, highest priority, registers in, registers out.
//!
//! In between runs [`Controller::step`], the same code as in the host's simulation. Nothing here waits, allocates, logs or
//! can panic. It runs from CCM SRAM, without the wait states of flash, which would cost more cycles than its instructions;
//! `memory.x` places it there. `palpate-reach` proves both on the linked image.
#![allow(
    clippy::unit_arg,
    clippy::let_unit_value,
    reason = "a reading of joint 2 is nothing in a scene without its sensor"
)]

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{Interrupt, InterruptExt, Priority};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use heapless::spsc::{Consumer, Producer, Queue};
use static_cell::StaticCell;

use super::Joint;
use crate::scene::Active;
use palpate::drive::io::Inputs;
use palpate::drive::{Controller, Demand, Status};
use palpate::joint_sensor::JointSensor;
use palpate::scene::{SampleOf, Scene as _};

use super::bridge::{self, Bridge};
use super::encoder::Encoder;
use super::sampling::{self, Sampling};
use super::watchdog::{self, Reporter};

/// What the interrupt hands out: joint 2 is still a code.
type Sample = palpate::sample::Sample<<Joint as JointSensor>::Code>;

/// Samples on their way to the sensing task, one a millisecond: one less than this fits. The task is never kept from running
/// for nearly as long; if it is, the loss is a fault. On three phalanges an update takes up to 250,000 instructions, 3 to
/// 7 ms, and such updates follow each other.
const QUEUE_SAMPLES: usize = if Active::PHALANGES > 2 { 48 } else { 16 };

/// What the interrupt works with. Inside the interrupt the lock costs two instructions: nothing can preempt it anyway.
static CONTROL: Mutex<CriticalSectionRawMutex, RefCell<Slot>> =
    Mutex::new(RefCell::new(Slot::Empty));
static SAMPLED: Signal<CriticalSectionRawMutex, ()> = Signal::new();
/// Samples that found the queue full; wraps.
static LOST: AtomicU32 = AtomicU32::new(0);

/// Empty until [`start`]. An `Option` would say that within [`Control`], by a value that is not zero, and all of it would have
/// an initial value in flash.
#[repr(u8)]
#[expect(
    clippy::large_enum_variant,
    reason = "one static, filled once and for good"
)]
enum Slot {
    Empty,
    Filled(Control),
}

/// What belongs to the interrupt.
struct Control {
    bridge: Bridge,
    encoder: Encoder,
    _sampling: Sampling,
    controller: Controller,
    demand: Demand,
    samples: Producer<'static, Sample>,
    overrun: bool,
}

/// The receiving end of the samples.
pub struct Samples {
    queue: Consumer<'static, Sample>,
    joint: Joint,
    lost: u32,
}

impl Samples {
    /// Waits until the control interrupt has made a sample.
    pub fn wait(&mut self) -> impl Future<Output = ()> {
        SAMPLED.wait()
    }

    /// The oldest sample, if there is one.
    pub fn next(&mut self) -> Option<SampleOf<Active>> {
        let sample = self.queue.dequeue()?;
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
    CONTROL.lock(|control| {
        // No one holds it while interrupts are masked, here and below: the alternatives are there so that nothing can panic.
        if let Ok(mut control) = control.try_borrow_mut()
            && let Slot::Filled(control) = &mut *control
        {
            control.demand = demand;
        }
    });
}

/// The state of the motor.
pub fn status() -> Status {
    CONTROL.lock(|control| match control.try_borrow().as_deref() {
        Ok(Slot::Filled(control)) => *control.controller.status(),
        _ => Status::default(),
    })
}

/// What the interrupt needs of the chip.
pub struct Chip {
    /// The bridge, off.
    pub bridge: Bridge,
    /// The motor's encoder.
    pub encoder: Encoder,
    /// Current, supply and joint 2.
    pub sampling: Sampling,
}

/// Gives chip and controller to the interrupt and starts it, once; `joint` reads joint 2. `None` the second time.
pub fn start(chip: Chip, controller: Controller, joint: Joint) -> Option<Samples> {
    static QUEUE: StaticCell<Queue<Sample, QUEUE_SAMPLES>> = StaticCell::new();
    let (samples, queue) = QUEUE.try_init(Queue::new())?.split();
    CONTROL.lock(|control| {
        if let Ok(mut control) = control.try_borrow_mut() {
            *control = Slot::Filled(Control {
                bridge: chip.bridge,
                encoder: chip.encoder,
                _sampling: chip.sampling,
                controller,
                demand: Demand::REST,
                samples,
                overrun: false,
            });
        }
    });
    interrupt::ADC1_2.set_priority(Priority::P0);
    interrupt::FMAC.set_priority(Priority::P6);
    // SAFETY: what they need is in place.
    unsafe {
        interrupt::FMAC.enable();
        interrupt::ADC1_2.enable();
    }
    bridge::start();
    Some(Samples {
        queue,
        joint,
        lost: 0,
    })
}

/// Keeps the control interrupt from running until it is dropped.
pub struct Pause(());

/// Masks the control interrupt: for a flash operation, with the bridge off.
pub fn pause() -> Pause {
    interrupt::ADC1_2.disable();
    Pause(())
}

impl Drop for Pause {
    // Not inlined: in three places.
    #[inline(never)]
    fn drop(&mut self) {
        // The interrupt waits for the next sequence. Raised by an old one it would run at any moment, and a sequence that ends while it
        // runs counts as an overrun.
        sampling::drop_pending();
        // SAFETY: the state is in place, or the handler returns at once.
        unsafe { interrupt::ADC1_2.enable() };
    }
}

/// Control interrupt.
#[interrupt]
fn ADC1_2() {
    let readings = sampling::read();
    CONTROL.lock(|control| {
        if let Ok(mut control) = control.try_borrow_mut()
            && let Slot::Filled(control) = &mut *control
        {
            let inputs = Inputs {
                current: readings.current,
                late_excess: readings.late_excess,
                supply: readings.supply,
                encoder: control.encoder.read(),
                bridge_fault: control.bridge.fault(),
                overrun: control.overrun,
            };
            let outputs = control.controller.step(&inputs, &control.demand);
            control.bridge.apply(outputs);
            if let Some(sample) = control.controller.sample() {
                let sample = sample.with_joint(Joint::take(sampling::read_joint));
                hand_over(&mut control.samples, sample);
            }
            control.overrun = sampling::pending();
        }
    });
}

/// Puts a sample into the queue and has the sensing task woken.
fn hand_over(samples: &mut Producer<'static, Sample>, sample: Sample) {
    // Always true. It gives the compiler the queue's length, without which the queue divides by a number that could be zero,
    // and that would be a panic.
    let fits = samples.capacity() == QUEUE_SAMPLES - 1 && samples.enqueue(sample).is_ok();
    if !fits {
        let lost = LOST.load(Ordering::Relaxed).wrapping_add(1);
        LOST.store(lost, Ordering::Relaxed);
    }
    // Waking a task runs code of the executor, behind a pointer: a lower interrupt does that.
    NVIC::pend(Interrupt::FMAC);
    watchdog::report(Reporter::Control);
}

/// Wakes the sensing task on behalf of the control interrupt. The filter accelerator itself is not used, only its vector.
#[interrupt]
fn FMAC() {
    SAMPLED.signal(());
}
