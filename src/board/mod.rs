//! The chip: what moves bits between registers and the library.
//!
//! | priority | interrupt | what | may log, allocate, block |
//! |---|---|---|---|
//! | non-maskable | NMI | bad flash word: acknowledged while records are read, else bridge off and reset | no |
//! | 0 | ADC1_2 | control, 20 kHz: samples in, controller, bridge out | no |
//! | 8 | TIM2 | embassy's clock: timers of the tasks | no |
//! | 10 | LPUART1 | bytes of the serial port | no |
//! | thread | executor | sensing, sequence, commands, telemetry, watchdog feeding | may log, never blocks on a reader |

mod bridge;
mod clock;
mod control;
mod crash;
mod encoder;
mod log;
mod reset;
mod sampling;
mod serial;
mod storage;
mod watchdog;

use embassy_executor::{Executor, Spawner};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_time::{Duration, Ticker};
use static_cell::StaticCell;

/// Runs after RAM is set up, on the main stack: moves thread mode to the process stack (`memory.x` says why).
#[cortex_m_rt::entry]
fn main() -> ! {
    unsafe extern "C" {
        static _process_stack_start: u32;
    }
    // SAFETY: the linker reserves the region for nothing else, its end is aligned to 8 bytes, and nothing on the main
    // stack is needed any more.
    unsafe {
        core::arch::asm!(
            "msr PSP, {top}",
            "msr CONTROL, {process}",
            "isb",
            "b {thread}",
            top = in(reg) &raw const _process_stack_start,
            process = in(reg) 2,
            thread = sym thread,
            options(noreturn)
        )
    }
}

extern "C" fn thread() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    EXECUTOR.init(Executor::new()).run(start)
}

fn start(spawner: Spawner) {
    let p = embassy_stm32::init(clock::config());
    clock::watch_crystal();
    interrupt::TIM2.set_priority(Priority::P8);
    interrupt::LPUART1.set_priority(Priority::P10);

    let reset = reset::take();
    let missing = watchdog::take_reports();
    defmt::info!("boot version={=str}", env!("CARGO_PKG_VERSION"));
    defmt::info!("reset cause={=str}", reset.name());
    if let (reset::Reset::Watchdog, Some(missing)) = (reset, missing) {
        defmt::error!(
            "watchdog control_missing={=bool} sensing_missing={=bool} sequence_missing={=bool}",
            missing.control,
            missing.sensing,
            missing.sequence
        );
    }
    if let Some(crash) = crash::take() {
        defmt::error!(
            "crash cause={=str} pc={=u32:#x} lr={=u32:#x} status={=u32:#x} address={=u32:#x} text={=str}",
            crash.cause().name(),
            crash.pc,
            crash.lr,
            crash.status,
            crash.address,
            crash.text()
        );
    }

    let bridge = bridge::Bridge::new(
        p.TIM1,
        bridge::Pins {
            enable: p.PA8,
            phase: p.PA9,
            sleep: p.PB5,
            fault: p.PB10,
        },
    );
    encoder::start(p.TIM3, p.PA6, p.PA7);
    sampling::start(p.ADC1, p.PA1, p.PC0);
    let serial = serial::open(p.LPUART1, p.PA2, p.PA3);
    let storage = storage::Storage::new(p.FLASH);
    let watchdog = watchdog::start(p.IWDG);
    control::start(bridge);
    let led = Output::new(p.PA5, Level::Low, Speed::Low);
    let button = Input::new(p.PC13, Pull::Down);
    spawner.spawn(watchdog::supervise(watchdog).unwrap());
    spawner.spawn(alive(led, button, storage, serial).unwrap());
}

#[embassy_executor::task]
async fn alive(
    mut led: Output<'static>,
    button: Input<'static>,
    mut storage: storage::Storage,
    mut serial: embassy_stm32::usart::BufferedUart<'static>,
) {
    let mut ticker = Ticker::every(Duration::from_millis(100));
    let n = storage.load(1).await.ok().flatten().map(|r| r.len());
    defmt::info!("storage record_bytes={}", n);
    let _ = embedded_io_async::Write::write_all(&mut serial, b"hello\n").await;
    let _ = storage.save(1, b"hello").await;
    loop {
        ticker.next().await;
        led.toggle();
        defmt::info!(
            "alive periods={=u32} button={=bool} command_byte={} dropped={=u32}",
            control::periods(),
            button.is_high(),
            log::read_byte(),
            log::dropped()
        );
    }
}
