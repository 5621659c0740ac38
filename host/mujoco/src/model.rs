//! The engine's model of a finger and an object, as text.
//!
//! The finger moves in the plane z = 0. A phalanx is a capsule; a cylinder across the plane is a capsule too, because
//! the engine meets two capsules exactly and its round ends are far from the plane.

use crate::assembly::Stage;
use crate::outline::{HALF_DEPTH_M, mesh, middle, polygon, rectangle};
use crate::stiffness::IMPEDANCE;
use crate::surroundings::{Mount, Surroundings};
use palpate_plant::{Body, Error, FingerParameters, Parameters};
use std::fmt::Write;

/// Steps of the engine, second: four control periods, or one where the cable's own vibration is too fast for more (no cable fitted)
/// or the object moves.
/// A step of the engine costs ten times one of all the rest; what its length costs in accuracy stands in `tests/step.rs`.
const STEPS_S: [f64; 2] = [200e-6, 50e-6];
/// Largest angle of the cable's vibration in a step, radian.
const CABLE_RAD: f64 = 0.1;
/// Mass of a lever or coupler of a linkage, kilogram (chosen: thin steel).
const ROD_KG: f64 = 5e-4;
/// Least mass of a phalanx: the engine has no bodies without, kilogram per metre.
const LEAST_KG_PER_M: f64 = 0.02;
/// How fast the engine ends slipping, per second. Stiffer than some 300 a sliding contact chatters, up to being thrown
/// across the object; from 30 to 300 the contact's path is the same within 1e-6.
const SLIP_PER_S: f64 = 200.0;
/// Name of the tendon that the cable pulls.
pub(crate) const INPUT: &str = "input";

/// What of a finger goes into its model.
#[derive(Clone, Debug)]
pub(crate) struct Description {
    pub finger: FingerParameters,
    spring: Vec<f64>,
    /// Share of their stiffness that the springs have left.
    pub springs_left: f64,
    rest: Vec<f64>,
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
            && let Some(first) = rest.first_mut()
        {
            // Without a spring nothing defines where joint 1 rests; it opens until theta_1 is zero.
            *first = 0.0;
        }
        // A spring is preloaded against the stop that it holds its joint at.
        for (rest, low) in rest.iter_mut().zip(&low).skip(1) {
            if (*rest - low).abs() < 1e-6 {
                *rest -= mechanism.preload_deg.to_radians();
            }
        }
        let start: Vec<f64> = rest.iter().zip(&low).map(|(r, l)| r.max(*l)).collect();
        let (sin, cos) = mechanism.mounting_deg.to_radians().sin_cos();
        let mut description = Self {
            spring: finger
                .spring_nm_per_rad
                .iter()
                .map(|k| k * (1.0 + mechanism.spring_error))
                .collect(),
            springs_left: 1.0,
            rest,
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

    /// The model. `stopped`: the stops of input link and joint 1 are there. `calm`: joints damped so that the finger
    /// comes to rest soon.
    pub fn xml(&self, object: &Body, stopped: bool, calm: bool) -> Result<String, Error> {
        let mut text = String::new();
        let ([x, y], step_s) = (self.gravity, self.step_s);
        let damping = if calm {
            self.damping.max(5e-3)
        } else {
            self.damping
        };
        line(
            &mut text,
            format_args!(
                r#"<mujoco><compiler angle="radian" balanceinertia="true"/>
<option timestep="{step_s}" gravity="{x} {y} 0" integrator="Euler" cone="elliptic" tolerance="1e-14" iterations="50">
<flag energy="enable" multiccd="enable" autoreset="disable" island="disable"/></option>
<default><geom contype="0" conaffinity="0" mass="{ROD_KG}"/>
<joint type="hinge" axis="0 0 1" solimplimit="{IMPEDANCE} {IMPEDANCE} 1" limited="false"/>
<equality solref="-1e7 -6e3" solimp="0.9999 0.9999 1"/>
<pair solimp="{IMPEDANCE} {IMPEDANCE} 1" solreffriction="-1e-3 -{SLIP_PER_S}"/></default>
<worldbody>"#
            ),
        );
        if let Some(stage) = self.stages.first() {
            let lever = self.close(0, stage, 0.0)?.lever;
            line(
                &mut text,
                format_args!(r#"<body euler="0 0 {lever}"><joint name="lever1"/>"#),
            );
            self.lever(&mut text, 0)?;
            text.push_str("</body>\n");
        }
        self.phalanx(&mut text, 0, stopped, damping)?;
        self.object(&mut text, object);
        text.push_str("</worldbody>\n");
        let outline = match object {
            Body::Polygon { corners } if rectangle(corners).is_none() => corners.as_slice(),
            _ => &[],
        };
        if !outline.is_empty() {
            text.push_str(&mesh(outline));
        }
        text.push_str("<contact>");
        // Without friction a contact is one force; with it, a cone.
        let dimensions = if self.friction > 0.0 { 3 } else { 1 };
        let friction = self.friction.max(1e-5);
        let touchable = match object {
            Body::Nothing => 0,
            Body::Disc { .. } | Body::Polygon { .. } => self.phalanges(),
        };
        for phalanx in 1..=touchable {
            line(
                &mut text,
                format_args!(
                    r#"<pair geom1="phalanx{phalanx}" geom2="object" condim="{dimensions}" friction="{friction} {friction} 0 0 0"/>"#
                ),
            );
        }
        text.push_str("</contact>\n<tendon>");
        let [opening, closing] = self.stops;
        line(
            &mut text,
            format_args!(
                r#"<fixed name="{INPUT}" limited="{stopped}" range="{opening} {closing}" solimplimit="{IMPEDANCE} {IMPEDANCE} 1">"#
            ),
        );
        if self.stages.is_empty() {
            for (i, ratio) in self.ratios().iter().enumerate() {
                line(
                    &mut text,
                    format_args!(r#"<joint joint="joint{}" coef="{ratio}"/>"#, i + 1),
                );
            }
        } else {
            text.push_str(r#"<joint joint="lever1" coef="1"/>"#);
        }
        text.push_str("</fixed>");
        for (i, flanks) in self.held() {
            let ([low, high], spring) = (flanks, self.spring[i]);
            line(
                &mut text,
                format_args!(
                    r#"<fixed stiffness="{spring}" springlength="{low} {high}"><joint joint="joint{}" coef="1"/></fixed>"#,
                    i + 1
                ),
            );
        }
        text.push_str("</tendon>\n<equality>");
        for i in 1..=self.stages.len() {
            line(
                &mut text,
                format_args!(r#"<connect site1="coupler{i}" site2="driven{i}"/>"#),
            );
        }
        line(
            &mut text,
            format_args!(r#"</equality><actuator><motor tendon="{INPUT}"/></actuator></mujoco>"#),
        );
        Ok(text)
    }

    /// Driving lever of stage `i` along x, with its coupler.
    fn lever(&self, text: &mut String, i: usize) -> Result<(), Error> {
        let stage = &self.stages[i];
        let closed = self.close(i, stage, 0.0)?;
        let (n, turn) = (i + 1, closed.coupler - closed.lever);
        let (lever, coupler) = (stage.lever, stage.coupler);
        line(
            text,
            format_args!(
                r#"<geom type="capsule" fromto="0 0 0 {lever} 0 0" size="0.002"/>
<body pos="{lever} 0 0" euler="0 0 {turn}"><joint name="coupler{n}"/>
<geom type="capsule" fromto="0 0 0 {coupler} 0 0" size="0.002"/><site name="coupler{n}" pos="{coupler} 0 0"/></body>"#
            ),
        );
        Ok(())
    }

    /// Phalanx `i` from 0 and all beyond.
    fn phalanx(
        &self,
        text: &mut String,
        i: usize,
        stopped: bool,
        damping: f64,
    ) -> Result<(), Error> {
        let (n, length) = (i + 1, self.finger.length_m[i]);
        let before = if i == 0 {
            0.0
        } else {
            self.finger.length_m[i - 1]
        };
        let rest = self.rest[i];
        // The spring of a joint that its own motor holds is a tendon, which can have backlash.
        let spring = if self.held().any(|(held, _)| held == i) {
            0.0
        } else {
            self.springs_left * self.spring[i]
        };
        let low = self.finger.joint_min_deg[i].to_radians();
        let high = self.finger.joint_max_deg[i].to_radians();
        let limited = stopped || i > 0;
        let friction = self.joint_friction;
        let half = self.half_thickness;
        let mass = self.density * length;
        line(
            text,
            format_args!(
                r#"<body name="phalanx{n}" pos="{before} 0 0">
<joint name="joint{n}" stiffness="{spring}" springref="{rest}" damping="{damping}" frictionloss="{friction}" limited="{limited}" range="{low} {high}"/>
<geom name="phalanx{n}" type="capsule" fromto="0 0 0 {length} 0 0" size="{half}" mass="{mass}"/>"#
            ),
        );
        if let Some(stage) = i.checked_sub(1).and_then(|stage| self.stages.get(stage))
            // With a stage behind it, an intermediate link carries the driven lever.
            && self.stages.get(i).is_none()
        {
            let [x, y] = stage.tip();
            line(
                text,
                format_args!(r#"<site name="driven{i}" pos="{x} {y} 0"/>"#),
            );
        }
        if i + 1 < self.phalanges() {
            if let (Some(stage), Some(next)) = (self.stages.get(i), self.stages.get(i + 1)) {
                let [x, y] = stage.tip();
                let turn = self.close(i + 1, next, 0.0)?.lever;
                line(
                    text,
                    format_args!(
                        r#"<body pos="{length} 0 0"><joint name="lever{}"/>
<geom type="capsule" fromto="0 0 0 {x} {y} 0" size="0.002"/><site name="driven{n}" pos="{x} {y} 0"/>
<body euler="0 0 {turn}">"#,
                        n + 1
                    ),
                );
                self.lever(text, i + 1)?;
                text.push_str("</body></body>\n");
            }
            self.phalanx(text, i + 1, stopped, damping)?;
        }
        text.push_str("</body>\n");
        Ok(())
    }

    fn object(&self, text: &mut String, object: &Body) {
        let (centre, geom) = match object {
            Body::Nothing => return,
            Body::Disc { centre, radius } => {
                // The engine wants some size: half a micrometre is a point.
                let radius = radius.max(5e-7);
                let geom = format!(
                    r#"<geom name="object" type="capsule" fromto="0 0 -{HALF_DEPTH_M} 0 0 {HALF_DEPTH_M}" size="{radius}" mass="{}"/>"#,
                    self.surroundings.object_kg
                );
                (*centre, geom)
            }
            Body::Polygon { corners } => (
                middle(corners),
                polygon(corners, self.surroundings.object_kg),
            ),
        };
        let [x, y] = centre;
        let joints = match self.surroundings.mount {
            Mount::Fixed => String::new(),
            Mount::Spring {
                stiffness_n_per_m,
                damping_n_s_per_m,
            } => ["1 0 0", "0 1 0"]
                .map(|axis| {
                    format!(
                        r#"<joint type="slide" axis="{axis}" stiffness="{stiffness_n_per_m}" damping="{damping_n_s_per_m}"/>"#
                    )
                })
                .concat(),
            Mount::Free => {
                let slide = |axis: &str| format!(r#"<joint type="slide" axis="{axis}"/>"#);
                [slide("1 0 0"), slide("0 1 0"), "<joint/>".into()].concat()
            }
        };
        line(
            text,
            format_args!(r#"<body name="object" pos="{x} {y} 0">{joints}{geom}</body>"#),
        );
    }
}

fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{arguments}");
}
