//! Runs the self-test: moves the motor by the steps of [`palpate::app::selftest`] and reports each.

use core::fmt::Write;

use embassy_stm32::usart::BufferedUartTx;
use embassy_time::{Duration, Ticker};

use crate::scene::Active;
use palpate::app::console::settings::Setting;
use palpate::app::console::text::{Answer, Decimal};
use palpate::app::log::Log;
use palpate::app::selftest::{
    DRIVEN_A, ENCODER_COUNTS, Step, TRAVEL_RAD, TRAVEL_RAD_PER_S, Wanted, remedy,
};
use palpate::drive::{OffsetState, Setpoint, Status};
use palpate::scene::Scene;

use super::execute::Application;
use super::telemetry::Telemetry;
use super::{bridge, console, control};

/// The bridge needs 1.5 ms, the motor some more to stand still.
const SETTLE_MS: u32 = 20;
/// Longest measurement of the offset, milliseconds: 20 ms at rest and 205 ms of averaging.
const OFFSET_MS: u32 = 400;
/// Samples of the noise, one a millisecond.
const NOISE_SAMPLES: u32 = 200;
/// Longest drive for the encoder's direction, milliseconds: with a dead encoder it ends the motion.
const ENCODER_MS: u32 = 100;

/// The step could not be carried out: the test was stopped, or a fault has ended it.
struct Ended;

impl Application {
    /// Runs the self-test; each step is reported on both sides, the result is the answer.
    pub async fn selftest(self, port: &mut BufferedUartTx<'static>, answer: &mut Answer) {
        let failed = self.steps(port).await;
        self.coordinator
            .lock(|coordinator| coordinator.borrow_mut().end_test());
        let _ = match failed {
            None => write!(answer, "selftest passed"),
            Some(step) => write!(answer, "selftest failed at {}", step.name()),
        };
    }

    /// The first step that failed.
    async fn steps(self, port: &mut BufferedUartTx<'static>) -> Option<Step> {
        let limit = |setting| {
            self.coordinator
                .lock(|coordinator| coordinator.borrow().value(setting))
        };
        let (supply_min_v, supply_max_v) = (limit(Setting::SupplyMin), limit(Setting::SupplyMax));
        let signed = Active::CHECKED.config().sense.signed;
        // Drives once for two steps.
        let mut moved_counts = 0;
        for step in Step::ALL {
            let wanted = Wanted::of(step, supply_min_v, supply_max_v, signed);
            let measured = match step {
                Step::Wake => self.wake().await,
                Step::BreakInput => self.break_input().await,
                Step::Supply => self.supply_v().await,
                Step::Offset => self.offset_ma().await,
                Step::Noise => self.noise_ma().await,
                Step::Current => self.drive(&mut moved_counts).await,
                Step::Encoder => Ok(moved_counts as f32),
                Step::Travel => self.travel_mrad().await,
            };
            let value = measured.unwrap_or(f32::NAN);
            let (mut told, mut range) = (step, wanted);
            let passed = wanted.contains(value);
            if !passed {
                // A fault may belong to another step than the one in which it was detected.
                let fault = control::status().fault;
                told = fault.and_then(Step::of_fault).unwrap_or(step);
                range = Wanted::of(told, supply_min_v, supply_max_v, signed);
            }
            self.report_step(port, told, value, &range, passed).await;
            if !passed {
                return Some(told);
            }
        }
        None
    }

    async fn report_step(
        self,
        port: &mut BufferedUartTx<'static>,
        step: Step,
        value: f32,
        wanted: &Wanted,
        passed: bool,
    ) {
        let fault = control::status().fault;
        let mut want = Answer::new();
        // Every range fits.
        let _ = write!(want, "{wanted}");
        let (result, remedy) = if passed {
            ("ok", "none")
        } else {
            ("failed", remedy(step, value, wanted, fault))
        };
        let name = step.name();
        Telemetry.selftest(name, result, value, &want, remedy);
        let mut text = Answer::new();
        let value = Decimal(value);
        let _ = write!(
            text,
            "selftest step={name} result={result} value={value} want={want} remedy="
        );
        for piece in [text.as_str(), remedy, "\r\n"] {
            console::send(port, piece).await;
        }
    }

    /// Asks for something of the motor.
    fn ask(self, setpoint: Setpoint) -> Result<(), Ended> {
        let asked = self
            .coordinator
            .lock(|coordinator| coordinator.borrow_mut().set_test(setpoint));
        // A fault ends the test with the sequence's next step; the controller has switched off already.
        match control::status().fault {
            None if asked => Ok(()),
            _ => Err(Ended),
        }
    }

    /// Asks for something, and gives bridge and motor time.
    async fn settle(self, setpoint: Setpoint) -> Result<(), Ended> {
        self.ask_until(setpoint, SETTLE_MS, &mut |_, _| false).await
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

    /// Wakes the bridge; whether nFAULT is high then.
    async fn wake(self) -> Result<f32, Ended> {
        self.settle(Setpoint::Brake).await?;
        Ok(f32::from(u8::from(
            self.ask(Setpoint::Off).is_ok() && bridge::fault_pin_is_high(),
        )))
    }

    /// Whether a low nFAULT cuts the outputs, with the bridge asleep.
    async fn break_input(self) -> Result<f32, Ended> {
        self.settle(Setpoint::Off).await?;
        let _pause = control::pause();
        Ok(f32::from(u8::from(
            bridge::is_off() && bridge::break_cuts_outputs(),
        )))
    }

    async fn supply_v(self) -> Result<f32, Ended> {
        self.settle(Setpoint::Off).await?;
        Ok(control::status().supply_v)
    }

    async fn offset_ma(self) -> Result<f32, Ended> {
        // The state of an earlier measurement stands until this one has begun.
        self.settle(Setpoint::MeasureOffset).await?;
        let mut offset = Err(Ended);
        self.ask_until(Setpoint::MeasureOffset, OFFSET_MS, &mut |_, status| {
            if status.offset == OffsetState::Known {
                offset = Ok(status.offset_a * 1e3);
            }
            offset.is_ok()
        })
        .await?;
        offset
    }

    /// Standard deviation of the current that is read while the bridge brakes a motor at rest.
    async fn noise_ma(self) -> Result<f32, Ended> {
        let (mut sum, mut squares) = (0.0, 0.0);
        self.ask_until(Setpoint::Brake, NOISE_SAMPLES, &mut |_, status| {
            let current_ma = status.current_a * 1e3;
            sum += current_ma;
            squares += current_ma * current_ma;
            false
        })
        .await?;
        let mean = sum / NOISE_SAMPLES as f32;
        let variance = squares / NOISE_SAMPLES as f32 - mean * mean;
        Ok(palpate::numeric::sqrt(variance.max(0.0)))
    }

    /// Drives a current towards closing until the encoder has counted, or for a moment. The current that was read, on average
    /// after the first quarter; and how far the encoder counted.
    async fn drive(self, moved_counts: &mut i32) -> Result<f32, Ended> {
        let start = control::status().position_counts;
        let (mut sum, mut samples) = (0.0, 0);
        let current = Setpoint::Current { a: DRIVEN_A };
        let driven = self
            .ask_until(current, ENCODER_MS, &mut |ms, status| {
                *moved_counts = status.position_counts.wrapping_sub(start);
                // The reference takes 5 ms to get there.
                if ms >= 8 {
                    sum += status.current_a * 1e3;
                    samples += 1;
                }
                moved_counts.abs() >= ENCODER_COUNTS && samples >= 5
            })
            .await;
        // Whatever came of it.
        let _ = self.settle(Setpoint::Brake).await;
        driven?;
        Ok(sum / samples as f32)
    }

    /// Closes slowly by a few degrees and opens again: how far the finger went.
    async fn travel_mrad(self) -> Result<f32, Ended> {
        let scale = Active::CHECKED.scale();
        let counts = scale.counts(TRAVEL_RAD);
        let start = control::status().position_counts;
        let there = self.go(start, counts).await?;
        let _ = self.go(start.wrapping_add(there), -there).await?;
        Ok(scale.angle_rad(there) * 1e3)
    }

    /// Moves at the slow speed until `counts` are reached, for at most twice the time that takes; how far it went.
    async fn go(self, start: i32, counts: i32) -> Result<i32, Ended> {
        let sign = if counts < 0 { -1.0 } else { 1.0 };
        let patience_ms = (2e3 * TRAVEL_RAD / TRAVEL_RAD_PER_S) as u32;
        let slow = Setpoint::Speed {
            counts_per_s: sign * Active::CHECKED.scale().counts_per_s(TRAVEL_RAD_PER_S),
            current_limit_a: 2.0 * DRIVEN_A,
        };
        let mut moved = 0;
        self.ask_until(slow, patience_ms, &mut |_, status| {
            moved = status.position_counts.wrapping_sub(start);
            moved.abs() >= counts.abs()
        })
        .await?;
        self.settle(Setpoint::Brake).await?;
        Ok(moved)
    }
}
