//! The H-bridge: TIM1 makes EN on PA8 (PH/EN mode), PA9 is PH, PB5 is nSLEEP, PB10 is nFAULT and stops the timer's
//! outputs in hardware.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Idr, Odr, Pupdr};
use embassy_stm32::pac::timer::vals::{Bkp, FilterValue, Lock, Mms2, Ossi, Ossr};
use embassy_stm32::pac::{DBGMCU, GPIOA, GPIOB, SYSCFG, TIM1};
use embassy_stm32::peripherals::{self, PA8, PA9, PB5, PB10};
use embassy_stm32::timer::low_level::{CountingMode, OutputCompareMode, Timer};
use embassy_stm32::timer::simple_pwm::{PwmPin, PwmPinConfig};
use embassy_stm32::timer::{Ch1, Channel};

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
/// TIM1_BKIN on PB10, as the data sheet numbers alternate functions.
const BREAK_FUNCTION: u8 = 12;

/// For a level to settle and pass the break's filter, core clock cycles: 10 us.
const TEST_CYCLES: u32 = 1700;

/// Centre-aligned counting makes two update events a PWM period; the repetition counter lets through one a control
/// period: five PWM periods.
const REPETITION: u16 = (2 * PWM_HZ / CONTROL_HZ - 1) as u16;

/// Whether the bridge was on or a fault latched, in RAM that survives a reset: a reset by a dip of the supply leaves no other
/// trace, and nothing may move before `clear` then.
#[unsafe(link_section = ".uninit.live")]
static LIVE: MaybeUninit<AtomicU32> = MaybeUninit::uninit();
const LIVE_MARK: u32 = 0x11FE_B41D;

fn live() -> &'static AtomicU32 {
    // SAFETY: any bits are a value of this type.
    unsafe { LIVE.assume_init_ref() }
}

/// Keeps whether a reset from now on has to be cleared before anything moves: before the bridge is switched on, and as long as it
/// is on or a fault is latched.
pub fn keep_live(is_live: bool) {
    live().store(if is_live { LIVE_MARK } else { 0 }, Ordering::Relaxed);
}

/// Whether the last run ended so. Ask before the sequence runs, which keeps its own.
pub fn was_live() -> bool {
    live().load(Ordering::Relaxed) == LIVE_MARK
}

/// The bridge, armed or not. It belongs to the control interrupt.
pub struct Bridge {
    armed: bool,
    /// Dropping a driver would disconnect its pin or stop the timer. The interrupt writes registers.
    _timer: Timer<'static, peripherals::TIM1>,
    _enable: PwmPin<'static, peripherals::TIM1, Ch1>,
    _levels: [Output<'static>; 2],
    _fault: Flex<'static>,
}

impl Bridge {
    /// Sets up timer, pins and break with the outputs off. The timer stands still until [`start`].
    pub fn new(timer: Peri<'static, peripherals::TIM1>, pins: Pins) -> Self {
        // Asleep and EN low before the timer gets the pin.
        let sleep = Output::new(pins.sleep, Level::Low, Speed::Low);
        let phase = Output::new(pins.phase, Level::Low, Speed::Low);
        // By number: the driver's break pin has no pull. nFAULT is open drain.
        let mut fault = Flex::new(pins.fault);
        fault.set_as_af_unchecked(BREAK_FUNCTION, AfType::input(Pull::Up));

        let timer = Timer::new(timer);
        // Both at the top and at zero there is an update, as far as the repetition counter lets it through.
        timer.set_counting_mode(CountingMode::CenterAlignedBothInterrupts);
        timer.set_autoreload_preload(true);
        // By register, as a period in counts: the driver takes a frequency, and rounds.
        TIM1.arr().write(|w| w.set_arr(DUTY_FULL));
        // Written before the counter starts: the update then falls on the counter's zero, the middle of the on-time.
        timer.set_repetition_counter(REPETITION);
        timer.set_output_compare_mode(Channel::Ch1, OutputCompareMode::PwmMode1);
        timer.set_output_compare_preload(Channel::Ch1, true);
        timer.set_compare_value(Channel::Ch1, 0);
        timer.set_mms2_selection(Mms2::UPDATE);

        // Break: nFAULT low for 8 samples at 170 MHz / 16 (0.75 us: shorter pulses on a jumper wire next to the motor's leads
        // are noise), or the core locked up, or flash with two wrong bits. Off means driven low, not floating, and only
        // software re-enables.
        timer.set_moe(false);
        timer.set_automatic_output_enable(false);
        timer.set_ossi(Ossi::IDLE_LEVEL);
        timer.set_ossr(Ossr::IDLE_LEVEL);
        timer.set_break_input_pin_enable(true);
        timer.set_break_polarity(Bkp::ACTIVE_LOW);
        timer.set_break_filter(FilterValue::FDTS_DIV16_N8);
        // Enable the break and, which no driver does, lock its settings and the outputs' idle levels until the next reset: no stray store can
        // disable it then.
        TIM1.bdtr().modify(|w| {
            w.set_bke(0, true);
            w.set_lock(Lock::LEVEL1);
        });
        // By register, as no driver has them. A debugger that halts the core stops the timer and with it the outputs.
        DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
        SYSCFG.cfgr2().modify(|w| {
            w.set_cll(true);
            w.set_eccl(true);
        });

        // Slow edges (25 ns, M), as on the other wires to the bridge: fast ones ring on a jumper wire, next to the encoder's and A1.
        let config = PwmPinConfig {
            output_type: OutputType::PushPull,
            speed: Speed::Low,
            pull: Pull::None,
        };
        let enable = PwmPin::new_with_config(pins.enable, config);
        timer.enable_channel(Channel::Ch1, true);
        // Takes over what was written so far.
        timer.generate_update_event();
        Self {
            armed: false,
            _timer: timer,
            _enable: enable,
            _levels: [sleep, phase],
            _fault: fault,
        }
    }

    /// Whether the bridge reports a fault. Since it was last switched on the break tells, which latches and has a filter: a single sample
    /// of a pin next to the motor's leads may be noise. Before, when nothing switches, the pin itself.
    pub fn fault(&self) -> bool {
        if self.armed {
            !TIM1.bdtr().read().moe()
        } else {
            !is_high(GPIOB, FAULT_PIN)
        }
    }

    /// Does what the controller decided. Straight register writes: nothing here can fail or wait.
    pub fn apply(&mut self, outputs: Outputs) {
        match outputs {
            Outputs::Off => {
                off();
                self.armed = false;
            }
            // The timer's outputs stay off.
            Outputs::Wake => write(GPIOB, SLEEP_PIN, true),
            Outputs::Brake => {
                TIM1.ccr(0).write(|w| w.set_ccr(0));
                self.arm();
            }
            Outputs::Drive { direction, duty } => {
                write(GPIOA, PHASE_PIN, direction == Direction::Closing);
                // Any value above the counter's range is full duty too.
                TIM1.ccr(0).write(|w| w.set_ccr(duty.0));
                self.arm();
            }
        }
    }

    /// Enables the timer's outputs, once: a break that comes later stays in force until the controller has asked for
    /// [`Outputs::Off`]. The controller has let the bridge wake up and found nFAULT high.
    fn arm(&mut self) {
        if self.armed {
            return;
        }
        self.armed = true;
        clear_breaks();
        TIM1.bdtr().modify(|w| w.set_moe(true));
    }
}

/// Starts the timer, and with it the control interrupt.
pub fn start() {
    TIM1.cr1().modify(|w| w.set_cen(true));
}

/// Bridge off: outputs disabled, compare value zero, asleep. Register writes that cannot fail, allowed anywhere, also
/// before [`Bridge::new`] and from a fault handler.
pub fn off() {
    TIM1.bdtr().modify(|w| w.set_moe(false));
    TIM1.ccr(0).write(|w| w.set_ccr(0));
    write(GPIOB, SLEEP_PIN, false);
}

/// Outputs disabled and bridge asleep, as the registers have it.
pub fn is_off() -> bool {
    !TIM1.bdtr().read().moe() && GPIOB.odr().read().odr(SLEEP_PIN) == Odr::LOW
}

/// nFAULT is high.
pub fn fault_pin_is_high() -> bool {
    is_high(GPIOB, FAULT_PIN)
}

/// Whether a low nFAULT switches the timer's outputs off: pulls the pin down by the chip's own resistor, with the outputs
/// enabled at zero duty and the bridge asleep. Call with the bridge off and the control interrupt masked.
pub fn break_cuts_outputs() -> bool {
    let pull = |pull| GPIOB.pupdr().modify(|w| w.set_pupdr(FAULT_PIN, pull));
    TIM1.ccr(0).write(|w| w.set_ccr(0));
    clear_breaks();
    TIM1.bdtr().modify(|w| w.set_moe(true));
    // MOE reads back late after it was set (BDTR of RM0440), and it must stay set while the pin is high.
    cortex_m::asm::delay(TEST_CYCLES);
    let enabled = TIM1.bdtr().read().moe();
    pull(Pupdr::PULL_DOWN);
    // 40 kohm and some 50 pF: 2 us, and the filter.
    cortex_m::asm::delay(TEST_CYCLES);
    let cut = !TIM1.bdtr().read().moe();
    TIM1.bdtr().modify(|w| w.set_moe(false));
    pull(Pupdr::PULL_UP);
    cortex_m::asm::delay(TEST_CYCLES);
    clear_breaks();
    enabled && cut
}

/// Of either break: while the flag of one stands, the outputs cannot be enabled (TIMx_SR of RM0440, SBIF). The system break's
/// stands after a start that read a torn word of flash.
fn clear_breaks() {
    // Status bits are cleared by writing zero; ones leave the others alone.
    TIM1.sr().write(|w| {
        w.0 = u32::MAX;
        w.set_bif(0, false);
        w.set_sbif(false);
    });
}

/// One pin's level through the set/reset register: no read, no lost update of its neighbours.
fn write(port: Gpio, pin: usize, high: bool) {
    // The lower half of the register sets, the upper resets.
    let bit = 1 << pin;
    port.bsrr()
        .write(|w| w.0 = if high { bit } else { bit << 16 });
}

/// The level at a pin.
fn is_high(port: Gpio, pin: usize) -> bool {
    port.idr().read().idr(pin) == Idr::HIGH
}
