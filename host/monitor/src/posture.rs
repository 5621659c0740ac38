//! Posture of the phalanges at an encoder position, by the finger's own mechanics: free until touch, along the contact's path
//! afterwards.

use palpate::finger::{Contact, Mechanics};

/// The finger as points in the plane, metre: joint 1 first, the tip last; x along phalanx 1 at theta_1 = 0, y to its palm
/// side.
pub type Points = Vec<[f64; 2]>;

/// A finger that can be drawn.
pub trait FingerView {
    /// Its points at an input angle (radian from the opening stop), `touch` being a contact and the input angle at which it
    /// began. `None` where the finger cannot be so.
    fn points(&mut self, theta_a_rad: f64, touch: Option<Touch>) -> Option<Points>;

    /// Lengths of the phalanges, metre.
    fn lengths_m(&self) -> Vec<f64>;

    /// Torque above the one at contact against the encoder's angle, cable twist included, for a contact: (radian from the
    /// opening stop, newton metre).
    fn curve(&self, touch: Touch, most_nm: f64) -> Vec<(f64, f64)>;

    /// What turns counts and amperes into angles and torques.
    fn scales(&self) -> Scales;
}

/// Nominal scales of a drivetrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Input angle per encoder count, radian.
    pub rad_per_count: f64,
    /// Torque at the input link per ampere if nothing were lost, newton metre.
    pub nm_per_a: f64,
    /// Share of a load's torque that the gears pass on, 0 to 1.
    pub efficiency: f64,
    /// Compliance of the cable, radian per newton metre; 0 where there is none.
    pub cable_rad_per_nm: f64,
}

/// A contact to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Input angle at which it began, radian from the opening stop.
    pub theta_a_rad: f64,
    /// Phalanx, 1 for the proximal one.
    pub phalanx: u32,
    /// Distance from its joint, metre.
    pub k_m: f64,
    /// Effective contact radius, metre.
    pub radius_m: f64,
    /// Compliance of the cable between encoder and input link, radian per newton metre.
    pub cable_rad_per_nm: f64,
}

/// The finger of a scene.
pub struct SceneFinger<F: Mechanics> {
    finger: F,
    near: F::Configuration,
    opening_stop_rad: f64,
    scales: Scales,
}

/// Points of a drawn curve.
const CURVE_POINTS: u8 = 40;

impl<F: Mechanics> SceneFinger<F> {
    /// For a finger whose input link stands at `opening_stop_rad` at the opening stop.
    pub fn new(finger: F, opening_stop_rad: f64, scales: Scales) -> Self {
        Self {
            near: finger.rest(),
            finger,
            opening_stop_rad,
            scales,
        }
    }

    fn joints(&self, at: &F::Configuration, change: [f32; 3]) -> Vec<f64> {
        (1..=F::PHALANGES)
            .map_while(|joint| {
                let angle = self.finger.joint_rad(at, joint as u8)?;
                Some(f64::from(angle + change.get(joint - 1)?))
            })
            .collect()
    }

    fn free(&self, theta_a_rad: f64, near: &F::Configuration) -> Option<(F::Configuration, f32)> {
        let free = self
            .finger
            .free_at_angle((self.opening_stop_rad + theta_a_rad) as f32, near)?;
        Some((free.configuration, free.torque_nm))
    }

    fn path(&self, touch: Touch) -> Option<(F::Configuration, F::Path)> {
        let (at, torque_nm) = self.free(touch.theta_a_rad, &self.near)?;
        let contact = Contact {
            phalanx: u8::try_from(touch.phalanx).ok()?,
            k_m: touch.k_m as f32,
            radius_m: touch.radius_m as f32,
        };
        Some((at, self.finger.path(&at, torque_nm, contact)?))
    }

    fn place(&self, joints: &[f64]) -> Points {
        let mut points = vec![[0.0, 0.0]];
        let (mut alpha, mut x, mut y) = (0.0f64, 0.0, 0.0);
        for (angle, length) in joints.iter().zip(self.lengths_m()) {
            alpha += angle;
            x += length * alpha.cos();
            y += length * alpha.sin();
            points.push([x, y]);
        }
        points
    }
}

impl<F: Mechanics> FingerView for SceneFinger<F> {
    fn points(&mut self, theta_a_rad: f64, touch: Option<Touch>) -> Option<Points> {
        let Some(touch) = touch.filter(|touch| theta_a_rad > touch.theta_a_rad) else {
            let (at, _) = self.free(theta_a_rad, &self.near)?;
            self.near = at;
            return Some(self.place(&self.joints(&at, [0.0; 3])));
        };
        let (at, mut path) = self.path(touch)?;
        let wanted = theta_a_rad - touch.theta_a_rad;
        // The rise of torque that turns the input link so far: doubled until it does, or the path ends.
        let mut change = [0.0; 3];
        let mut rise_nm = 1e-3;
        while let Some(point) = self.finger.follow(&mut path, rise_nm) {
            change = point.joints_rad;
            let twist = f64::from(rise_nm) * touch.cable_rad_per_nm;
            if f64::from(point.rotation_rad) + twist >= wanted || rise_nm > 1.0 {
                break;
            }
            rise_nm *= 1.25;
        }
        Some(self.place(&self.joints(&at, change)))
    }

    fn lengths_m(&self) -> Vec<f64> {
        (1..=F::PHALANGES)
            .map_while(|phalanx| self.finger.phalanx_length_m(phalanx as u8).map(f64::from))
            .collect()
    }

    fn curve(&self, touch: Touch, most_nm: f64) -> Vec<(f64, f64)> {
        let Some((_, mut path)) = self.path(touch) else {
            return Vec::new();
        };
        let mut curve = vec![(touch.theta_a_rad, 0.0)];
        for step in 1..=CURVE_POINTS {
            let rise_nm = most_nm * f64::from(step) / f64::from(CURVE_POINTS);
            let Some(point) = self.finger.follow(&mut path, rise_nm as f32) else {
                break;
            };
            let twist = rise_nm * touch.cable_rad_per_nm;
            let rotation = f64::from(point.rotation_rad) + twist;
            curve.push((touch.theta_a_rad + rotation, rise_nm));
        }
        curve
    }

    fn scales(&self) -> Scales {
        self.scales
    }
}
