//! What the engine's model of a finger and an object is made from.

mod xml;

use crate::assembly::Stage;
use crate::surroundings::{Mount, Surroundings};
use palpate_plant::{Error, FingerParameters, Object, Parameters};

/// Steps of the engine, second: four control periods, or one where the cable's own vibration is too fast for more (no cable fitted)
/// or the object moves.
/// A step of the engine costs ten times one of all the rest; what its length costs in accuracy stands in `tests/step.rs`.
const STEPS_S: [f64; 2] = [200e-6, 50e-6];
/// Largest angle of the cable's vibration in a step, radian.
const CABLE_RAD: f64 = 0.1;
/// Least mass of a phalanx: the engine has no bodies without, kilogram per metre.
const LEAST_KG_PER_M: f64 = 0.02;
/// Name of the tendon that the cable pulls.
pub(crate) const INPUT: &str = "input";

/// What of a finger goes into its model.
#[derive(Clone, Debug)]
pub(crate) struct Description {
    pub finger: FingerParameters,
    spring: Vec<f64>,
    /// Stiffness of the springs over the nominal one: that of a return cable's spring too.
    spring_made: f64,
    /// Share of their stiffness that the springs have left.
    pub springs_left: f64,
    rest: Vec<f64>,
    /// Angle by which springs are preloaded.
    preload_rad: f64,
    /// Joint angles at the opening stop.
    start: Vec<f64>,
    gravity: [f64; 2],
    pub joint_friction: f64,
    /// Friction of a tendon on the pulleys of joints from 2, as a share of the torque that it passes there.
    pub capstan_share: f64,
    density: f64,
    half_thickness: f64,
    damping: f64,
    friction: f64,
    surroundings: Surroundings,
    /// Step of the engine, second.
    pub step_s: f64,
    pub stages: Vec<Stage>,
    /// theta_a at the opening and closing stop.
    pub stops: [f64; 2],
}

/// The longest of the [`STEPS_S`] that cable and object allow.
pub(crate) fn usual_step_s(parameters: &Parameters, surroundings: &Surroundings) -> f64 {
    let inertia = inertia(
        parameters
            .mechanism
            .linear_density_kg_per_m
            .max(LEAST_KG_PER_M),
        &parameters.finger,
    );
    let per_s = (parameters.cable_stiffness_nm_per_rad() / inertia).sqrt();
    let [long, short] = STEPS_S;
    if long * per_s < CABLE_RAD && surroundings.mount == Mount::Fixed {
        long
    } else {
        short
    }
}

/// Inertia of the straight finger about joint 1, kilogram square metre.
fn inertia(kg_per_m: f64, finger: &FingerParameters) -> f64 {
    kg_per_m * finger.length_m.iter().sum::<f64>().powi(3) / 3.0
}

impl Description {
    /// Holds objects as this says, from the next model on, with the step that it needs.
    pub fn hold(&mut self, parameters: &Parameters, object: &Object) {
        self.surroundings = Surroundings::from(object);
        self.step_s = usual_step_s(parameters, &self.surroundings);
    }

    pub fn new(
        parameters: &Parameters,
        surroundings: &Surroundings,
        step_s: f64,
    ) -> Result<Self, Error> {
        let finger = parameters.finger.clone();
        let mechanism = &parameters.mechanism;
        let radians = |list: &[f64]| -> Vec<f64> { list.iter().map(|d| d.to_radians()).collect() };
        let (mut rest, low) = (radians(&finger.rest_deg), radians(&finger.joint_min_deg));
        if finger.spring_nm_per_rad.first() == Some(&0.0)
            && finger.return_pulley_m.is_empty()
            && let Some(first) = rest.first_mut()
        {
            // Without a spring nothing defines where joint 1 rests; it opens until theta_1 is zero.
            *first = 0.0;
        }
        // A spring is preloaded against the stop that it holds its joint at.
        for (rest, low) in rest.iter_mut().zip(&low).skip(1) {
            if *rest < low + 1e-6 {
                *rest -= mechanism.preload_deg.to_radians();
            }
        }
        let start: Vec<f64> = rest.iter().zip(&low).map(|(r, l)| r.max(*l)).collect();
        let (sin, cos) = mechanism.mounting_deg.to_radians().sin_cos();
        let mut description = Self {
            spring_made: 1.0 + mechanism.spring_error,
            spring: finger
                .spring_nm_per_rad
                .iter()
                .map(|k| k * (1.0 + mechanism.spring_error))
                .collect(),
            springs_left: 1.0,
            rest,
            preload_rad: mechanism.preload_deg.to_radians(),
            start,
            gravity: [cos, sin].map(|share| share * mechanism.gravity_m_per_s2),
            joint_friction: mechanism.joint_friction_nm,
            capstan_share: if finger.lever_m.is_empty() {
                mechanism.capstan_share
            } else {
                0.0
            },
            density: mechanism.linear_density_kg_per_m.max(LEAST_KG_PER_M),
            half_thickness: mechanism.phalanx_half_thickness_m,
            damping: mechanism.damping_nm_s_per_rad,
            friction: parameters.contact.friction,
            surroundings: surroundings.clone(),
            step_s,
            stages: (0..2).filter_map(|i| Stage::of(&finger, i)).collect(),
            stops: [0.0, finger.travel_rad],
            finger,
        };
        let opening = description.theta_a(&description.start)?;
        description.stops = [opening, opening + description.stops[1]];
        Ok(description)
    }

    pub fn phalanges(&self) -> usize {
        self.finger.length_m.len()
    }

    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Joints that a motor of their own holds, and the angles between which its worm wheel leaves them free.
    fn held(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        (1..)
            .zip(&self.finger.held_backlash_deg)
            .map(|(i, backlash_deg)| {
                let half = 0.5 * backlash_deg.to_radians();
                (i, [self.rest[i] - half, self.rest[i] + half])
            })
    }

    /// Stiffness of the spring of a return cable, newton per metre, and the cable's length over its pulleys without tension, metre.
    fn returned(&self) -> Option<[f64; 2]> {
        let pulleys = &self.finger.return_pulley_m;
        let stiffness = self.finger.return_n_per_m;
        // It is preloaded over the pulley of joint 1.
        let preload = pulleys.first()? * self.preload_rad;
        let at_rest: f64 = pulleys.iter().zip(&self.start).map(|(r, q)| r * q).sum();
        let slack = at_rest - preload - self.finger.return_tension_n / stiffness;
        Some([self.springs_left * self.spring_made * stiffness, slack])
    }

    /// Inertia of the straight finger about joint 1, kilogram square metre.
    pub fn inertia(&self) -> f64 {
        inertia(self.density, &self.finger)
    }

    /// Coefficients of theta_a in the joint angles, of a finger with tendons.
    pub fn ratios(&self) -> Vec<f64> {
        let mut ratios = vec![1.0];
        for pulleys in self.finger.pulley_m.chunks_exact(2) {
            let last = ratios.last().copied().unwrap_or(1.0);
            ratios.push(last * pulleys[1] / pulleys[0]);
        }
        ratios
    }

    /// Input-link angle of a posture.
    fn theta_a(&self, joints: &[f64]) -> Result<f64, Error> {
        if self.stages.is_empty() {
            return Ok(self.ratios().iter().zip(joints).map(|(x, q)| x * q).sum());
        }
        let (positions, _) = self.positions(joints)?;
        Ok(positions[0])
    }

    /// Angles of the driving levers against their zero, and of the couplers against their levers likewise.
    pub fn positions(&self, joints: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let mut levers = vec![0.0; self.stages.len()];
        let mut couplers = levers.clone();
        let mut beyond = 0.0;
        for (i, stage) in self.stages.iter().enumerate().rev() {
            let joint = joints.get(i + 1).copied().unwrap_or(0.0) + beyond;
            let (zero, now) = (self.close(i, stage, 0.0)?, self.close(i, stage, joint)?);
            beyond = now.lever - zero.lever;
            levers[i] = joints.get(i).copied().unwrap_or(0.0) + beyond;
            couplers[i] = now.coupler - now.lever - (zero.coupler - zero.lever);
        }
        Ok((levers, couplers))
    }

    fn close(&self, i: usize, stage: &Stage, joint: f64) -> Result<crate::assembly::Closed, Error> {
        stage.close(joint).ok_or(Error::Open {
            key: "finger".into(),
            stage: i + 1,
            angle_deg: joint.to_degrees(),
        })
    }
}
