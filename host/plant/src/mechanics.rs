//! Interface to finger and object, which different engines can compute.
//!
//! The drivetrain only needs the position of the cable's end and its torque. [`Quasistatic`] is this crate's engine; another one
//! implements [`Mechanics`] and is passed to [`crate::Plant::with_mechanics`].

use crate::finger::{Finger, Hold, MAX};
use crate::object::{Body, Grasp, Point};
use crate::parameters::{Object, Parameters};
use crate::{Contact, Error};
use std::fmt::Debug;

/// Position of the drivetrain's end of the cable. Between `low_rad` and `high_rad` of the input link the cable is slack (the
/// worm's backlash); beyond, it acts by its stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CableEnd {
    /// Below this angle of the input link the cable pulls it towards closing, radian.
    pub low_rad: f64,
    /// Above this angle it pulls it towards opening, radian.
    pub high_rad: f64,
    /// Newton metre per radian at the input link.
    pub stiffness_nm_per_rad: f64,
}

impl CableEnd {
    /// Torque at the input link, closing positive, newton metre.
    #[must_use]
    pub fn torque_nm(&self, theta_a_rad: f64) -> f64 {
        let short = (self.low_rad - theta_a_rad).max(0.0);
        let long = (theta_a_rad - self.high_rad).max(0.0);
        self.stiffness_nm_per_rad * (short - long)
    }
}

/// State of the finger for drivetrain, sensors and truth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FingerState {
    /// How many phalanges the finger has; joints beyond are zero.
    pub phalanges: usize,
    /// Relative joint angles, radian.
    pub joint_rad: [f64; MAX],
    /// Input-link angle, radian.
    pub theta_a_rad: f64,
    /// Opening and closing stop of the input link, radian.
    pub stops_rad: [f64; 2],
    /// Torque of the cable at the input link, closing positive, newton metre.
    pub torque_nm: f64,
    /// Where the finger presses on the object.
    pub contacts: Vec<Contact>,
}

/// An engine for finger and object.
pub trait Mechanics: Debug + Send + Sync {
    /// The state after the last step.
    fn state(&self) -> &FingerState;

    /// Replaces or removes the object.
    ///
    /// # Errors
    /// The object cannot be there, or overlaps the finger; the previous one then stays.
    fn place(&mut self, grasp: &Grasp) -> Result<(), Error>;

    /// Holds what is placed from now on as this says.
    ///
    /// # Errors
    /// The engine has no such mount.
    fn mount(&mut self, object: &Object) -> Result<(), Error>;

    /// Moves the object by a distance, metre, in contact or not: into the finger it presses.
    ///
    /// # Errors
    /// The object cannot be there.
    fn shift(&mut self, by_m: Point) -> Result<(), Error>;

    /// Removes or restores the stops of input link and joint 1.
    fn break_stops(&mut self, missing: bool);

    /// Leaves this share of their stiffness to the springs of the joints, 1 for all.
    fn weaken_springs(&mut self, left: f64);

    /// Steps by `dt_s` seconds with the cable's end at this position.
    fn step(&mut self, end: &CableEnd, dt_s: f64);

    /// Lets the finger come to rest.
    fn settle(&mut self, end: &CableEnd);

    /// Energy of the finger's motion, springs, stops and contacts (not of the cable), joule.
    fn energy_j(&self) -> f64;

    /// An independent copy.
    fn boxed_clone(&self) -> Box<dyn Mechanics>;
}

impl Clone for Box<dyn Mechanics> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// This crate's engine: a finger without mass, in equilibrium at every step.
#[derive(Clone, Debug)]
pub struct Quasistatic {
    finger: Finger,
    body: Body,
    state: FingerState,
}

impl Quasistatic {
    /// A finger at its rest pose, nothing to grasp.
    ///
    /// # Errors
    /// A parameter out of range, a four-bar that does not close, or an object that is free.
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        let mut finger = Finger::new(parameters)?;
        finger.mount(&parameters.object)?;
        let mut new = Self {
            state: FingerState {
                phalanges: finger.count,
                stops_rad: finger.stops,
                ..FingerState::default()
            },
            finger,
            body: Body::Nothing,
        };
        new.read();
        Ok(new)
    }

    fn read(&mut self) {
        let (finger, state) = (&self.finger, &mut self.state);
        state.joint_rad = finger.angle;
        state.theta_a_rad = finger.theta_a;
        state.torque_nm = finger.torque;
        state.contacts.clone_from(&finger.contacts);
    }
}

impl From<&CableEnd> for Hold {
    fn from(end: &CableEnd) -> Self {
        Self::Cable {
            low: end.low_rad,
            high: end.high_rad,
            stiffness: end.stiffness_nm_per_rad,
        }
    }
}

impl Mechanics for Quasistatic {
    fn state(&self) -> &FingerState {
        &self.state
    }

    fn place(&mut self, grasp: &Grasp) -> Result<(), Error> {
        let body = self.finger.body(grasp)?;
        let clearance = self.finger.clearance(&body);
        if clearance < 0.0 {
            return Err(Error::overlap(-clearance));
        }
        self.body = body;
        Ok(())
    }

    fn mount(&mut self, object: &Object) -> Result<(), Error> {
        self.finger.mount(object)
    }

    fn shift(&mut self, by_m: Point) -> Result<(), Error> {
        self.body = self.body.shifted(by_m);
        Ok(())
    }

    fn break_stops(&mut self, missing: bool) {
        self.finger.stopped = !missing;
        self.finger.runs_on = missing;
    }

    fn weaken_springs(&mut self, left: f64) {
        self.finger.springs_left = left;
    }

    fn step(&mut self, end: &CableEnd, dt_s: f64) {
        self.finger.step(&self.body, end.into(), dt_s);
        self.read();
    }

    fn settle(&mut self, end: &CableEnd) {
        self.finger.settle(&self.body, end.into());
        self.read();
    }

    fn energy_j(&self) -> f64 {
        self.finger.energy()
    }

    fn boxed_clone(&self) -> Box<dyn Mechanics> {
        Box::new(self.clone())
    }
}

/// Position of an object for other engines: a given contact is placed against this crate's finger in its free posture.
///
/// # Errors
/// The object cannot be there.
pub fn placed(parameters: &Parameters, grasp: &Grasp) -> Result<Body, Error> {
    Finger::new(parameters)?.body(grasp)
}
