//! The H-bridge: TIM1 makes EN on PA8 (PH/EN mode), PA9 is PH, PB5 is nSLEEP, PB10 is nFAULT and stops the timer's
//! outputs in hardware.

use core::mem::{MaybeUninit, forget};
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::gpio::vals::{Idr, Odr};
use embassy_stm32::pac::timer::vals::{Bkinp, Bkp, Mms2, Ossi, Ossr};
use embassy_stm32::pac::{DBGMCU, GPIOA, GPIOB, RCC, SYSCFG, TIM1};
use embassy_stm32::peripherals::{PA8, PA9, PB5, PB10};
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::low_level::{CountingMode, FilterValue, OutputCompareMode, Timer};
use embassy_stm32::timer::simple_pwm::PwmPin;

use palpate::drive::io::{CONTROL_HZ, DUTY_FULL, Direction, Outputs, PWM_HZ};

/// Pins of the bridge.
pub struct Pins {
    /// EN.
    pub enable: Peri<'static, PA8>,
    /// PH.
    pub phase: Peri<'static, PA9>,
    /// nSLEEP.
    pub sleep: Peri<'static, PB5>,
    /// nFAULT.
    pub fault: Peri<'static, PB10>,
}

const PHASE_PIN: usize = 9;
const SLEEP_PIN: usize = 5;
const FAULT_PIN: usize = 10;

/// Centre-aligned counting makes two update events a PWM period; the repetition counter lets through one a control
/// period: five PWM periods.
const REPETITION: u16 = (2 * PWM_HZ / CONTROL_HZ - 1) as u16;

/// Whether the bridge was on, in RAM that survives a reset: a reset by a dip of the supply leaves no other trace.
#[unsafe(link_section = ".uninit.live")]
static LIVE: MaybeUninit<AtomicU32> = MaybeUninit::uninit();
const LIVE_MARK: u32 = 0x11FE_B41D;

fn live() -> &'static AtomicU32 {
    // SAFETY: any bits are a value of this type.
    unsafe { LIVE.assume_init_ref() }
}

/// Whether the last run ended with the bridge on. Call once, before the bridge is set up.
pub fn take_was_live() -> bool {
    live().swap(0, Ordering::Relaxed) == LIVE_MARK
}

/// The bridge, armed or not. It belongs to the control interrupt.
pub struct Bridge {
    armed: bool,
}

impl Bridge {
    /// Sets up timer, pins and break with the outputs off. The timer stands still until [`start`].
    pub fn new(tim1: Peri<'static, embassy_stm32::peripherals::TIM1>, pins: Pins) -> Self {
        // Asleep and EN low before the timer gets the pin.
        forget(Output::new(pins.sleep, Level::Low, Speed::Low));
        forget(Output::new(pins.phase, Level::Low, Speed::Low));

        // TIM1_BKIN has no driver: alternate function 12, pulled up because nFAULT is open drain.
        let mut fault = Flex::new(pins.fault);
        fault.set_as_af_unchecked(12, AfType::input(Pull::Up));
        forget(fault);

        // The complementary PWM driver would enable the outputs in its constructor: the low-level driver does not.
        let timer = Timer::new(tim1);
        timer.set_counting_mode(CountingMode::CenterAlignedBothInterrupts);
        timer.set_max_compare_value(DUTY_FULL);
        timer.set_autoreload_preload(true);
        // Written before the counter starts: the update then falls on the counter's zero, the middle of the on-time.
        timer.set_repetition_counter(REPETITION);
        timer.set_output_compare_mode(Channel::Ch1, OutputCompareMode::PwmMode1);
        timer.set_output_compare_preload(Channel::Ch1, true);
        timer.set_compare_value(Channel::Ch1, 0);
        timer.set_mms2_selection(Mms2::UPDATE);

        // Break: nFAULT low for 8 timer clocks (47 ns), or the core locked up, or flash with two wrong bits. Off means
        // driven low, not floating, and only software re-enables (AOE stays clear).
        TIM1.af1().modify(|w| {
            w.set_bkine(true);
            w.set_bkinp(Bkinp::NOT_INVERTED);
        });
        TIM1.bdtr().modify(|w| {
            w.set_moe(false);
            w.set_aoe(false);
            w.set_ossi(Ossi::IDLE_LEVEL);
            w.set_ossr(Ossr::IDLE_LEVEL);
            w.set_bkp(0, Bkp::ACTIVE_LOW);
            w.set_bkf(0, FilterValue::FCK_INT_N8);
        });
        TIM1.bdtr().modify(|w| w.set_bke(0, true));
        // A debugger that halts the core stops the timer and with it the outputs.
        DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
        RCC.apb2enr().modify(|w| w.set_syscfgen(true));
        SYSCFG.cfgr2().modify(|w| {
            w.set_cll(true);
            w.set_eccl(true);
        });

        forget(PwmPin::new(pins.enable, OutputType::PushPull));
        timer.enable_channel(Channel::Ch1, true);
        timer.generate_update_event();
        forget(timer);
        Self { armed: false }
    }

    /// Whether the bridge reports a fault, or the break latched since the bridge was last switched on.
    pub fn fault(&self) -> bool {
        let pin_low = GPIOB.idr().read().idr(FAULT_PIN) == Idr::LOW;
        // Both registers in any case: cheaper than to branch.
        pin_low | (self.armed & !TIM1.bdtr().read().moe())
    }

    /// Does what the controller decided. Straight register writes: nothing here can fail or wait.
    pub fn apply(&mut self, outputs: Outputs) {
        match outputs {
            Outputs::Off => {
                off();
                self.armed = false;
            }
            Outputs::Brake => {
                TIM1.ccr(0).write(|w| w.set_ccr(0));
                self.arm();
            }
            Outputs::Drive { direction, duty } => {
                set(GPIOA, PHASE_PIN, direction == Direction::Closing);
                // Any value above the counter's range is full duty too.
                TIM1.ccr(0).write(|w| w.set_ccr(duty.0));
                self.arm();
            }
        }
    }

    /// Wakes the bridge and enables the timer's outputs, once: a break that comes later stays in force until the
    /// controller has asked for [`Outputs::Off`].
    #[inline(always)]
    fn arm(&mut self) {
        if self.armed {
            return;
        }
        self.armed = true;
        live().store(LIVE_MARK, Ordering::Relaxed);
        set(GPIOB, SLEEP_PIN, true);
        // Status bits are cleared by writing zero; ones leave the others alone.
        TIM1.sr().write(|w| {
            w.0 = u32::MAX;
            w.set_bif(0, false);
        });
        TIM1.bdtr().modify(|w| w.set_moe(true));
    }
}

/// Starts the timer, and with it the control interrupt.
pub fn start() {
    TIM1.cr1().modify(|w| w.set_cen(true));
}

/// Bridge off: outputs disabled, compare value zero, asleep. Register writes that cannot fail, allowed anywhere, also
/// before [`Bridge::new`] and from a fault handler. The control interrupt, which runs from a memory of its own, has a copy; so
/// it has of what else is `inline(always)` here.
#[inline(always)]
pub fn off() {
    TIM1.bdtr().modify(|w| w.set_moe(false));
    TIM1.ccr(0).write(|w| w.set_ccr(0));
    set(GPIOB, SLEEP_PIN, false);
    live().store(0, Ordering::Relaxed);
}

/// Outputs disabled and bridge asleep, as the registers have it.
pub fn is_off() -> bool {
    !TIM1.bdtr().read().moe() && GPIOB.odr().read().odr(SLEEP_PIN) == Odr::LOW
}

/// One pin through the set/reset register: no read, no lost update of its neighbours.
#[inline(always)]
fn set(port: embassy_stm32::pac::gpio::Gpio, pin: usize, high: bool) {
    // The lower half of the register sets, the upper resets.
    let bit = 1 << pin;
    port.bsrr()
        .write(|w| w.0 = if high { bit } else { bit << 16 });
}
