//! The sensing in a firmware of another controller: what that has to bring are the four functions of [`Board`], and a call of
//! [`Gripper::millisecond`] once a millisecond. No chip, no scene, no operating system.
//!
//! The motor is driven at a fixed duty, which is enough to feel a contact: the library asks for a steady speed, not for a
//! certain one. Limits of current, temperature and travel are the board's own here; `palpate::drive` has them for those who
//! bring more than four functions.
#![no_std]

#[path = "../../prototype/mod.rs"]
pub mod prototype;

use palpate::sensing::{Directive, Drive, Event, Sample, Sensor, Settings};
use prototype::{Prototype, UNCALIBRATED, drivetrain};

/// What the controller must be able to do.
pub trait Board {
    /// Encoder counts from the opening stop, closing positive.
    fn counts(&mut self) -> i32;
    /// Mean motor current over the last millisecond, ampere, positive when its torque closes.
    fn current_a(&mut self) -> f32;
    /// Voltage of the motor as a share of the supply, -1 to 1, closing positive; 0 brakes.
    fn set_duty(&mut self, duty: f32);
    /// Microseconds since start.
    fn time_us(&mut self) -> u64;
}

/// Duty of a closing and of an opening.
const DUTY: f32 = 0.3;
/// Current at which a motion ends, whatever was felt, ampere.
const MOST_A: f32 = 0.11;
/// How near the stops a free motion turns round, radian.
const SHORT_OF_STOP_RAD: f32 = 0.05;

/// What the gripper does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Closes and opens freely, to learn friction.
    Learning(Way),
    /// Closes on what may be there.
    Grasping,
    /// Stands, braked.
    Standing,
}

/// Direction of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Towards the object.
    Closing,
    /// Towards the opening stop.
    Opening,
}

/// A finger with its sensor.
pub struct Gripper {
    sensor: Sensor<Prototype>,
    motion: Motion,
    /// Counts between the turning points of a free motion.
    travel_counts: i32,
    /// Counts that count as standing.
    margin_counts: i32,
}

impl Gripper {
    /// For the finger and drivetrain of [`prototype`]: put yours there. The finger stands at its opening stop, its encoder at zero.
    ///
    /// # Errors
    /// The linkage does not close in its range.
    pub fn new() -> Result<Self, palpate::finger::ConfigError> {
        let finger = prototype::finger()?;
        let drivetrain = drivetrain(&finger);
        let settings = Settings::default();
        let counts = |angle_rad: f32| (angle_rad / drivetrain.rad_per_count) as i32;
        Ok(Self {
            sensor: Sensor::new(finger, drivetrain, settings, UNCALIBRATED),
            motion: Motion::Standing,
            travel_counts: counts(settings.travel_rad - SHORT_OF_STOP_RAD),
            margin_counts: counts(SHORT_OF_STOP_RAD),
        })
    }

    /// Learns friction on a free closing and opening: nothing may be in the way.
    pub fn learn(&mut self) {
        self.sensor.direct(Directive::RecordFriction);
        self.motion = Motion::Learning(Way::Closing);
    }

    /// Closes until the contact is located.
    pub fn grasp(&mut self) {
        self.sensor.direct(Directive::Watch);
        self.motion = Motion::Grasping;
    }

    /// What it does now.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// Once a millisecond: a sample to the sensor, a duty to the motor. What was felt, if something was.
    pub fn millisecond(&mut self, board: &mut impl Board) -> Option<Event> {
        let (drive, duty) = match self.motion {
            Motion::Learning(Way::Closing) | Motion::Grasping => (Drive::Closing, DUTY),
            Motion::Learning(Way::Opening) => (Drive::Opening, -DUTY),
            Motion::Standing => (Drive::Idle, 0.0),
        };
        let sample = Sample {
            time_us: board.time_us(),
            position_counts: board.counts(),
            current_a: board.current_a(),
            // Not known. A board that measures its supply has supply x duty less resistance x current.
            emf_v: f32::NAN,
            drive,
            joint: (),
        };
        board.set_duty(duty);
        let event = self.sensor.update(&sample);
        self.motion = match self.motion {
            Motion::Learning(Way::Closing) if sample.position_counts > self.travel_counts => {
                Motion::Learning(Way::Opening)
            }
            Motion::Learning(Way::Opening) if sample.position_counts < self.margin_counts => {
                self.end()
            }
            Motion::Grasping if located(event.as_ref()) || sample.current_a > MOST_A => self.end(),
            going_on => going_on,
        };
        event
    }

    /// Ends a motion: the sensor judges what was going on as it stands, with the next sample.
    fn end(&mut self) -> Motion {
        self.sensor.direct(Directive::Rest);
        Motion::Standing
    }
}

/// More torque would not locate the contact better.
fn located(event: Option<&Event>) -> bool {
    matches!(
        event,
        Some(
            Event::Located { settled: true, .. }
                | Event::Ambiguous { settled: true, .. }
                | Event::NotLocated { .. }
        )
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A finger without friction or load that follows its duty at once.
    struct Free {
        time_us: u64,
        counts: f32,
        duty: f32,
    }

    impl Board for Free {
        fn counts(&mut self) -> i32 {
            self.counts as i32
        }
        fn current_a(&mut self) -> f32 {
            0.015 * self.duty.signum() * f32::from(self.duty != 0.0)
        }
        fn set_duty(&mut self, duty: f32) {
            self.duty = duty;
            self.counts += 208.0 * duty;
            self.time_us += 1000;
        }
        fn time_us(&mut self) -> u64 {
            self.time_us
        }
    }

    #[test]
    fn friction_is_learned_and_a_free_closing_ends_without_a_place() {
        let mut gripper = Gripper::new().expect("the linkage closes");
        let mut board = Free {
            time_us: 0,
            counts: 0.0,
            duty: 0.0,
        };
        gripper.learn();
        let mut learned = false;
        for _ in 0..30_000 {
            let event = gripper.millisecond(&mut board);
            learned |= matches!(event, Some(Event::FrictionRecorded { .. }));
        }
        assert_eq!(gripper.motion(), Motion::Standing);
        assert!(learned);
    }
}
