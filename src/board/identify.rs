//! Runs the identification of the motor ([`palpate::drive::identify`]) and reports each quantity.

use core::fmt::Write;

use embassy_stm32::usart::BufferedUartTx;
use embassy_time::{Duration, Ticker};

use crate::scene::Active;
use palpate::app::console::settings::Setting;
use palpate::app::console::text::{Answer, Decimal, Plain};
use palpate::app::identify::Report;
use palpate::app::log::Log;
use palpate::drive::identify::{FREE_WAY_RAD, Identification, Identified, Quantity, Step};
use palpate::scene::Scene;

use super::execute::Application;
use super::telemetry::Telemetry;
use super::{console, control};

impl Application {
    /// Identifies the motor; each quantity is reported on both sides, the result is the answer.
    pub async fn identify(self, port: &mut BufferedUartTx<'static>, answer: &mut Answer) {
        let found = self.motions().await;
        self.coordinator.with(|coordinator| coordinator.end_test());
        let identified = match found {
            Ok(identified) => identified,
            Err(why) => {
                let _ = write!(answer, "identify failed: {}", Plain(why));
                return;
            }
        };
        for quantity in Quantity::ALL {
            let report = Report::of::<Active>(quantity, &identified);
            let Report {
                name,
                unit,
                value,
                sigma,
                datasheet,
                ..
            } = report;
            let (deviation, result) = (report.deviation_percent(), report.result());
            Telemetry.identify(name, value, sigma, datasheet, unit, deviation, result);
            let mut text = Answer::new();
            // The longest line fits.
            let _ = write!(
                text,
                "identify quantity={} value={} sigma={} datasheet={} unit={} ",
                Plain(name),
                Decimal(value),
                Decimal(sigma),
                Decimal(datasheet),
                Plain(unit)
            );
            console::send(port, &text).await;
            text.clear();
            let (deviation, result) = (Decimal(deviation), Plain(result));
            let _ = write!(text, "deviation_percent={deviation} result={result}\r\n");
            console::send(port, &text).await;
        }
        self.coordinator
            .with(|coordinator| coordinator.set_identified(identified));
        let _ = answer.push_str("identified; takes effect after save and a restart");
    }

    /// The motions, every millisecond until they end.
    async fn motions(self) -> Result<Identified, &'static str> {
        let status = control::status();
        let scale = Active::CHECKED.scale();
        let room = scale.counts(Active::TRAVEL_RAD - FREE_WAY_RAD) - status.position_counts;
        if !status.homed || room < 0 {
            return Err("home first");
        }
        let closing_rad_per_s = self
            .coordinator
            .with(|coordinator| coordinator.value(Setting::ClosingSpeed));
        let mut identification = Identification::new(&Active::CHECKED, closing_rad_per_s, &status);
        let mut ticker = Ticker::every(Duration::from_millis(1));
        loop {
            let setpoint = match identification.advance(&control::status()) {
                Ok(Step::Ask(setpoint)) => setpoint,
                Ok(Step::Done(identified)) => return Ok(identified),
                Err(why) => return Err(why.name()),
            };
            // A fault ends the test with the sequence's next step; the controller has switched off already.
            let asked = self
                .coordinator
                .with(|coordinator| coordinator.set_test(setpoint));
            if control::status().fault.is_some() || !asked {
                return Err("stopped");
            }
            ticker.next().await;
        }
    }
}
