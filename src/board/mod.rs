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
mod execute;
#[cfg(feature = "fault-injection")]
mod inject;
mod last_run;
mod log;
mod reset;
mod sampling;
mod serial;
mod slow;
mod storage;
mod telemetry;
mod watchdog;

use core::cell::RefCell;

use embassy_executor::{Executor, Spawner};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_sync::blocking_mutex::Mutex;
use static_cell::StaticCell;

use palpate::app::conduct::{Conduct, drive};
use palpate::app::sense::Sense;
use palpate::app::settings::Overrides;
use palpate::app::store::Store;
use palpate::drive::config::OutOfRange;
use palpate::drive::joint::JointInput;
use palpate::drive::sequence::Notice;
use palpate::drive::{Controller, Fault};
use palpate::scene::{Active, JointPin, Scene};

use execute::Kept;
use slow::Shared;

/// Runs after RAM is set up, on the main stack: moves thread mode to the process stack (`memory.x` says why).
#[cortex_m_rt::entry]
fn main() -> ! {
    unsafe extern "C" {
        static _process_stack_start: u32;
    }
    control::load();
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
    EXECUTOR.init(Executor::new()).run(|spawner| {
        // The first task: there is room for it.
        spawner.spawn(start(spawner).expect("first"));
    })
}

/// Brings the chip up: what the last run left, what was kept in flash, the bridge (off), then the other tasks; then carries
/// out commands.
#[embassy_executor::task]
async fn start(spawner: Spawner) {
    let p = clock::start();
    interrupt::TIM2.set_priority(Priority::P8);
    telemetry::boot(Active::NAME);
    let mut fault = last_run::report();

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
    if JointPin::<Active>::FITTED {
        sampling::start_joint(p.ADC2, p.PC1);
    }
    sampling::start(p.ADC1, p.PA1, p.PC0);
    let light = slow::Light::new(Output::new(p.PA5, Level::Low, Speed::Low));
    // The board pulls it down.
    let button = slow::Button::new(Input::new(p.PC13, Pull::None));
    let (sender, receiver) = serial::open(p.LPUART1, p.PA2, p.PA3);

    let sense = sensing();
    let mut storage = Store::new(storage::Region::new(p.FLASH));
    let mut overrides = Overrides::default();
    match execute::load(&mut storage, sense) {
        Kept::Nothing => {}
        Kept::Unusable => fault = fault.or(Some(Fault::BadRecord)),
        Kept::Restored {
            overrides: set,
            notice,
        } => {
            overrides = set;
            slow::tell(notice).await;
        }
    }
    let (samples, conduct) = match launch(bridge, overrides, &mut fault) {
        Ok(running) => running,
        Err(wrong) => return telemetry::bad_configuration(&wrong),
    };
    if let Some(fault) = fault {
        slow::tell(Notice::Fault(fault)).await;
    }
    // Each task is spawned once: there is room for it.
    spawner.spawn(watchdog::supervise(watchdog::start(p.IWDG)).expect("first"));
    spawner.spawn(console::listen(receiver).expect("first"));
    spawner.spawn(slow::sense(samples, sense, conduct).expect("first"));
    spawner.spawn(slow::sequence(light, button, sense, conduct).expect("first"));
    // The rest of this task's life: it shares its memory with what is above.
    execute::execute(sender, storage, sense, conduct).await
}

static SENSE: StaticCell<Shared<Sense<Active>>> = StaticCell::new();
static CONDUCT: StaticCell<Shared<Conduct<Active>>> = StaticCell::new();

fn shared<T>(cell: &'static StaticCell<Shared<T>>, value: T) -> &'static Shared<T> {
    cell.init(Mutex::new(RefCell::new(value)))
}

/// The sensing half. Apart from [`start`], so that it lies on the stack for the moment only; so does [`launch`].
#[inline(never)]
fn sensing() -> &'static Shared<Sense<Active>> {
    shared(&SENSE, Sense::new())
}

/// Starts the control interrupt and makes the motion half, with what the user has set. Where that no longer fits the scene
/// there is a fault, and the scene's own values count; where joint 2's sensor does not fit the board, nothing can move.
#[inline(never)]
fn launch(
    bridge: bridge::Bridge,
    set: Overrides,
    fault: &mut Option<Fault>,
) -> Result<(control::Samples, &'static Shared<Conduct<Active>>), OutOfRange> {
    let joint = Active::joint_input()?;
    let (drive, set) = match drive::<Active>(&set) {
        Ok(drive) => (drive, set),
        Err(wrong) => {
            telemetry::bad_configuration(&wrong);
            *fault = fault.or(Some(Fault::BadConfiguration));
            (Active::CHECKED, Overrides::default())
        }
    };
    let controller = Controller::new(&drive);
    Ok((
        control::start(bridge, controller, joint),
        shared(&CONDUCT, Conduct::new(set)),
    ))
}
