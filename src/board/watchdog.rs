//! The independent watchdog, fed only when the control interrupt, the sensing task and the sequence task have all
//! reported since the last feed.
//!
//! Budget. The watchdog counts the LSI, 29.5 to 34 kHz over temperature and supply (datasheet), nominally 32 kHz. Set to
//! 100 ms nominal it resets the chip after 94 to 108.5 ms. Feeds come every 10 ms; the longest planned stalls are
//! the erasure of a flash page and the writing of another, 25 ms each at most, with the bridge off and a pause between that holds a
//! feed. The wake that an operation delayed finds no reports, so up to 10 + 25 + 10 ms lie between two feeds: a factor of 2.1 to the
//! earliest bite. The other way round: a task that hangs with the motor live is reset after at most
//! 10 ms (its last report may be that old) + 108.5 ms.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::pac::{DBGMCU, IWDG};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, peripherals};
use embassy_time::{Duration, Ticker};

/// Nominal time from the last feed to the reset.
const TIMEOUT_US: u32 = 100_000;
/// How often feeding is considered.
const PERIOD: Duration = Duration::from_millis(10);

/// Who has to report.
#[derive(Clone, Copy)]
#[repr(u32)]
pub enum Reporter {
    /// The control interrupt.
    Control = 1,
    /// The sensing task.
    Sensing = 2,
    /// The sequence task.
    Sequence = 4,
}

const ALL: u32 = 7;
/// Marks a word that this program wrote, against what RAM holds after power-up.
const MARK: u32 = 0x5EED_F0A0;

/// Reports since the last feed; survives a reset, so that the next boot can tell who was missing.
#[unsafe(link_section = ".uninit.reports")]
static REPORTS: MaybeUninit<AtomicU32> = MaybeUninit::uninit();

fn reports() -> &'static AtomicU32 {
    // SAFETY: any bits are a value of this type.
    unsafe { REPORTS.assume_init_ref() }
}

/// Who had not reported when the watchdog bit.
#[derive(Clone, Copy)]
pub struct Missing {
    /// The control interrupt.
    pub control: bool,
    /// The sensing task.
    pub sensing: bool,
    /// The sequence task.
    pub sequence: bool,
}

/// Reports. Callable from the control interrupt: the highest priority is never interrupted in its read-modify-write.
pub fn report(who: Reporter) {
    reports().fetch_or(who as u32, Ordering::Relaxed);
}

/// Reads what the last run left and starts afresh. Call once, before anything reports.
pub fn take_reports() -> Option<Missing> {
    let reports = reports().swap(MARK, Ordering::Relaxed);
    let missing = |who: Reporter| reports & who as u32 == 0;
    (reports & !ALL == MARK).then(|| Missing {
        control: missing(Reporter::Control),
        sensing: missing(Reporter::Sensing),
        sequence: missing(Reporter::Sequence),
    })
}

/// The watchdog. Once started, nothing but a reset stops it, except a debugger that halts the core.
pub struct Watchdog(IndependentWatchdog<'static, peripherals::IWDG>);

impl Watchdog {
    /// Starts it.
    pub fn start(iwdg: Peri<'static, peripherals::IWDG>) -> Self {
        // By register: the driver neither stops the counter with the core nor waits for its values to reach the LSI's side.
        // The tasks' clock stops with the core too: its driver counts half turns of the timer, and would miss some.
        DBGMCU.apb1lfzr().modify(|w| {
            w.set_iwdg(true);
            w.set_tim2(true);
        });
        let mut watchdog = IndependentWatchdog::new(iwdg, TIMEOUT_US);
        watchdog.unleash();
        while IWDG.sr().read().0 != 0 {}
        watchdog.pet();
        Self(watchdog)
    }
}

/// Feeds it, on the conditions above.
#[embassy_executor::task]
pub async fn supervise(mut watchdog: Watchdog) {
    let mut ticker = Ticker::every(PERIOD);
    loop {
        ticker.next().await;
        if reports().load(Ordering::Relaxed) & ALL == ALL {
            reports().fetch_and(!ALL, Ordering::Relaxed);
            watchdog.0.pet();
        }
    }
}
