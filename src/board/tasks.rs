//! The slow loop's tasks: sensing and motion sequence, each once a millisecond, in thread mode.
#![allow(
    clippy::unit_arg,
    clippy::let_unit_value,
    reason = "a reading of joint 2 is nothing in a scene without its sensor"
)]

use core::fmt::Write;

use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Ticker};

use super::{Joint, Series};
use crate::scene::Active;
use palpate::app::console::command::Command;
use palpate::app::console::text::Answer;
use palpate::app::grasp::sensing::{SensingRequest, followed_notice, notice};
use palpate::app::log::{self, LimitReport, Log};
use palpate::drive::sequence::{Notice, State, StepOutput};
use palpate::drive::thermal::Temperatures;
use palpate::drive::{Fault, OffsetState, Setpoint, Status};
use palpate::scene::Reading;
use palpate::sensing::{Directive, Event, JointSensor, SeriesElement, Side};

use super::control::{self, Samples};
use super::execute::Application;
use super::indicator::{Button, Led};
use super::telemetry::{self, Telemetry};
use super::watchdog::{self, Reporter};
use super::{bridge, console, rtt, thermal, trace};

/// How often both are called.
const PERIOD: Duration = Duration::from_millis(1);

/// Notices to the sequence, which takes one a millisecond; a sender of more waits.
pub static NOTICES: Channel<ThreadModeRawMutex, Notice, 4> = Channel::new();

/// Samples to events.
#[embassy_executor::task]
pub async fn sense(mut samples: Samples, application: Application) {
    let Application {
        sensing,
        coordinator,
    } = application;
    let mut reads = true;
    loop {
        samples.wait().await;
        #[cfg(feature = "fault-injection")]
        super::inject::starve().await;
        if samples.overflowed() {
            NOTICES.send(Notice::Fault(Fault::QueueOverflow)).await;
        }
        while let Some(sample) = samples.next() {
            if Joint::FITTED {
                reads = joint_reads(reads, sample.joint);
            }
            let (event, followed) = sensing.with(|sensing| {
                let event = sensing.sample(&sample);
                (event, sensing.follow(&sample, event.as_ref()))
            });
            if trace::due() {
                let suspicion = sensing.with(|sensing| sensing.sensor().suspicion());
                trace::sample(&sample, Joint::rad(sample.joint), suspicion);
            }
            // Nothing of an event is kept while the notice waits: it would lie in the task's memory.
            let mut told = None;
            if let Some(event) = event {
                application.report(&event);
                if coordinator.with(|coordinator| coordinator.event(&event)) {
                    Telemetry.limit(true, false, false, false);
                }
                told = notice::<Active>(&event);
            }
            if let Some(followed) = followed {
                log::followed(&mut Telemetry, &followed);
                told = followed_notice(&followed).or(told);
            }
            if let Some(notice) = told {
                NOTICES.send(notice).await;
            }
            watchdog::report(Reporter::Sensing);
            // However far behind this is, the sequence and a stop come in between.
            yield_now().await;
        }
    }
}

impl Application {
    /// Logs an event, and what belongs to it.
    fn report(self, event: &Event) {
        log::event(&mut Telemetry, event);
        if Joint::FITTED && matches!(event, Event::Located { .. } | Event::Ambiguous { .. }) {
            let change = self.sensing.with(|sensing| sensing.joint_change());
            let change_rad = Joint::rad(change).unwrap_or(f32::NAN);
            telemetry::branch(change_rad * 1e3, side(Joint::side(change)));
        }
        if Series::OBJECT_GIVES {
            let last = self.sensing.with(|sensing| sensing.object());
            if let Some(object) = log::object_with(event, last) {
                log::object(&mut Telemetry, &object);
            }
        }
        let hint = self.sensing.with(|sensing| sensing.hint(event));
        let state = self.coordinator.with(|coordinator| coordinator.state());
        if let Some(hint) = hint.filter(|hint| hint.helps(state)) {
            let mut text = Answer::new();
            // Every hint fits.
            let _ = write!(text, "{hint}");
            Telemetry.hint(&text);
        }
    }
}

fn side(side: Option<Side>) -> &'static str {
    match side {
        Some(Side::Below) => "below",
        Some(Side::Beyond) => "beyond",
        Some(Side::Unclear) => "unclear",
        None => "no-reading",
    }
}

/// Logs when joint 2 loses its reading, and when that is back; returns whether there is one.
fn joint_reads(before: bool, reading: Reading<Active>) -> bool {
    let reads = Joint::rad(reading).is_some();
    if reads != before {
        Telemetry.joint(reads);
    }
    reads
}

/// The motion sequence: notices, button and stop in, demands out.
#[embassy_executor::task]
pub async fn sequence(mut led: Led, mut button: Button, application: Application) {
    let Application {
        sensing,
        coordinator,
    } = application;
    let mut ticker = Ticker::every(PERIOD);
    let mut changes = Changes::default();
    loop {
        ticker.next().await;
        let status = control::status();
        let pressed = button.pressed();
        let notice = NOTICES.try_receive().ok();
        let told = notice.is_some();
        let (state, step) = coordinator.with(|coordinator| {
            if console::stop_requested() {
                // Never refused.
                let _ = coordinator.command(Command::Stop);
            } else if pressed {
                // What the button means in a state is refused where the fault is still there: the LED blinks on.
                let command = meaning(coordinator.state());
                let _ = coordinator.command(command);
            }
            let step = coordinator.advance(Instant::now().as_micros(), &status, notice);
            (coordinator.state(), step)
        });
        let rests = matches!(step.motion.demand.setpoint, Setpoint::Off);
        let is_live = !rests || state == State::Fault;
        // After a start the fault may come behind other notices: the mark of the last run stays until all are heard.
        if is_live || !told {
            bridge::keep_live(is_live);
        }
        control::demand(step.motion.demand);
        if let Some(request) = step.request {
            report_purpose(&request);
            sensing.with(|sensing| sensing.request(request));
        }
        if let Some((_, to)) = step.motion.changed {
            led.show(to);
        }
        if status.time_us > 0 {
            thermal::keep(Temperatures {
                winding_c: status.winding_c,
                housing_c: status.housing_c,
            });
        }
        report(&step.motion);
        changes.report(state, &status);
        led.tick(!rests);
        watchdog::report(Reporter::Sequence);
    }
}

/// Logs that a closing calibrates: the motion's states do not tell, and a recording must.
fn report_purpose(request: &SensingRequest) {
    let pin_m = match *request {
        SensingRequest::Direct(Directive::Calibrate { k_m, .. }) => k_m,
        SensingRequest::Direct(Directive::CalibrateCable) => f32::NAN,
        _ => return,
    };
    Telemetry.calibrating(pin_m);
}

/// Logs what a step of the sequence decided.
fn report(step: &StepOutput) {
    if let Some((from, to)) = step.changed {
        Telemetry.state(to.name(), from.name());
    }
    if let Some(fault) = step.fault {
        Telemetry.fault(fault.number(), fault.name());
    }
    if let Some(result) = step.done {
        Telemetry.done(result.name());
    }
}

/// What the button asks for.
fn meaning(state: State) -> Command {
    match state {
        State::Idle => Command::Run,
        State::Fault => Command::Clear,
        _ => Command::Stop,
    }
}

/// What the log has last said of slow changes.
#[derive(Default)]
struct Changes {
    limits: LimitReport,
    offset: OffsetState,
    dropped: u32,
    ignored: u32,
}

impl Changes {
    /// Logs what has changed.
    fn report(&mut self, state: State, status: &Status) {
        if let Some(limit) = self.limits.update(state, status.limited) {
            Telemetry.limit(limit.current, limit.duty, limit.speed, limit.position);
        }
        if status.offset != self.offset {
            self.offset = status.offset;
            if status.offset == OffsetState::Known {
                Telemetry.offset(status.offset_a * 1e3);
            }
        }
        let dropped = rtt::dropped();
        if dropped != self.dropped {
            Telemetry.dropped(dropped);
            // Do not count this line where it finds no room, and try it again.
            if !rtt::take_back(dropped) {
                self.dropped = dropped;
            }
        }
        let ignored = console::ignored();
        if ignored != self.ignored {
            self.ignored = ignored;
            Telemetry.ignored(ignored);
        }
    }
}
