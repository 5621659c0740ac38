//! The H-bridge: TIM1 makes EN on PA8 (PH/EN mode), PA9 is PH, PB5 is nSLEEP, PB10 is nFAULT and stops the timer's
//! outputs in hardware.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::pac::gpio::vals::{Odr, Ospeedr};
use embassy_stm32::pac::timer::vals::{Bkinp, Bkp, Cms, FilterValue, Mms2, Ocm, Ossi, Ossr};
use embassy_stm32::pac::{DBGMCU, GPIOA, GPIOB, RCC, SYSCFG, TIM1};
use embassy_stm32::peripherals::{PA8, PA9, PB5, PB10};
use embassy_stm32::{Peri, peripherals};

use palpate::drive::io::{CONTROL_HZ, DUTY_FULL, Direction, Outputs, PWM_HZ};

use super::clock;
use super::pins::{self, Use};

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

const ENABLE_PIN: usize = 8;
const PHASE_PIN: usize = 9;
const SLEEP_PIN: usize = 5;
const FAULT_PIN: usize = 10;
/// TIM1_CH1 on PA8, TIM1_BKIN on PB10.
const CHANNEL: Use = Use::function(6);
const BREAK: Use = Use::function(12);

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
    pub fn new(_tim1: Peri<'static, peripherals::TIM1>, pins: Pins) -> Self {
        // Asleep and EN low before the timer gets the pin.
        pins::write(GPIOB, SLEEP_PIN, false);
        pins::set_up(pins.sleep, Use::OUTPUT);
        pins::write(GPIOA, PHASE_PIN, false);
        pins::set_up(pins.phase, Use::OUTPUT);
        // nFAULT is open drain.
        pins::set_up(pins.fault, BREAK.pulled_up());

        RCC.apb2enr().modify(|w| {
            w.set_tim1en(true);
            w.set_syscfgen(true);
        });
        clock::settle();
        TIM1.cr1().write(|w| {
            // Both at the top and at zero there is an update, as far as the repetition counter lets it through.
            w.set_cms(Cms::CENTER_ALIGNED3);
            w.set_arpe(true);
        });
        TIM1.arr().write(|w| w.set_arr(DUTY_FULL));
        // Written before the counter starts: the update then falls on the counter's zero, the middle of the on-time.
        TIM1.rcr().write(|w| w.set_rep(REPETITION));
        TIM1.ccmr_output(0).write(|w| {
            w.set_ocm(0, Ocm::PWM_MODE1);
            w.set_ocpe(0, true);
        });
        TIM1.ccr(0).write(|w| w.set_ccr(0));
        TIM1.cr2().write(|w| w.set_mms2(Mms2::UPDATE));

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
        SYSCFG.cfgr2().modify(|w| {
            w.set_cll(true);
            w.set_eccl(true);
        });

        // Steep edges: a PWM step is 12 ns.
        GPIOA
            .ospeedr()
            .modify(|w| w.set_ospeedr(ENABLE_PIN, Ospeedr::VERY_HIGH_SPEED));
        pins::set_up(pins.enable, CHANNEL);
        TIM1.ccer().write(|w| w.set_cce(0, true));
        // Takes over what was written so far.
        TIM1.egr().write(|w| w.set_ug(true));
        Self { armed: false }
    }

    /// Whether the bridge reports a fault, or the break latched since the bridge was last switched on.
    pub fn fault(&self) -> bool {
        let pin_low = !pins::is_high(GPIOB, FAULT_PIN);
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
                pins::write(GPIOA, PHASE_PIN, direction == Direction::Closing);
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
        pins::write(GPIOB, SLEEP_PIN, true);
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
/// it has of what else is `inline(always)` here and in [`pins`].
#[inline(always)]
pub fn off() {
    TIM1.bdtr().modify(|w| w.set_moe(false));
    TIM1.ccr(0).write(|w| w.set_ccr(0));
    pins::write(GPIOB, SLEEP_PIN, false);
    live().store(0, Ordering::Relaxed);
}

/// Outputs disabled and bridge asleep, as the registers have it.
pub fn is_off() -> bool {
    !TIM1.bdtr().read().moe() && GPIOB.odr().read().odr(SLEEP_PIN) == Odr::LOW
}
