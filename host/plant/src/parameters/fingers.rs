//! Geometry of the finger.

use super::within;
use crate::{Error, linkage::Fourbar};
use serde::Deserialize;

/// One finger, lists from the proximal to the distal end.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct FingerParameters {
    /// Phalanges, metre.
    pub length_m: Vec<f64>,
    /// Phalanx 1 lies within the palm and touches nothing.
    #[serde(default)]
    pub hidden_base: bool,
    /// Joint springs, newton metre per radian; the first may be zero.
    pub spring_nm_per_rad: Vec<f64>,
    /// Rest angles of the springs, degree.
    pub rest_deg: Vec<f64>,
    /// Lower mechanical stops of the joints, degree.
    pub joint_min_deg: Vec<f64>,
    /// Upper mechanical stops of the joints, degree.
    pub joint_max_deg: Vec<f64>,
    /// Travel of the input link between its opening and closing stop, radian.
    pub travel_rad: f64,
    /// Tendon: radii of the pulleys, `[r_1, r_2]` or `[r_1, r_2, r_3, r_4]`, metre.
    #[serde(default)]
    pub pulley_m: Vec<f64>,
    /// Linkage: driving levers a, metre.
    #[serde(default)]
    pub lever_m: Vec<f64>,
    /// Linkage: couplers b, metre.
    #[serde(default)]
    pub coupler_m: Vec<f64>,
    /// Linkage: driven levers c, metre.
    #[serde(default)]
    pub driven_m: Vec<f64>,
    /// Linkage: angle psi between driven lever and phalanx, degree, positive dorsal.
    #[serde(default)]
    pub offset_deg: Vec<f64>,
    /// Linkage: assembly, 1 or -1.
    #[serde(default)]
    pub mode: Vec<f64>,
    /// A motor at every joint: of each joint from the second, how far it can turn between the flanks of the worm wheel that
    /// holds it, degree. Its spring lies between the wheel and the joint, at rest in the middle.
    #[serde(default)]
    pub held_backlash_deg: Vec<f64>,
    /// A cable that opens the finger in place of springs: radius of its pulley at each joint, metre.
    #[serde(default)]
    pub return_pulley_m: Vec<f64>,
    /// Its tension with the finger open, newton.
    #[serde(default)]
    pub return_tension_n: f64,
    /// Stiffness of its spring, newton per metre.
    #[serde(default)]
    pub return_n_per_m: f64,
    /// What the scene states of the phalanges' masses, kilogram; empty where it states none. Nothing here weighs so: the world says.
    #[serde(default)]
    pub stated_mass_kg: Vec<f64>,
}

impl FingerParameters {
    /// Lengths that are subject to tolerances: phalanges, pulleys, levers and couplers.
    pub(super) fn lengths_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.length_m
            .iter_mut()
            .chain(&mut self.pulley_m)
            .chain(&mut self.return_pulley_m)
            .chain(&mut self.lever_m)
            .chain(&mut self.coupler_m)
            .chain(&mut self.driven_m)
    }

    pub(super) fn validate(&self, key: &str) -> Result<(), Error> {
        let phalanges = self.length_m.len();
        if !(2..=3).contains(&phalanges) {
            return Err(Error::WrongLength {
                key: format!("{key}.length_m"),
                found: phalanges,
                expected: phalanges.clamp(2, 3),
            });
        }
        let list = |name: &str, values: &[f64], count: usize, min: f64, max: f64| {
            let key = format!("{key}.{name}");
            if values.len() != count {
                return Err(Error::WrongLength {
                    key,
                    found: values.len(),
                    expected: count,
                });
            }
            (0..)
                .zip(values)
                .try_for_each(|(i, &value)| within(&format!("{key}[{i}]"), value, min, max))
        };
        list("length_m", &self.length_m, phalanges, 1e-3, 10.0)?;
        list(
            "spring_nm_per_rad",
            &self.spring_nm_per_rad,
            phalanges,
            0.0,
            1e3,
        )?;
        if self.return_pulley_m.is_empty() {
            for (i, &spring) in self.spring_nm_per_rad.iter().enumerate().skip(1) {
                within(&format!("{key}.spring_nm_per_rad[{i}]"), spring, 1e-6, 1e3)?;
            }
        } else {
            list(
                "return_pulley_m",
                &self.return_pulley_m,
                phalanges,
                1e-4,
                1.0,
            )?;
            within(
                &format!("{key}.return_tension_n"),
                self.return_tension_n,
                1e-3,
                1e4,
            )?;
            within(
                &format!("{key}.return_n_per_m"),
                self.return_n_per_m,
                1e-3,
                1e7,
            )?;
        }
        list("rest_deg", &self.rest_deg, phalanges, -90.0, 180.0)?;
        list(
            "joint_min_deg",
            &self.joint_min_deg,
            phalanges,
            -180.0,
            180.0,
        )?;
        list(
            "joint_max_deg",
            &self.joint_max_deg,
            phalanges,
            -180.0,
            180.0,
        )?;
        for i in 0..phalanges {
            within(
                &format!("{key}.joint_max_deg[{i}]"),
                self.joint_max_deg[i],
                self.joint_min_deg[i],
                180.0,
            )?;
        }
        within(&format!("{key}.travel_rad"), self.travel_rad, 0.01, 6.0)?;
        let kinds = [&self.lever_m, &self.pulley_m, &self.held_backlash_deg];
        if kinds.iter().filter(|values| !values.is_empty()).count() != 1 {
            return Err(Error::Transmission {
                key: key.to_owned(),
            });
        }
        if !self.held_backlash_deg.is_empty() {
            let held = &self.held_backlash_deg;
            list("held_backlash_deg", held, phalanges - 1, 0.0, 10.0)
        } else if !self.lever_m.is_empty() {
            let stages = phalanges - 1;
            list("lever_m", &self.lever_m, stages, 1e-4, 10.0)?;
            list("coupler_m", &self.coupler_m, stages, 1e-4, 10.0)?;
            list("driven_m", &self.driven_m, stages, 1e-4, 10.0)?;
            list("offset_deg", &self.offset_deg, stages, -180.0, 180.0)?;
            list("mode", &self.mode, stages, -1.0, 1.0)?;
            for i in 0..stages {
                if self.mode[i].abs() != 1.0 {
                    let key = format!("{key}.mode[{i}]");
                    return Err(Error::OutOfRange {
                        key,
                        value: self.mode[i],
                        min: -1.0,
                        max: 1.0,
                    });
                }
                self.closes(key, i)?;
            }
            Ok(())
        } else {
            list("pulley_m", &self.pulley_m, 2 * (phalanges - 1), 1e-4, 1.0)
        }
    }

    /// Stage `i` (from 0) as a four-bar.
    pub(crate) fn fourbar(&self, i: usize) -> Fourbar {
        Fourbar {
            ground: self.length_m[i],
            lever: self.lever_m[i],
            coupler: self.coupler_m[i],
            driven: self.driven_m[i],
            offset: self.offset_deg[i].to_radians(),
            mode: self.mode[i],
        }
    }

    /// The loop must close over the joint's own range.
    fn closes(&self, key: &str, stage: usize) -> Result<(), Error> {
        let fourbar = self.fourbar(stage);
        let (low, high) = (self.joint_min_deg[stage + 1], self.joint_max_deg[stage + 1]);
        for step in 0..=40 {
            let angle_deg = low + (high - low) * f64::from(step) / 40.0;
            if fourbar.assemble(angle_deg.to_radians()).is_none() {
                return Err(Error::Open {
                    key: key.to_owned(),
                    stage: stage + 1,
                    angle_deg,
                });
            }
        }
        Ok(())
    }
}
