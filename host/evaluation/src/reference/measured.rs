//! A measured torque-angle curve, what is known of its noise and of the finger, and what a contact would make of it.

use nalgebra::DMatrix;

use super::rolling::{Rolling, Touch};

/// Unknowns besides place and radius: onset, contact friction, torque factor, joint, cable, stiffening.
pub const BESIDE: usize = 6;
/// Bound of an unknown, in deviations.
const MOST_DEVIATIONS: f64 = 6.0;
/// Torque at which the cable's twist is given, newton metre.
pub(super) const MIDDLE_NM: f64 = 0.17;
/// Parts of a point within which a contact begins.
const PARTS: u8 = 8;

/// A point of a measured curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Measured angle of the input link, radian.
    pub angle_rad: f64,
    /// Second.
    pub time_s: f64,
    /// Torque above friction, nominal, newton metre.
    pub excess_nm: f64,
    /// The same, delayed by the creep of the cable.
    pub late_nm: f64,
    /// Variance of its white noise.
    pub variance_nm2: f64,
    /// Angle over which it is a mean, radian.
    pub width_rad: f64,
    /// Turns of the motor in it.
    pub blocks: f64,
    /// Angle of the worm, turns.
    pub worm_turns: f64,
}

/// A measured curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// By rising angle.
    pub samples: Vec<Sample>,
    /// Share of the cable's twist that creeps.
    pub creep: f64,
}

/// Means and deviations of what is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Priors {
    /// Measured angle at the onset, radian.
    pub onset_rad: [f64; 2],
    /// Coefficient of contact friction, at least 0.
    pub friction: [f64; 2],
    /// Torque factor.
    pub factor: [f64; 2],
    /// Friction or preload of joint 2, newton metre.
    pub joint_nm: [f64; 2],
    /// Twist of the cable, radian per newton metre.
    pub cable_rad_per_nm: [f64; 2],
    /// Its stiffening, per newton metre, at least 0.
    pub stiffening_per_nm: [f64; 2],
    /// Half the phalanx's thickness, metre.
    pub half_thickness_m: f64,
    /// Least and largest radius of objects, metre.
    pub object_m: [f64; 2],
}

/// Noise of a curve, standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Level of the friction, newton metre.
    pub level_nm: f64,
    /// Its trend, newton metre per second.
    pub trend_nm_per_s: f64,
    /// Its wander, newton metre.
    pub wander_nm: f64,
    /// Time constant of the wander, second.
    pub wander_s: f64,
    /// Wave of the efficiency over a turn of the worm, as a share of the load.
    pub wave: f64,
    /// The rest of the efficiency, and the turns of the worm over which it is correlated.
    pub rest: [f64; 2],
    /// White noise of the efficiency in a turn of the motor, as a share of the load.
    pub white: f64,
    /// Bounce at contact, newton metre, and the angle over which it dies, radian.
    pub impact: [f64; 2],
    /// Measured angle, radian.
    pub angle_rad: f64,
}

/// One place with its radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Distance from the joint, metre.
    pub k_m: f64,
    /// Radius of the object, metre.
    pub object_m: f64,
}

fn square(x: f64) -> f64 {
    x * x
}

impl Noise {
    /// Covariance of a curve's residuals but for what depends on the unknowns, which is on its diagonal.
    #[must_use]
    pub fn covariance(&self, curve: &Curve) -> DMatrix<f64> {
        let n = curve.samples.len();
        let load = |i: usize| curve.samples[i].excess_nm.max(0.0);
        DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (&curve.samples[i], &curve.samples[j]);
            let turns = (a.worm_turns - b.worm_turns).abs();
            let wave = square(self.wave) * 0.5 * (std::f64::consts::TAU * turns).cos();
            let rest = square(self.rest[0]) * (-turns / self.rest[1]).exp();
            let apart_s = (a.time_s - b.time_s).abs();
            let friction = square(self.level_nm)
                + square(self.trend_nm_per_s) * a.time_s * b.time_s
                + square(self.wander_nm) * (-apart_s / self.wander_s).exp();
            let white = a.variance_nm2 + square(self.white * load(i)) / a.blocks;
            let own = if i == j { white } else { 0.0 };
            friction + load(i) * load(j) * (wave + rest) + own
        })
    }

    /// Lower triangle of the Cholesky factor of that covariance, with what depends on onset and predicted torques: the bounce at contact,
    /// and the measured angle's share, which follows from their slope.
    #[must_use]
    pub fn whitening(
        &self,
        covariance: &DMatrix<f64>,
        curve: &Curve,
        onset_rad: f64,
        torques: &[f64],
    ) -> Option<DMatrix<f64>> {
        let mut covariance = covariance.clone();
        let samples = &curve.samples;
        for (i, sample) in samples.iter().enumerate() {
            let past_rad = sample.angle_rad + 0.5 * sample.width_rad - onset_rad;
            if past_rad >= 0.0 {
                let bounce_nm = self.impact[0] * (-past_rad / self.impact[1]).exp();
                covariance[(i, i)] += square(bounce_nm);
            }
            if let Some(before) = i.checked_sub(1) {
                let way_rad = sample.angle_rad - samples[before].angle_rad;
                let slope = (torques[i] - torques[before]) / way_rad;
                covariance[(i, i)] += square(self.angle_rad * slope);
            }
        }
        Some(covariance.cholesky()?.unpack())
    }
}

impl Priors {
    fn spreads(&self) -> [[f64; 2]; BESIDE] {
        [
            self.onset_rad,
            self.friction,
            self.factor,
            self.joint_nm,
            self.cable_rad_per_nm,
            self.stiffening_per_nm,
        ]
    }

    /// Values drawn with normal deviates, within their bounds.
    pub fn drawn(&self, mut normal: impl FnMut() -> f64) -> [f64; BESIDE] {
        let mut z = [0.0; BESIDE];
        for (z, [low, high]) in z.iter_mut().zip(self.bounds()) {
            *z = normal();
            while !(low..=high).contains(z) {
                *z = normal();
            }
        }
        self.values(&z)
    }

    /// Values from whitened unknowns.
    pub(super) fn values(&self, z: &[f64; BESIDE]) -> [f64; BESIDE] {
        let spreads = self.spreads();
        std::array::from_fn(|i| spreads[i][0] + spreads[i][1] * z[i])
    }

    /// Bounds in deviations.
    pub(super) fn bounds(&self) -> [[f64; 2]; BESIDE] {
        let least = [
            f64::NEG_INFINITY,
            0.0,
            0.2 * self.factor[0],
            f64::NEG_INFINITY,
            0.1 * self.cable_rad_per_nm[0],
            0.0,
        ];
        let spreads = self.spreads();
        std::array::from_fn(|i| {
            let lowest = (least[i] - spreads[i][0]) / spreads[i][1];
            [lowest.max(-MOST_DEVIATIONS), MOST_DEVIATIONS]
        })
    }
}

/// Excess torque at every sample for given values of the unknowns.
#[must_use]
pub fn predicted(
    rolling: &Rolling,
    curve: &Curve,
    place: &Place,
    half_thickness_m: f64,
    values: &[f64; BESIDE],
) -> Option<Vec<f64>> {
    let &[onset_rad, friction, factor, joint_nm, cable, stiffening] = values;
    let touch = Touch {
        k_m: place.k_m,
        radius_m: place.object_m + half_thickness_m,
        half_thickness_m,
        friction,
        joint_nm,
    };
    let (mut before_rad, mut rad) = (0.0, 1e-3);
    // A joint that holds leaves the cable alone to turn.
    let breaks_nm = rolling.rolled(&touch, 0.0)?.torque_nm.max(0.0) / factor;
    let mut at = |angle_rad: f64, late_nm: f64| -> Option<f64> {
        let twist = |nm: f64| nm - stiffening * nm * (0.5 * nm - MIDDLE_NM) + curve.creep * late_nm;
        let past_rad = angle_rad - onset_rad;
        if past_rad <= 0.0 {
            return Some(0.0);
        }
        if past_rad <= cable * twist(breaks_nm) {
            return Some((past_rad / cable).min(breaks_nm));
        }
        let found = rolling.solve(&touch, [rad, before_rad], past_rad, |rolled| {
            rolled.rotation_rad + cable * twist(rolled.torque_nm / factor)
        })?;
        if (found - rad).abs() > 1e-6 {
            (before_rad, rad) = (rad, found);
        }
        Some(rolling.rolled(&touch, found)?.torque_nm / factor)
    };
    let mut found: Vec<f64> = Vec::with_capacity(curve.samples.len());
    for sample in &curve.samples {
        let past_rad = sample.angle_rad - onset_rad;
        let near = past_rad.abs() < 0.5 * sample.width_rad;
        let parts = if near { PARTS } else { 1 };
        let mut sum = 0.0;
        for part in 0..parts {
            let share = (f64::from(part) + 0.5) / f64::from(parts) - 0.5;
            sum += at(sample.angle_rad + share * sample.width_rad, sample.late_nm)?;
        }
        found.push(sum / f64::from(parts));
    }
    Some(found)
}
