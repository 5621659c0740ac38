//! What is known of a recording: `NAME.json` next to `NAME.csv.gz`.
//!
//! To the sensing goes the class and the place of a calibration pin, nothing else; the rest is for judging.

use serde::Deserialize;

use crate::score::Contact;

/// Class of a recording, as the file has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The free finger, driven against its closing stop: calibrates the cable.
    Press,
    /// A pin at a known place: calibrates the torque factor.
    Pin,
    /// Nothing is there.
    Free,
    /// A contact on the distal phalanx.
    Distal,
    /// A contact on the proximal phalanx.
    Proximal,
    /// An object that yields, that grips, or that touches twice.
    Hard,
}

impl Class {
    /// Name, as the file has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Press => "press",
            Self::Pin => "pin",
            Self::Free => "free",
            Self::Distal => "distal",
            Self::Proximal => "proximal",
            Self::Hard => "hard",
        }
    }

    /// It calibrates: in the order in which a user would, the press first.
    #[must_use]
    pub fn calibrates(self) -> bool {
        matches!(self, Self::Press | Self::Pin)
    }
}

#[derive(Clone, Debug, Deserialize)]
struct FirstContact {
    time_s: Option<f64>,
    phalanx_first: u8,
    k_first_mm: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
struct Effective {
    #[serde(rename = "Nm_per_measured_A")]
    nm_per_measured_a: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct Drive {
    #[serde(rename = "Kt")]
    cable_nm_per_rad: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct Object {
    stiffness: Option<f64>,
}

/// One line of the track: time, torque, f1, k1, f2, k2, theta_1, theta_2.
type TrackRow = (f64, f64, f64, Option<f64>, f64, Option<f64>, f64, f64);

/// The truth of a recording.
#[derive(Clone, Debug, Deserialize)]
pub struct Truth {
    /// Class.
    #[serde(rename = "cls")]
    pub class: Class,
    /// Place of a calibration pin from joint 2, metre.
    #[serde(rename = "k_nominal")]
    pub nominal_k_m: Option<f64>,
    /// Spring of joint 2, newton metre per radian.
    #[serde(rename = "K2")]
    pub spring_nm_per_rad: f64,
    contact: FirstContact,
    object: Option<Object>,
    effective: Effective,
    drive: Drive,
    #[serde(default)]
    track: Vec<TrackRow>,
}

impl Truth {
    /// First contact; the phalanx's length is looked up by its number. `None` for a free closing.
    #[must_use]
    pub fn contact(&self, length_m: impl Fn(u8) -> f64) -> Option<Contact> {
        let FirstContact {
            time_s: Some(time_s),
            phalanx_first: phalanx,
            k_first_mm: Some(k_mm),
        } = self.contact
        else {
            return None;
        };
        Some(Contact {
            phalanx,
            k_m: 1e-3 * k_mm,
            length_m: length_m(phalanx),
            time_s,
        })
    }

    /// Stiffness of the springs that hold the object, newton per metre; `None` of a fixed one.
    #[must_use]
    pub fn object_n_per_m(&self) -> Option<f64> {
        self.object.as_ref()?.stiffness
    }

    /// Contact force on a phalanx at an instant, newton, between the lines of the track; beyond its ends the end's.
    #[must_use]
    pub fn force_n(&self, time_s: f64, phalanx: u8) -> f64 {
        let force = |row: &TrackRow| if phalanx == 1 { row.2 } else { row.4 };
        let after = self.track.partition_point(|row| row.0 < time_s);
        match (
            after.checked_sub(1).and_then(|i| self.track.get(i)),
            self.track.get(after),
        ) {
            (Some(a), Some(b)) => {
                let share = (time_s - a.0) / (b.0 - a.0);
                force(a) + share * (force(b) - force(a))
            }
            (Some(row), None) | (None, Some(row)) => force(row),
            (None, None) => f64::NAN,
        }
    }

    /// Torque factor that a perfect calibration would find: (torque at the input link per measured ampere) / K_2, over
    /// the nominal ratio.
    #[must_use]
    pub fn torque_factor(&self, nominal_nm_per_a: f64, nominal_spring_nm_per_rad: f64) -> f64 {
        self.effective.nm_per_measured_a / nominal_nm_per_a * nominal_spring_nm_per_rad
            / self.spring_nm_per_rad
    }

    /// Twist of the cable per newton metre of nominal torque that a perfect calibration would find, radian.
    #[must_use]
    pub fn cable_rad_per_nm(&self, nominal_nm_per_a: f64) -> f64 {
        self.effective.nm_per_measured_a / nominal_nm_per_a / self.drive.cable_nm_per_rad
    }
}
