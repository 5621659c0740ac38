//! The sensing half of the slow loop: samples in, events out, and the notices for the motion sequence that follow from them.

use super::guide::Hint;
use super::values;
use crate::app::console::settings::{Overrides, Setting};
use crate::app::identify;
use crate::app::storage::record::Record;
use crate::drive::sequence::Notice;
#[cfg(not(weightless))]
use crate::finger::Mounting;
use crate::scene::{Reading, SampleOf, Scene};
use crate::sensing::{
    AfterContact, Calibration, Directive, Event, Followed, Object, Sensor, Settings,
};

/// What the motion half asks of the sensing half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensingRequest {
    /// What the samples from now on are used for.
    Direct(Directive),
    /// Settings changed. None is set after `factory` alone, which forgets what was identified, too. What contacts have calibrated
    /// stays, unless the efficiency becomes another one; `factory` has it forgotten besides.
    Adjust(Overrides),
    /// Back to the scene's calibration.
    ForgetCalibration,
    /// Counts were lost: the friction record belongs to another zero.
    Realign,
}

/// The sensing half. It shares nothing with the motion half but [`SensingRequest`]s and [`Notice`]s, so that the two may live in two
/// tasks, of two priorities if a fit takes long: a `stop` must not wait for it.
#[derive(Clone, Debug)]
pub struct ContactSensing<S: Scene> {
    sensor: Sensor<S::Finger, S::Joint, S::Series>,
    /// What is assumed before anything is calibrated.
    uncalibrated: Calibration,
    after: S::After,
}

impl<S: Scene> Default for ContactSensing<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scene> ContactSensing<S> {
    /// A sensor for the scene's finger, nothing recorded, nothing calibrated.
    pub fn new() -> Self {
        let finger = S::MECHANISM;
        let drivetrain = S::drivetrain(&finger);
        let sensor = Sensor::new(finger, drivetrain, S::settings(), S::UNCALIBRATED);
        Self {
            sensor,
            uncalibrated: S::UNCALIBRATED,
            after: S::After::default(),
        }
    }

    /// Carries out a request.
    pub fn request(&mut self, request: SensingRequest) {
        match request {
            SensingRequest::Direct(directive) => {
                self.sensor.direct(directive);
                self.after.direct(directive);
            }
            SensingRequest::Adjust(overrides) => {
                self.adjust(&overrides);
                if S::IDENTIFIES && overrides == Overrides::default() {
                    let tolerance = S::DRIVETRAIN.torque_constant_sigma;
                    let calibration =
                        self.assume((S::UNCALIBRATED, tolerance), *self.calibration());
                    self.sensor.set_calibration(calibration);
                }
            }
            SensingRequest::ForgetCalibration => {
                self.sensor.set_calibration(self.uncalibrated);
            }
            SensingRequest::Realign => self.sensor.realign(),
        }
    }

    /// Takes a sample; at most one event. [`notice`] says what of it concerns the motion.
    pub fn sample(&mut self, sample: &SampleOf<S>) -> Option<Event> {
        self.sensor.update(sample)
    }

    /// Takes the same sample once more, with what [`Self::sample`] told, for what follows the first contact: at most one
    /// event. Nothing in a scene without that option.
    pub fn follow(&mut self, sample: &SampleOf<S>, told: Option<&Event>) -> Option<Followed> {
        self.after.sample(&mut self.sensor, sample, told)
    }

    /// What the user should do after an event, in the guided calibration.
    pub fn hint(&self, event: &Event) -> Option<Hint> {
        Hint::after::<S>(event, self.calibration(), self.sensor.finger())
    }

    /// See [`Sensor::object`].
    pub fn object(&self) -> Option<Object> {
        self.sensor.object()
    }

    /// Change of theta_2 since contact, as the last judgement of a contact used it.
    pub fn joint_change(&self) -> Reading<S> {
        self.sensor.joint_change()
    }

    /// The sensor.
    pub fn sensor(&self) -> &Sensor<S::Finger, S::Joint, S::Series> {
        &self.sensor
    }

    /// States the error of the worm's angle, radian, as a scene does: for simulated fingers, whose worlds may know it.
    pub fn state_worm_error(&mut self, worm_error_rad: f32) {
        self.sensor.set_settings(Settings {
            worm_error_rad,
            ..*self.sensor.settings()
        });
    }

    /// Takes over a record. Tells the motion half whether friction is known.
    pub fn restore(&mut self, record: &Record<'_>) -> Notice {
        self.adjust(record.overrides);
        let mut calibration = *record.calibration;
        if S::IDENTIFIES
            && let Some(identified) = record.identified
        {
            calibration = self.assume(identify::uncalibrated::<S>(identified), calibration);
        }
        self.sensor.set_calibration(calibration);
        let known = (record.friction)
            .is_some_and(|friction| self.sensor.restore_friction(friction.clone()));
        if known {
            Notice::FrictionKnown
        } else {
            Notice::FrictionUnknown
        }
    }

    /// Takes what is to be assumed before a contact calibrates, and the tolerance of the torque constant in it; the calibration with
    /// it, where it stems from no contact.
    fn assume(
        &mut self,
        (uncalibrated, tolerance): (Calibration, f32),
        mut calibration: Calibration,
    ) -> Calibration {
        self.sensor.set_torque_constant_sigma(tolerance);
        self.uncalibrated = uncalibrated;
        if calibration.contacts == 0 {
            calibration.torque_factor = uncalibrated.torque_factor;
            calibration.torque_factor_sigma = uncalibrated.torque_factor_sigma;
        }
        calibration
    }

    /// The calibration in force.
    pub fn calibration(&self) -> &Calibration {
        self.sensor.calibration()
    }

    fn adjust(&mut self, overrides: &Overrides) {
        let nominal = S::settings();
        let set = |setting, nominal| overrides.get(setting).unwrap_or(nominal);
        self.sensor.set_settings(Settings {
            speed_rad_per_s: values::closing_rad_per_s::<S>(overrides),
            torque_limit_nm: set(Setting::ProbeTorque, nominal.torque_limit_nm),
            wanted_sigma_m: set(Setting::WantedDeviation, nominal.wanted_sigma_m),
            false_contacts_per_thousand: set(
                Setting::Sensitivity,
                nominal.false_contacts_per_thousand,
            ),
            contact_friction: overrides
                .get(Setting::ContactFriction)
                .map_or(nominal.contact_friction, |mean| nominal.rubbed_with(mean)),
            force_scale: overrides.get(Setting::ForceScale),
            #[cfg(not(weightless))]
            mounting: Some(Mounting {
                gravity_rad: set(Setting::Mounting, S::MOUNTING_RAD),
                share: set(Setting::Weight, 1.0),
            }),
            // No setting changes the others.
            ..*self.sensor.settings()
        });
        let nominal = S::drivetrain(self.sensor.finger()).efficiency;
        if self
            .sensor
            .set_efficiency(overrides.get(Setting::Efficiency).unwrap_or(nominal))
        {
            // The torque factor corrects the efficiency that it was calibrated with.
            self.sensor.set_calibration(self.uncalibrated);
        }
    }
}

/// What an event means for the motion. Where a second contact is looked for, the closing goes on after the last word on the
/// first.
pub fn notice<S: Scene>(event: &Event) -> Option<Notice> {
    match event {
        Event::Located { settled: true, .. }
        | Event::Ambiguous { settled: true, .. }
        | Event::NotLocated { .. }
            if S::After::FOLLOWS =>
        {
            None
        }
        Event::Touch { .. } => Some(Notice::Touched),
        Event::Located { settled: true, .. }
        | Event::Ambiguous { settled: true, .. }
        | Event::NotLocated { .. }
        | Event::Calibrated { .. }
        | Event::CalibrationRefused { .. } => Some(Notice::Settled),
        Event::FrictionRecorded { .. } => Some(Notice::FrictionKnown),
        Event::FrictionNotRecorded { .. } => Some(Notice::FrictionNotRecorded),
        Event::FrictionStale { .. } => Some(Notice::FrictionUnknown),
        // A contact that is still being judged; and softness is no reason to stop closing.
        Event::Located { .. }
        | Event::Ambiguous { .. }
        | Event::Unusual { .. }
        | Event::Stiffness { .. } => None,
    }
}

/// What an event after the first contact means for the motion.
pub fn followed_notice(event: &Followed) -> Option<Notice> {
    matches!(event, Followed::Grasp { .. }).then_some(Notice::Settled)
}
