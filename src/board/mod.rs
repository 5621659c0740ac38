//! The chip: what moves bits between registers and the library.
//!
//! | priority | interrupt | what | may log, allocate, block |
//! |---|---|---|---|
//! | non-maskable | NMI | bad flash word: acknowledged while records are read, else bridge off and reset | no |
//! | 0 | ADC1_2 | control, 20 kHz: samples in, controller, bridge out | no |
//! | 6 | FMAC | wakes the sensing task, pended by the control interrupt | no |
//! | 8 | TIM2 | embassy's clock: timers of the tasks | no |
//! | 10 | LPUART1 | bytes of the serial port | no |
//! | thread | executor | sensing, sequence, commands, telemetry, watchdog feeding | may log, never blocks on a reader |

mod bridge;
mod ccm;
mod clock;
mod console;
mod control;
mod crash;
mod encoder;
mod execute;
#[cfg(identify)]
mod identify;
mod indicator;
#[cfg(feature = "fault-injection")]
mod inject;
mod memory;
mod ram;
mod reset;
mod restart;
mod rtt;
mod sampling;
mod selftest;
mod serial;
mod shared;
mod storage;
mod tasks;
mod telemetry;
mod thermal;
mod trace;
mod watchdog;

use embassy_executor::raw::Executor;
use embassy_executor::{SpawnError, SpawnToken, Spawner};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use static_cell::StaticCell;

use crate::scene::Active;
use palpate::app::console::settings::Overrides;
use palpate::app::grasp::coordinator::Coordinator;
use palpate::app::grasp::sensing::{ContactSensing, SensingRequest};
use palpate::app::grasp::values::drive;
use palpate::app::log::Log;
use palpate::app::storage::store::Store;
use palpate::drive::config::{CheckedConfig, OutOfRange};
use palpate::drive::identify::Identified;
use palpate::drive::sequence::Notice;
use palpate::drive::{Controller, Fault};
use palpate::joint_sensor::JointSensor;
use palpate::scene::Scene;

use execute::{Application, Loaded};
use reset::Reset;
use shared::Shared;
use telemetry::Telemetry;

/// What measures joint 2 in this firmware's scene.
type Joint = <Active as Scene>::Joint;
/// What lies in series with the finger.
type Series = <Active as Scene>::Series;

/// Runs after RAM is set up, on the main stack: moves thread mode to the process stack (`memory.x` says why).
#[cortex_m_rt::entry]
fn main() -> ! {
    unsafe extern "C" {
        static _process_stack_start: u32;
    }
    ccm::load();
    // SAFETY: the linker reserves the region for nothing else, its end is aligned to 8 bytes, and nothing on the main
    // stack is needed any more.
    unsafe { cortex_m::asm::enter_privileged_psp(&raw const _process_stack_start, thread) }
}

extern "C" fn thread() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let Some(executor) = EXECUTOR.try_init(Executor::new(core::ptr::null_mut())) else {
        hang()
    };
    let executor: &'static Executor = executor;
    start(executor.spawner());
    loop {
        // SAFETY: nothing else polls it.
        unsafe { executor.poll() };
        sleep();
    }
}

/// Waits for an interrupt or a woken task. The crate's own executor leaves out the barrier: without it the chip may fetch a wrong
/// instruction as it wakes while debugging in sleep is on, as the driver and the probe set it (errata sheet ES0431, as ES0430 2.2.8).
fn sleep() {
    cortex_m::asm::wfe();
    cortex_m::asm::isb();
}

/// Where the start cannot go on, which the watchdog ends: room that this alone takes is taken, or what the scene says of a sensor does not
/// fit the board. It returns to nobody, so nothing that is set up is taken down.
#[cold]
fn hang() -> ! {
    loop {
        sleep();
    }
}

/// Ends the sleep: how the executor is told that a task was woken.
#[unsafe(export_name = "__pender")]
extern "Rust" fn wake(_context: *mut ()) {
    cortex_m::asm::sev();
}

/// Each task is spawned once, so that there is room for it. If there were none: without sensing, sequence or supervisor the
/// watchdog resets the chip.
fn spawn<S>(spawner: Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    if let Ok(task) = task {
        spawner.spawn(task);
    }
}

/// Brings the chip up: what the last run left, what was kept in flash, the bridge (off), then the tasks.
fn start(spawner: Spawner) {
    let mut p = clock::start();
    // First of all: whatever hangs from here on ends in a reset. The tasks feed it some 25 ms later at most.
    let watchdog = watchdog::Watchdog::start(p.IWDG);
    let source = clock::speed_up(&mut p.RCC);
    interrupt::TIM2.set_priority(Priority::P8);
    interrupt::LPUART1.set_priority(Priority::P10);
    Telemetry.boot(env!("CARGO_PKG_VERSION"), Active::NAME);
    if source == clock::Source::Internal {
        Telemetry.clock("internal");
    }
    let (reset, mut fault) = restart::report();

    let bridge = bridge::Bridge::new(
        p.TIM1,
        bridge::Pins {
            enable: p.PA8,
            phase: p.PA9,
            sleep: p.PB5,
            fault: p.PB10,
        },
    );
    let encoder = encoder::Encoder::new(p.TIM3, p.PA6, p.PA7);
    let mut sampling = sampling::Sampling::new(p.ADC1, p.PA1, p.PC0);
    if Joint::FITTED {
        sampling.start_joint(p.ADC2, p.PC1);
    }
    let led = indicator::Led::new(p.PA5);
    let button = indicator::Button::new(p.PC13);

    let Some(sensing) = sensing() else { hang() };
    let mut storage = Store::new(storage::Region::new(p.FLASH));
    let mut overrides = Overrides::default();
    let mut identified = None;
    match execute::load(&mut storage, sensing) {
        Loaded::Nothing => {}
        Loaded::Unusable => fault = fault.or(Some(Fault::BadRecord)),
        Loaded::Restored {
            overrides: set,
            identified: measured,
            notice,
        } => {
            (overrides, identified) = (set, measured);
            // There is room for this one, and for the two below.
            let _ = tasks::NOTICES.try_send(notice);
        }
    }
    let chip = control::Chip {
        bridge,
        encoder,
        sampling,
    };
    let (samples, coordinator) = launch(chip, reset, sensing, overrides, identified, &mut fault);
    if let Some(fault) = fault {
        let _ = tasks::NOTICES.try_send(Notice::Fault(fault));
    }
    let Some((sender, receiver)) = serial::open(p.LPUART1, p.PA2, p.PA3) else {
        hang()
    };
    spawn(spawner, watchdog::supervise(watchdog));
    spawn(spawner, console::listen_rtt());
    spawn(spawner, console::listen_serial(receiver));
    let application = Application {
        sensing,
        coordinator,
    };
    spawn(spawner, tasks::sense(samples, application));
    spawn(spawner, tasks::sequence(led, button, application));
    spawn(spawner, execute::execute(sender, storage, application));
}

/// The sensing half, made in its place: it is as large as half the stack. Apart from [`start`], so that what makes it lies on the stack for
/// the moment only; so does [`launch`].
#[inline(never)]
fn sensing() -> Option<&'static Shared<ContactSensing<Active>>> {
    static SENSING: StaticCell<Shared<ContactSensing<Active>>> = StaticCell::new();
    SENSING
        .try_init_with(|| Shared::new(ContactSensing::new()))
        .map(|sensing| &*sensing)
}

/// Starts the control interrupt and makes the motion half, with what the user has set. Where that no longer fits the scene
/// there is a fault, and the scene's own values are in force, in the sensing as well; where joint 2's sensor does not fit the board,
/// nothing can move.
#[inline(never)]
fn launch(
    chip: control::Chip,
    reset: Reset,
    sensing: &Shared<ContactSensing<Active>>,
    set: Overrides,
    identified: Option<Identified>,
    fault: &mut Option<Fault>,
) -> (control::Samples, &'static Shared<Coordinator<Active>>) {
    static COORDINATOR: StaticCell<Shared<Coordinator<Active>>> = StaticCell::new();
    let Ok(joint) = Active::joint_sensor().inspect_err(bad_configuration) else {
        hang()
    };
    let (drive, set) = match drive::<Active>(&set, identified.as_ref()) {
        Ok(drive) => (drive, set),
        Err(wrong) => {
            bad_configuration(&wrong);
            *fault = fault.or(Some(Fault::BadConfiguration));
            // The sensing took the refused ones with the record, and friction recorded at their speed.
            let scenes = Overrides::default();
            sensing.with(|sensing| sensing.request(SensingRequest::Adjust(scenes)));
            let _ = tasks::NOTICES.try_send(Notice::FrictionUnknown);
            (Active::CHECKED, scenes)
        }
    };
    let presses = sensing.with(|sensing| sensing.calibration().presses);
    let mut coordinator = Coordinator::new(set, presses);
    if let Some(identified) = identified {
        coordinator.set_identified(identified);
    }
    let Some(coordinator) = COORDINATOR.try_init(Shared::new(coordinator)) else {
        hang()
    };
    selftest::limits_in_force(&drive.config().limits);
    let controller = controller(&drive, reset);
    let Some(samples) = control::start(chip, controller, joint) else {
        hang()
    };
    (samples, coordinator)
}

// Not inlined: it is moved as a whole then, not field by field.
#[inline(never)]
fn controller(drive: &CheckedConfig, reset: Reset) -> Controller {
    Controller::at(drive, thermal::initial(reset, drive.config()))
}

fn bad_configuration(wrong: &OutOfRange) {
    Telemetry.bad_configuration(wrong.name, wrong.value, wrong.min, wrong.max);
}
