//! Runs the self-test: moves the motor by the steps of [`palpate::app::selftest`] and reports each.

use core::fmt::Write;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::usart::BufferedUartTx;
use embassy_time::{Duration, Ticker};

use crate::scene::Active;
use palpate::app::console::text::{Answer, Decimal, Plain};
use palpate::app::log::Log;
use palpate::app::selftest::{
    ExpectedRange, Measurement, SETTLE_MS, SelfTestStep, TRAVEL_RAD, remedy,
};
use palpate::drive::config::Limits;
use palpate::drive::{Setpoint, Status};
use palpate::scene::Scene;

use super::execute::Application;
use super::telemetry::Telemetry;
use super::{bridge, console, control};

/// Bits of the supply's limits in force, volt: those that a user sets meanwhile wait for a restart.
static SUPPLY_V: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];

/// Keeps the supply's limits that the control interrupt starts with, for the self-test.
pub fn limits_in_force(limits: &Limits) {
    SUPPLY_V[0].store(limits.supply_min_v.to_bits(), Ordering::Relaxed);
    SUPPLY_V[1].store(limits.supply_max_v.to_bits(), Ordering::Relaxed);
}

/// What a step of the self-test must measure on this board.
// Not inlined: called from two places.
#[inline(never)]
fn expected(step: SelfTestStep) -> ExpectedRange {
    let limit_v = |at: usize| f32::from_bits(SUPPLY_V[at].load(Ordering::Relaxed));
    let signed = Active::CHECKED.config().sense.signed;
    ExpectedRange::of(step, limit_v(0), limit_v(1), signed)
}

/// The step could not be carried out: the test was stopped, or a fault has ended it.
struct Ended;

impl Application {
    /// Runs the self-test; each step is reported on both sides, the result is the answer.
    pub async fn selftest(self, port: &mut BufferedUartTx<'static>, answer: &mut Answer) {
        let result = self.steps(port).await;
        self.coordinator.with(|coordinator| coordinator.end_test());
        let (how, step) = match result {
            Ok(None) => ("passed", ""),
            Ok(Some(step)) => ("failed at ", step.name()),
            Err(Ended) => ("stopped", ""),
        };
        let _ = write!(answer, "selftest {}{}", Plain(how), Plain(step));
    }

    /// The first step that failed, which ends the test unless its value [may miss](ExpectedRange::may_miss) the range; an error where the
    /// user stopped it.
    async fn steps(
        self,
        port: &mut BufferedUartTx<'static>,
    ) -> Result<Option<SelfTestStep>, Ended> {
        let mut measurement = Measurement::new(Active::CHECKED.scale().counts(TRAVEL_RAD));
        let mut failed = None;
        for step in SelfTestStep::ALL {
            let value = self.measure(step, &mut measurement).await;
            let value = value.unwrap_or(f32::NAN);
            let mut told = step;
            let mut wanted = expected(step);
            let passed = wanted.contains(value);
            let fault = (control::status().fault)
                .or_else(|| self.coordinator.with(|coordinator| coordinator.fault()));
            if !passed {
                if fault.is_none() {
                    // Where the user has stopped the test no part is to blame.
                    self.ask(Setpoint::Off)?;
                }
                // A fault may belong to another step than the one in which it was detected.
                told = fault.and_then(SelfTestStep::of_fault).unwrap_or(step);
                wanted = expected(told);
            }
            let remedy = (!passed).then(|| remedy(told, value, &wanted, fault));
            self.report_step(port, told, value, &wanted, remedy).await;
            if !passed {
                failed = failed.or(Some(told));
                if !wanted.may_miss(value) || fault.is_some() {
                    break;
                }
            }
        }
        Ok(failed)
    }

    async fn report_step(
        self,
        port: &mut BufferedUartTx<'static>,
        step: SelfTestStep,
        value: f32,
        wanted: &ExpectedRange,
        remedy: Option<&'static str>,
    ) {
        let mut want = Answer::new();
        // Every range fits.
        let _ = write!(want, "{wanted}");
        let (result, remedy) = remedy.map_or(("ok", "none"), |remedy| ("failed", remedy));
        let name = step.name();
        Telemetry.selftest(name, result, value, &want, remedy);
        let mut text = Answer::new();
        let _ = write!(
            text,
            "selftest step={} result={} value={} want={wanted} remedy=",
            Plain(name),
            Plain(result),
            Decimal(value)
        );
        for piece in [text.as_str(), remedy, "\r\n"] {
            console::send(port, piece).await;
        }
    }

    /// Asks for something of the motor.
    fn ask(self, setpoint: Setpoint) -> Result<(), Ended> {
        let asked = self
            .coordinator
            .with(|coordinator| coordinator.set_test(setpoint));
        // A fault ends the test with the sequence's next step; the controller has switched off already.
        match control::status().fault {
            None if asked => Ok(()),
            _ => Err(Ended),
        }
    }

    /// Carries a step out; its value.
    async fn measure(
        self,
        step: SelfTestStep,
        measurement: &mut Measurement,
    ) -> Result<f32, Ended> {
        for _ in 0..Measurement::asks(step) {
            let (setpoint, most_ms) = measurement.ask(step, &control::status());
            let asked = self
                .ask_until(setpoint, most_ms, &mut |ms, status| {
                    measurement.take(step, ms, status)
                })
                .await;
            if Measurement::moves(step) {
                // Whatever came of it.
                let _ = self
                    .ask_until(Setpoint::Brake, SETTLE_MS, &mut |_, _| false)
                    .await;
            }
            asked?;
        }
        Ok(match step {
            // Whether nFAULT is high once the bridge is awake.
            SelfTestStep::Wake => {
                level(self.ask(Setpoint::Off).is_ok() && bridge::fault_pin_is_high())
            }
            // Whether a low nFAULT cuts the outputs, with the bridge asleep.
            SelfTestStep::BreakInput => {
                let _pause = control::pause();
                level(bridge::is_off() && bridge::break_cuts_outputs())
            }
            _ => measurement.value(step, &control::status()),
        })
    }

    /// Asks for the same every millisecond, until `done` says so of the status after it, or for `most_ms`.
    // By reference: all steps share one state machine.
    async fn ask_until(
        self,
        setpoint: Setpoint,
        most_ms: u32,
        done: &mut dyn FnMut(u32, &Status) -> bool,
    ) -> Result<(), Ended> {
        let mut ticker = Ticker::every(Duration::from_millis(1));
        for ms in 0..most_ms {
            self.ask(setpoint)?;
            ticker.next().await;
            if done(ms, &control::status()) {
                break;
            }
        }
        Ok(())
    }
}

/// 1 for yes.
fn level(yes: bool) -> f32 {
    f32::from(u8::from(yes))
}
