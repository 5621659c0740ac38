//! Tests of the chip itself, for a board and for the emulated one: the library's arithmetic, cycle counts, interrupt latency,
//! flash store, break input, watchdog. Each is a line `target test= result= value= want=`; the host compares checksums.
//!
//! Nothing moves: the bridge stays asleep. The last test resets the chip; the run goes on behind it.

use core::hint::black_box;
use core::mem::MaybeUninit;
use core::pin::pin;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::{Context, Poll, Waker};

use cortex_m::peripheral::{DWT, SCB};
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, exit};
use defmt::info;
use defmt_rtt as _;
use embassy_stm32::Peri;
use embassy_stm32::flash::{Blocking, Error, Flash};
use embassy_stm32::peripherals;
use embassy_stm32::wdg::IndependentWatchdog;
use palpate::app::storage::store::{Found, Memory, PAGE, PAGES, Store, WORD, Writer};
use palpate_bench::arithmetic;

use crate::{bridge, ccm, clock, reset};

/// Pages in front of those of the firmware's records, which stay as they are; this image does not reach so far.
const STORE_START: u32 = 128 * 1024 - 2 * (PAGES * PAGE) as u32;
const FLASH_START: usize = 0x0800_0000;
/// Longest step of the controller, counts: a control period has 8,500 cycles (chosen: less than half of it).
const STEP_MAX: u32 = 4000;
/// From pending an interrupt to its handler's first count: 12 cycles, floating-point registers and the fetch from flash (chosen).
const LATENCY_MAX: u32 = 100;
/// Nominal time to the watchdog's reset.
const WATCHDOG_US: u32 = 100_000;
/// Time for the probe to find the log after a reset: 0.6 s at 170 MHz.
const LOG_FOUND_CYCLES: u32 = 102_000_000;

/// Says over a reset that the watchdog is awaited.
#[unsafe(link_section = ".uninit.awaited")]
static AWAITED: MaybeUninit<AtomicU32> = MaybeUninit::uninit();
const MARK: u32 = 0xD06_BA17;

fn awaited() -> &'static AtomicU32 {
    // SAFETY: any bits are a value of this type.
    unsafe { AWAITED.assume_init_ref() }
}

fn tell(test: &str, good: bool, value: u32, want: &str) {
    let result = if good { "ok" } else { "failed" };
    info!(
        "target test={=str} result={=str} value={=u32} want={=str}",
        test, result, value, want
    );
}

#[entry]
fn main() -> ! {
    // The controller's code runs from there.
    ccm::load();
    let mut chip = clock::start();
    clock::speed_up(&mut chip.RCC);
    let cause = reset::take();
    if awaited().swap(0, Ordering::Relaxed) == MARK {
        let bit = cause == reset::Reset::Watchdog;
        tell("watchdog", bit, u32::from(bit), "1: the reset's cause");
        info!("target done");
        // Wait for the probe: probe-rs looks at the log once in 100 ms. After a reset its first look lets go of the old log, and the next
        // finds this one; a run that ends before is read no further.
        cortex_m::asm::delay(LOG_FOUND_CYCLES);
        leave(true)
    }
    if let Some(mut peripherals) = cortex_m::Peripherals::take() {
        peripherals.DCB.enable_trace();
        peripherals.DWT.enable_cycle_counter();
    }
    arithmetic::visit(|name, sum| {
        info!(
            "target test=arithmetic name={=str} checksum={=u32}",
            name, sum
        )
    });
    step();
    latency();
    let pins = bridge::Pins {
        enable: chip.PA8,
        phase: chip.PA9,
        sleep: chip.PB5,
        fault: chip.PB10,
    };
    let _bridge = bridge::Bridge::new(chip.TIM1, pins);
    bridge::start();
    let cut = bridge::is_off() && bridge::break_cuts_outputs();
    tell(
        "break-input",
        cut,
        u32::from(cut),
        "1: a low nFAULT cuts the outputs",
    );
    tell(
        "bridge-off",
        bridge::is_off(),
        u32::from(bridge::is_off()),
        "1: asleep, outputs disabled",
    );
    let kept = now(store(Store::new(Region(Flash::new_blocking(chip.FLASH)))));
    tell(
        "store",
        kept == Some(3),
        kept.unwrap_or(0),
        "3: records read back",
    );
    watchdog(chip.IWDG)
}

/// What a step of the controller costs, by the core's counter.
fn step() {
    let (mut most, mut begun) = (0, 0);
    let done = arithmetic::controller(|before| {
        let count = DWT::cycle_count();
        if before {
            begun = count;
        } else {
            most = most.max(count.wrapping_sub(begun));
        }
    });
    let good = done.is_ok() && most > 0 && most <= STEP_MAX;
    tell(
        "control-step",
        good,
        most,
        "at most 4000 cycles (the emulator: instructions)",
    );
}

static ENTERED: AtomicU32 = AtomicU32::new(0);

/// Takes the time of its entry.
#[exception]
fn PendSV() {
    ENTERED.store(DWT::cycle_count(), Ordering::Relaxed);
}

/// From pending an interrupt to its handler.
fn latency() {
    let mut most = 0;
    for _ in 0..100 {
        ENTERED.store(0, Ordering::Relaxed);
        let begun = black_box(DWT::cycle_count());
        SCB::set_pendsv();
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        most = most.max(ENTERED.load(Ordering::Relaxed).wrapping_sub(begun));
    }
    tell(
        "interrupt-latency",
        most > 0 && most <= LATENCY_MAX,
        most,
        "at most 100 cycles (the emulator: instructions)",
    );
}

/// The flash controller with pages for a store.
struct Region(Flash<'static, Blocking>);

impl Memory for Region {
    type Error = Error;

    fn read<R>(&mut self, look: impl FnOnce(&[u8]) -> R) -> R {
        let start = (FLASH_START + STORE_START as usize) as *const u8;
        // SAFETY: flash behind this image, not written while the slice lives.
        look(unsafe { core::slice::from_raw_parts(start, PAGES * PAGE) })
    }

    fn undisturbed(
        &mut self,
        operation: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        operation(self)
    }

    fn erase(&mut self, page: usize) -> Result<(), Error> {
        let from = STORE_START + (page * PAGE) as u32;
        self.0.blocking_erase(from, from + PAGE as u32)
    }

    fn program(&mut self, offset: usize, word: [u8; WORD]) -> Result<(), Error> {
        self.0.blocking_write(STORE_START + offset as u32, &word)
    }

    async fn rest(&mut self) {}
}

/// Writes records of several lengths and forgets them; how many could be read back.
async fn store(mut store: Store<Region>) -> Option<u32> {
    let mut kept = 0;
    for (seed, length) in [(1u8, 8usize), (2, 333), (3, 1500)] {
        let byte = |at: usize| (at as u8).wrapping_mul(31) ^ seed;
        let encode =
            |writer: &mut Writer<'_, Region>| (0..length).for_each(|at| writer.push(byte(at)));
        store.replace(Some(encode)).await.ok()?;
        let same = store.load(|found| match found {
            Found::Record { bytes, newest } => {
                newest
                    && bytes.len() == length
                    && bytes.iter().enumerate().all(|(at, &b)| b == byte(at))
            }
            _ => false,
        });
        kept += u32::from(same);
    }
    store
        .replace(None::<fn(&mut Writer<'_, Region>)>)
        .await
        .ok()?;
    store.load(|found| found == Found::Nothing).then_some(kept)
}

/// The value of a future that never waits.
fn now<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(value) = future
            .as_mut()
            .poll(&mut Context::from_waker(Waker::noop()))
        {
            return value;
        }
    }
}

/// Starts the watchdog and does not feed it.
fn watchdog(watchdog: Peri<'static, peripherals::IWDG>) -> ! {
    awaited().store(MARK, Ordering::Relaxed);
    IndependentWatchdog::new(watchdog, WATCHDOG_US).unleash();
    // A second, of which the watchdog leaves a tenth.
    cortex_m::asm::delay(170_000_000);
    awaited().store(0, Ordering::Relaxed);
    tell("watchdog", false, 0, "1: the reset's cause");
    info!("target done");
    leave(false)
}

/// Ends the run under a debug probe or in the emulator.
fn leave(good: bool) -> ! {
    exit(if good { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {
        cortex_m::asm::nop();
    }
}

/// A test that panics ends the run.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    defmt::error!(
        "target panicked line={=u32}",
        info.location().map_or(0, |at| at.line())
    );
    leave(false)
}
