//! The slow loop's tasks: sensing and motion sequence, each once a millisecond, in thread mode.
//!
//! Both halves are plain state ([`Sense`], [`Conduct`]), shared for the length of a call, never across an await.
#![allow(
    clippy::unit_arg,
    clippy::let_unit_value,
    reason = "a reading of joint 2 is nothing in a scene without its sensor"
)]

use embassy_futures::yield_now;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{PA5, PC13};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Ticker};

use palpate::app::command::Command;
use palpate::app::conduct::Conduct;
use palpate::app::sense::{Sense, notice};
use palpate::drive::joint::JointInput;
use palpate::drive::sequence::{Notice, State};
use palpate::drive::{Fault, LimitsReached, OffsetState, Status};
use palpate::scene::{Active, JointPin, Reading, Scene};
use palpate::sensing::{Event, JointSensor};

use super::Shared;
use super::control::{self, Samples};
use super::watchdog::{self, Reporter};
use super::{console, log, telemetry};

/// What measures joint 2 in this firmware's scene.
type Joint = <Active as Scene>::Joint;

/// How often both are called.
const PERIOD: Duration = Duration::from_millis(1);

/// Notices to the sequence, which takes one a millisecond; whoever sends more waits.
pub static NOTICES: Channel<ThreadModeRawMutex, Notice, 4> = Channel::new();

/// Samples to events.
#[embassy_executor::task]
pub async fn sense(
    mut samples: Samples,
    sense: &'static Shared<Sense<Active>>,
    conduct: &'static Shared<Conduct<Active>>,
) {
    let mut reads = true;
    loop {
        samples.wait().await;
        #[cfg(feature = "fault-injection")]
        super::inject::starve().await;
        if samples.overflowed() {
            NOTICES.send(Notice::Fault(Fault::QueueOverflow)).await;
        }
        while let Some(sample) = samples.next() {
            if JointPin::<Active>::FITTED {
                reads = joint_reads(reads, sample.joint);
            }
            let event = sense.lock(|sense| sense.borrow_mut().sample(&sample));
            if let Some(event) = event {
                telemetry::event(&event);
                if JointPin::<Active>::FITTED
                    && matches!(event, Event::Located { .. } | Event::Ambiguous { .. })
                {
                    let change = sense.lock(|sense| sense.borrow().joint_change());
                    telemetry::branch(Joint::rad(change), Joint::side(change));
                }
                let hint = sense.lock(|sense| sense.borrow().hint(&event));
                if let Some(hint) = hint {
                    telemetry::hint(hint);
                }
                let status = control::status();
                conduct.lock(|conduct| conduct.borrow_mut().hear(&event, &status));
                if let Some(notice) = notice(&event) {
                    NOTICES.send(notice).await;
                }
            }
            watchdog::report(Reporter::Sensing);
            // However far behind this is, the sequence and a stop come in between.
            yield_now().await;
        }
    }
}

/// Says when joint 2 loses its reading, and when that is back; returns whether there is one.
fn joint_reads(before: bool, reading: Reading<Active>) -> bool {
    let reads = Joint::rad(reading).is_some();
    if reads != before {
        telemetry::joint(reads);
    }
    reads
}

/// The motion sequence: notices, button and stop in, demands out.
#[embassy_executor::task]
pub async fn sequence(
    mut light: Light,
    mut button: Button,
    sense: &'static Shared<Sense<Active>>,
    conduct: &'static Shared<Conduct<Active>>,
) {
    let mut ticker = Ticker::every(PERIOD);
    let mut said = Said::default();
    loop {
        ticker.next().await;
        let status = control::status();
        let pressed = button.pressed();
        let notice = NOTICES.try_receive().ok();
        let conducted = conduct.lock(|conduct| {
            let mut conduct = conduct.borrow_mut();
            if console::stop_requested() {
                // Never refused.
                let _ = conduct.command(Command::Stop);
            } else if pressed {
                // What the button means now is never refused either.
                let command = meaning(conduct.state());
                let _ = conduct.command(command);
            }
            conduct.advance(Instant::now().as_micros(), &status, notice)
        });
        control::demand(conducted.advance.demand);
        if let Some(order) = conducted.order {
            sense.lock(|sense| sense.borrow_mut().order(order));
        }
        if let Some((from, to)) = conducted.advance.changed {
            telemetry::state(from, to);
            light.show(to);
        }
        if let Some(fault) = conducted.advance.fault {
            telemetry::fault(fault);
        }
        if let Some(outcome) = conducted.advance.done {
            telemetry::done(outcome);
        }
        said.changes(&status);
        light.tick();
        watchdog::report(Reporter::Sequence);
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

/// What the log has said of slow changes.
#[derive(Default)]
struct Said {
    limited: LimitsReached,
    offset: OffsetState,
    dropped: u32,
    ignored: u32,
}

impl Said {
    /// Says what has changed.
    fn changes(&mut self, status: &Status) {
        if status.limited != self.limited {
            self.limited = status.limited;
            telemetry::limited(status.limited);
        }
        if status.offset != self.offset {
            self.offset = status.offset;
            if status.offset == OffsetState::Known {
                telemetry::offset(status.offset_a);
            }
        }
        let dropped = log::dropped();
        if dropped != self.dropped {
            self.dropped = dropped;
            telemetry::dropped(dropped);
        }
        let ignored = console::ignored();
        if ignored != self.ignored {
            self.ignored = ignored;
            telemetry::ignored(ignored);
        }
    }
}

/// The user button (PC13, high when pressed), debounced.
pub struct Button {
    pin: Input<'static>,
    /// Last samples, one a millisecond, newest in bit 0.
    history: u32,
}

impl Button {
    /// Takes the pin, which the board pulls down.
    pub fn new(pin: Peri<'static, PC13>) -> Self {
        Self {
            pin: Input::new(pin, Pull::None),
            history: 0,
        }
    }

    /// Call once a millisecond: true once a press, when it has lasted 16 ms after 15 ms of rest.
    fn pressed(&mut self) -> bool {
        self.history = self.history << 1 | u32::from(self.pin.is_high());
        self.history == 0x0000_FFFF
    }
}

/// The LED (PA5): dark at rest, lit in motion, blinking after a fault.
pub struct Light {
    pin: Output<'static>,
    state: State,
    ticks: u32,
}

impl Light {
    /// Half a blink, milliseconds.
    const BLINK: u32 = 125;

    /// Takes the pin.
    pub fn new(pin: Peri<'static, PA5>) -> Self {
        Self {
            pin: Output::new(pin, Level::Low, Speed::Low),
            state: State::Idle,
            ticks: 0,
        }
    }

    fn show(&mut self, state: State) {
        self.state = state;
    }

    /// Call once a millisecond.
    fn tick(&mut self) {
        self.ticks = self.ticks.wrapping_add(1);
        let lit = match self.state {
            State::Idle => false,
            State::Fault => (self.ticks / Self::BLINK).is_multiple_of(2),
            _ => true,
        };
        self.pin.set_level(lit.into());
    }
}
