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
mod console;
mod control;
mod crash;
mod encoder;
#[cfg(feature = "fault-injection")]
mod inject;
mod last_run;
mod log;
mod reset;
mod sampling;
mod serial;
mod storage;
mod telemetry;
mod watchdog;

use embassy_executor::{Executor, Spawner};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_time::{Duration, Ticker};
use static_cell::StaticCell;

use palpate::app::command::{COMMANDS, Command};
use palpate::drive::{Controller, Demand};
use palpate::scene::{Active, Scene};

use control::Samples;
use watchdog::Reporter;

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

/// Brings the chip up, then the tasks.
fn start(spawner: Spawner) {
    let p = embassy_stm32::init(clock::config());
    clock::boost();
    clock::watch_crystal();
    interrupt::TIM2.set_priority(Priority::P8);
    interrupt::LPUART1.set_priority(Priority::P10);
    telemetry::boot(Active::NAME);
    if let Some(fault) = last_run::report() {
        telemetry::fault(fault);
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
    let (tx, rx) = serial::open(p.LPUART1, p.PA2, p.PA3).split();
    let storage = storage::Storage::new(p.FLASH);
    let led = Output::new(p.PA5, Level::Low, Speed::Low);
    let button = Input::new(p.PC13, Pull::Down);
    let controller = Controller::new(&Active::DRIVE).expect("configuration");
    let samples = control::start(bridge, controller);

    // Each is spawned once: there is room for it.
    spawner.spawn(watchdog::supervise(watchdog::start(p.IWDG)).expect("first"));
    spawner.spawn(console::listen(rx).expect("first"));
    spawner.spawn(execute(console::Speaker::new(tx), storage).expect("first"));
    spawner.spawn(sense(samples).expect("first"));
    spawner.spawn(sequence(led, button).expect("first"));
}

#[embassy_executor::task]
async fn sense(mut samples: Samples) {
    loop {
        samples.wait().await;
        #[cfg(feature = "fault-injection")]
        inject::starve().await;
        while let Some(_sample) = samples.next() {}
        watchdog::report(Reporter::Sensing);
    }
}

#[embassy_executor::task]
async fn sequence(mut led: Output<'static>, button: Input<'static>) {
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let mut dropped = 0;
    loop {
        ticker.next().await;
        control::demand(Demand::default());
        if console::stop_requested() || button.is_high() {
            led.toggle();
        }
        if log::dropped() != dropped {
            dropped = log::dropped();
            telemetry::dropped(dropped);
        }
        watchdog::report(Reporter::Sequence);
    }
}

#[embassy_executor::task]
async fn execute(mut speaker: console::Speaker, mut storage: storage::Storage) {
    let record = storage.load(RECORD).await.map(|r| r.map(<[u8]>::len));
    match record {
        Ok(Some(length)) => defmt::info!("record bytes={}", length),
        Ok(None) => telemetry::record("all", "none"),
        Err(error) => telemetry::record("all", error.name()),
    }
    loop {
        match console::next().await {
            Ok(Command::Help) => {
                for (name, usage, what) in COMMANDS {
                    speaker.answer(format_args!("{name} {usage}: {what}")).await;
                }
            }
            Ok(Command::Save) => match storage.save(RECORD, b"hello").await {
                Ok(()) => speaker.answer(format_args!("saved")).await,
                Err(error) => {
                    speaker
                        .answer(format_args!("not saved: {}", error.name()))
                        .await
                }
            },
            Ok(Command::Factory) => match storage.erase().await {
                Ok(()) => speaker.answer(format_args!("forgotten")).await,
                Err(error) => {
                    speaker
                        .answer(format_args!("not erased: {}", error.name()))
                        .await
                }
            },
            Ok(_) => speaker.answer(format_args!("ok")).await,
            Err(error) => speaker.answer(format_args!("error: {error}")).await,
        }
    }
}

/// Key of the one record.
const RECORD: u8 = 1;
