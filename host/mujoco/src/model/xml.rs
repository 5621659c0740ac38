//! The engine's model of a finger and an object, as text.
//!
//! The finger moves in the plane z = 0. A phalanx is a capsule; a cylinder across the plane is a capsule too, because
//! the engine meets two capsules exactly and its round ends are far from the plane.

use super::{Description, INPUT};
use crate::outline::{HALF_DEPTH_M, mesh, middle, polygon, rectangle};
use crate::stiffness::IMPEDANCE;
use crate::surroundings::Mount;
use palpate_plant::{Body, Error};
use std::fmt::Write;

/// Mass of a lever or coupler of a linkage, kilogram (chosen: thin steel).
const ROD_KG: f64 = 5e-4;
/// How fast the engine ends slipping, per second. Stiffer than some 300 a sliding contact chatters, up to being thrown
/// across the object; from 30 to 300 the contact's path is the same within 1e-6.
const SLIP_PER_S: f64 = 200.0;
/// How fast the engine ends slipping in joints and on pulleys, per second. With the engine's defaults for this and for the impedance,
/// friction creeps on such light links, and hardly any of the 3 % that a pulley takes acts. With 400 per second torques of the harsh world
/// depend on the length of a step.
const JOINT_SLIP_PER_S: f64 = 1000.0;
/// Impedance of that friction. With 0.99 (and 200 per second) torques depend on the length of a step as well.
const JOINT_IMPEDANCE: f64 = 0.995;
/// Ratio of the stiffness of friction to that of the normal force (MuJoCo's `impratio`). The engine softens friction, which then grows
/// with the sliding speed up to Coulomb's limit. With a ratio of 1 it stays below 0.4 N at 7 mm/s, and torques at the end of a probing
/// are 2.5 % too low; ratios of 10 and 100 give the same torques.
const FRICTION_HARDNESS: f64 = 100.0;

impl Description {
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
<option timestep="{step_s}" gravity="{x} {y} 0" integrator="Euler" cone="elliptic" impratio="{FRICTION_HARDNESS}" tolerance="1e-14" iterations="50">
<flag energy="enable" multiccd="enable" autoreset="disable" island="disable"/></option>
<default><geom contype="0" conaffinity="0" mass="{ROD_KG}"/>
<joint type="hinge" axis="0 0 1" solimplimit="{IMPEDANCE} {IMPEDANCE} 1" solimpfriction="{JOINT_IMPEDANCE} {JOINT_IMPEDANCE} 1" solreffriction="-1e-3 -{JOINT_SLIP_PER_S}" limited="false"/>
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
        let last = match object {
            Body::Nothing => 0,
            Body::Disc { .. } | Body::Polygon { .. } => self.phalanges(),
        };
        let first = 1 + usize::from(self.finger.hidden_base);
        for phalanx in first..=last {
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
        if let Some([stiffness, slack]) = self.returned() {
            line(
                &mut text,
                format_args!(r#"<fixed stiffness="{stiffness}" springlength="-1e3 {slack}">"#),
            );
            for (i, radius) in self.finger.return_pulley_m.iter().enumerate() {
                line(
                    &mut text,
                    format_args!(r#"<joint joint="joint{}" coef="{radius}"/>"#, i + 1),
                );
            }
            text.push_str("</fixed>");
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
