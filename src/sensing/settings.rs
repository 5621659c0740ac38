//! Settings of the sensing, and directives from the sequence.

#[cfg(not(weightless))]
use crate::finger::Mounting;
use crate::numeric::Bounded;

/// Settings of the sensing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The one steady speed of the input link at which friction is recorded and contacts are felt, radian per second.
    /// The worm's friction depends on speed.
    pub speed_rad_per_s: f32,
    /// Blocks whose speed differs from that of their run by more than this share are not used.
    pub speed_tolerance: f32,
    /// Travel of the input link after a start that is not used, radian: the drivetrain does not run steadily yet.
    pub settle_rad: f32,
    /// Travel of a free closing from the opening stop, radian; ends short of the closing stop.
    pub travel_rad: f32,
    /// False contacts per thousand free closings, 1e-6 to 100: the detector's threshold follows from it. A smaller value delays
    /// detection.
    pub false_contacts_per_thousand: f32,
    /// Standard deviation of the location at which probing may end, metre.
    pub wanted_sigma_m: f32,
    /// Largest torque at the input link while probing, newton metre.
    pub torque_limit_nm: f32,
    /// Angle of the input link from the opening stop to the closing stop, radian.
    pub closing_stop_rad: f32,
    /// Half the thickness of a phalanx, metre: its surface lies this far from the centre line.
    pub half_thickness_m: f32,
    /// Radius of a pin that calibrates, metre.
    pub pin_radius_m: f32,
    /// Coefficient of friction between phalanx and object: mean and deviation.
    pub contact_friction: [f32; 2],
    /// Friction of each joint beyond the first, newton metre: mean and deviation.
    pub joint_friction_nm: [f32; 2],
    /// Torque with which springs hold these joints at their stops in a finger without a spring at joint 1, newton metre: mean and
    /// deviation.
    pub preload_nm: [f32; 2],
    /// Forces over those that the scene's springs would have, where a scale has told: the springs' stiffness, on which no location
    /// depends, and what contact friction changes.
    pub force_scale: Option<f32>,
    /// Standard deviation of the object's compliance from zero, metre per newton, above 0 where objects may be soft
    /// ([`SoftObject`](super::SoftObject)).
    pub object_give_m_per_n: f32,
    /// Standard deviation of the finger's leverage from one place of contact to another, as a share: lengths of pulleys and links that
    /// differ from the scene's, and losses on them.
    pub leverage_sigma: f32,
    /// Amplitude of the transmission error over a turn of the worm, radian; 0 where it is not known: contacts are judged without one then,
    /// calibrations with that of a poor wheel.
    pub worm_error_rad: f32,
    /// How a finger whose weight is stated hangs, if not as it was built; no other finger reads it.
    #[cfg(not(weightless))]
    pub mounting: Option<Mounting>,
    /// Root mean square of the motor's torque, as [`Block::drive_torque_nm`](super::block::Block::drive_torque_nm), with which the finger
    /// swings in its cable and on its springs after a motion has begun, newton metre per radian per second of that motion.
    pub swing_rms_nm_s_per_rad: f32,
}

/// Standard deviation of the place on the scene's finger at which a pin is felt, metre: of the pin by hand or by a gauge
/// 0.3 mm (R, chosen), of the finger 0.4 mm, because its links are within 0.15 mm of the scene's (R; docs/SENSING.md#pins).
pub const PIN_SIGMA_M: f32 = 0.5e-3;
/// Smallest standard deviation of an onset, radian: a tenth of a second of motion.
pub const ONSET_SIGMA_RAD: f32 = 0.03;

/// Share of the torque limit at which the last word on a contact is due: the finger goes on closing meanwhile.
const ENOUGH: f32 = 0.95;

impl Settings {
    /// Mean and deviation of contact friction of which a user says that it is about so much: a third of it, and no less than these
    /// settings have.
    pub fn rubbed_with(&self, mean: f32) -> [f32; 2] {
        let [_, deviation] = self.contact_friction;
        [mean, deviation.at_least(mean / 3.0)]
    }

    /// Effective contact radius of a pin that calibrates, metre: it touches the surface, places are measured on the centre line.
    pub fn pin_contact_radius_m(&self) -> f32 {
        self.pin_radius_m + self.half_thickness_m
    }

    /// Torque above friction at which the last word on a contact, or on how the object is held, is due, newton metre.
    pub fn enough_nm(&self) -> f32 {
        ENOUGH * self.torque_limit_nm
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            speed_rad_per_s: 0.3,
            // A stiff contact slows the motor by a tenth; at twice that the friction changes.
            speed_tolerance: 0.2,
            // In recordings of a physics engine every false contact of an earlier detector began within this distance.
            settle_rad: 0.08,
            travel_rad: 1.5,
            false_contacts_per_thousand: 0.01,
            wanted_sigma_m: 0.3e-3,
            torque_limit_nm: 0.35,
            closing_stop_rad: 1.6,
            half_thickness_m: 0.006,
            pin_radius_m: 0.005,
            // Smooth skin on wood, metal or plastics without lubricant would be 0.1 to 0.3; a phalanx of polished plastics or
            // metal less (R, chosen).
            contact_friction: [0.1, 0.1],
            // Pins of some millimetre in plain bearings, up to 10 N (R, chosen).
            joint_friction_nm: [0.2e-3, 0.4e-3],
            preload_nm: [0.0; 2],
            force_scale: None,
            object_give_m_per_n: 0.0,
            leverage_sigma: 0.0,
            worm_error_rad: 0.0,
            #[cfg(not(weightless))]
            mounting: None,
            swing_rms_nm_s_per_rad: 0.0,
        }
    }
}

/// Use of the samples that follow. Given by the sequence, in a replay by the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Directive {
    /// Ignore the motion.
    #[default]
    Rest,
    /// The finger moves freely, closing and opening: record friction. Ends with the next directive.
    RecordFriction,
    /// The finger closes, perhaps on an object: detect a contact and locate it.
    Watch,
    /// As `Watch`, on a contact at a known place: calibrate.
    Calibrate {
        /// Phalanx in contact, from 2.
        phalanx: u8,
        /// Distance of the contact from the phalanx's joint, metre.
        k_m: f32,
    },
    /// The finger is driven against the closing stop, where it is rigid: calibrate the cable.
    CalibrateCable,
}
