//! The finger in the engine, stepped by the drivetrain's cable.

use crate::model::{Description, usual_step_s};
use crate::stiffness::Stiffness;
use crate::surroundings::Surroundings;
use mujoco_rs::prelude::{MjData, MjModel};
use mujoco_rs::wrappers::mj_model::MjtObjBase;
use palpate_plant::{
    Body, CableEnd, Contact, Error, FingerState, Grasp, Mechanics, Object, Parameters, placed,
};

/// Share of critical damping in the cable (chosen: nylon rings little).
const CABLE_DAMPING_RATIO: f64 = 0.05;
/// Over which the speed of the cable's other end is smoothed, second.
const END_SPEED_S: f64 = 5e-3;
/// Depth of overlap that is a matter of rounding, metre.
const ROUNDING_M: f64 = 1e-6;
/// Longest time to come to rest, steps.
const SETTLING_STEPS: usize = 100_000;
/// Most torque on the way there, however far the cable's end is, newton metre.
const SETTLING_NM: f64 = 2.0;
/// Slower than this it is at rest, radian per second.
const REST_RAD_PER_S: f64 = 1e-7;

/// A finger and an object in the engine.
#[derive(Clone)]
pub struct MujocoFinger {
    parameters: Parameters,
    description: Description,
    stiffness: Stiffness,
    body: Body,
    stopped: bool,
    data: MjData<Box<MjModel>>,
    /// Numbers of the joints in the state.
    joints: Vec<usize>,
    levers: Vec<usize>,
    couplers: Vec<usize>,
    /// theta_a in the joints of the state.
    input: Vec<(usize, f64)>,
    state: FingerState,
    /// Time that has passed and is not yet stepped, second.
    owed_s: f64,
    last_end: Option<CableEnd>,
    /// Smoothed speed of the cable's other end, radian per second.
    end_speed: f64,
}

impl std::fmt::Debug for MujocoFinger {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("MujocoFinger")
            .field("scene", &self.parameters.scene)
            .field("state", &self.state)
            .finish_non_exhaustive()
    }
}

impl MujocoFinger {
    /// A finger at its rest pose, nothing to grasp.
    ///
    /// # Errors
    /// A parameter out of range, a four-bar that does not close, a model that the engine refuses.
    pub fn new(parameters: &Parameters, surroundings: &Surroundings) -> Result<Self, Error> {
        let step_s = usual_step_s(parameters, surroundings);
        Self::with_step(parameters, surroundings, step_s)
    }

    /// The same with another step of the engine than the usual one, second: to see what a step's length does.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_step(
        parameters: &Parameters,
        surroundings: &Surroundings,
        step_s: f64,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        let description = Description::new(parameters, surroundings, step_s)?;
        let stiffness = Stiffness {
            stop_nm_per_rad: parameters.mechanism.stop_stiffness_nm_per_rad,
            contact_n_per_m: parameters.contact.stiffness_n_per_m,
        };
        let model = compile(&description, stiffness, &Body::Nothing, true, false)?;
        let numbers = |name: &str, count: usize| -> Vec<usize> {
            (1..=count)
                .filter_map(|n| model.name_to_id(MjtObjBase::mjOBJ_JOINT, &format!("{name}{n}")))
                .collect()
        };
        let stages = description.stages.len();
        let joints = numbers("joint", description.phalanges());
        let levers = numbers("lever", stages);
        let couplers = numbers("coupler", stages);
        let input = match levers.first() {
            Some(&lever) => vec![(lever, 1.0)],
            None => joints.iter().copied().zip(description.ratios()).collect(),
        };
        let mut finger = Self {
            state: FingerState {
                phalanges: description.phalanges(),
                stops_rad: description.stops,
                ..FingerState::default()
            },
            parameters: parameters.clone(),
            stiffness,
            body: Body::Nothing,
            stopped: true,
            data: MjData::new(Box::new(model)),
            joints,
            levers,
            couplers,
            input,
            owed_s: 0.0,
            last_end: None,
            end_speed: 0.0,
            description,
        };
        let start = finger.description.start().to_vec();
        finger.pose(&start)?;
        finger.data.forward();
        finger.read(0.0);
        Ok(finger)
    }

    /// Puts the joints at these angles, at rest, and the links of the transmission where they then stand.
    fn pose(&mut self, joint_rad: &[f64]) -> Result<(), Error> {
        let (levers, couplers) = self.description.positions(joint_rad)?;
        let places = [
            (&self.joints, joint_rad),
            (&self.levers, &levers[..]),
            (&self.couplers, &couplers[..]),
        ];
        for (numbers, angles) in places {
            for (&number, &angle) in numbers.iter().zip(angles) {
                self.data.qpos_mut()[number] = angle;
            }
        }
        self.data.qvel_mut().fill(0.0);
        Ok(())
    }

    /// The same state in a model with another object, with or without stops.
    fn rebuilt(
        &self,
        body: &Body,
        stopped: bool,
        calm: bool,
    ) -> Result<MjData<Box<MjModel>>, Error> {
        let model = compile(&self.description, self.stiffness, body, stopped, calm)?;
        let mut data = MjData::new(Box::new(model));
        // The object's joints come after the finger's and start where the object is put.
        let keep = self.joints.len() + self.levers.len() + self.couplers.len();
        data.qpos_mut()[..keep].copy_from_slice(&self.data.qpos()[..keep]);
        data.qvel_mut()[..keep].copy_from_slice(&self.data.qvel()[..keep]);
        data.forward();
        Ok(data)
    }

    fn along_input(&self, values: &[f64]) -> f64 {
        self.input
            .iter()
            .map(|&(number, ratio)| ratio * values[number])
            .sum()
    }

    /// Torque of the cable now; `speed` of its other end, radian per second. Between two steps the input link goes on as fast as
    /// it went.
    fn cable_nm(&self, end: &CableEnd, speed: f64) -> f64 {
        let input_speed = self.along_input(self.data.qvel());
        let torque =
            end.torque_nm(self.along_input(self.data.qpos()) + input_speed * self.owed_s.max(0.0));
        if torque == 0.0 {
            return 0.0;
        }
        let damping = 2.0
            * CABLE_DAMPING_RATIO
            * (end.stiffness_nm_per_rad * self.description.inertia()).sqrt();
        torque + damping * (speed - input_speed)
    }

    fn advance(&mut self, torque: f64) {
        self.data.ctrl_mut()[0] = torque;
        if self.description.capstan_share > 0.0 {
            self.rub(torque);
        }
        self.data.step();
    }

    /// Friction of the tendon on its pulleys under this torque at the input link.
    fn rub(&mut self, torque: f64) {
        let share = self.description.capstan_share * torque.abs();
        let friction = self.description.joint_friction;
        // SAFETY: a number of the model changes, none of its sizes or addresses.
        #[allow(unsafe_code)]
        let losses = unsafe { self.data.model_mut() }.dof_frictionloss_mut();
        for &(joint, ratio) in self.input.iter().skip(1) {
            losses[joint] = friction + share * ratio;
        }
    }

    fn read(&mut self, torque_nm: f64) {
        for (angle, &number) in self.state.joint_rad.iter_mut().zip(&self.joints) {
            *angle = self.data.qpos()[number];
        }
        self.state.theta_a_rad = self.along_input(self.data.qpos());
        assert!(
            self.state.theta_a_rad.is_finite(),
            "the finger's model has become unstable: its numbers go beyond what MuJoCo can step"
        );
        self.state.torque_nm = torque_nm;
        self.state.contacts.clear();
        let model = self.data.model();
        for (number, contact) in self.data.contact().iter().enumerate() {
            let force_n = self.data.contact_force(number)[0];
            let Some(geom) = usize::try_from(contact.geom1)
                .ok()
                .filter(|_| force_n > 0.0)
            else {
                continue;
            };
            let name = model.id_to_name(MjtObjBase::mjOBJ_GEOM, geom);
            let other = name.is_none_or(|name| !name.starts_with("phalanx"));
            // The engine orders the two by their kind.
            let (geom, sign) = if other {
                (contact.geom2, -1.0)
            } else {
                (contact.geom1, 1.0)
            };
            let Some((phalanx, joint, along)) = self.axis(geom) else {
                continue;
            };
            let normal = [sign * contact.frame[0], sign * contact.frame[1]];
            let offset = [contact.pos[0] - joint[0], contact.pos[1] - joint[1]];
            let length = self.description.finger.length_m[usize::from(phalanx) - 1];
            let k_m = (offset[0] * along[0] + offset[1] * along[1]).clamp(0.0, length);
            let back = normal[1] * along[0] - normal[0] * along[1] < -1e-3;
            // Corners of one flat side are one contact each.
            self.state.contacts.push(Contact {
                phalanx,
                k_m,
                force_n,
                back,
            });
        }
    }

    /// Phalanx of a geom, the place of its joint and its direction.
    fn axis(&self, geom: i32) -> Option<(u8, [f64; 2], [f64; 2])> {
        let geom = usize::try_from(geom).ok()?;
        let model = self.data.model();
        let body = usize::try_from(*model.geom_bodyid().get(geom)?).ok()?;
        let name = model.id_to_name(MjtObjBase::mjOBJ_BODY, body)?;
        let phalanx: u8 = name.strip_prefix("phalanx")?.parse().ok()?;
        let joint = self.data.xpos().get(body)?;
        let turned = self.data.xmat().get(body)?;
        Some((phalanx, [joint[0], joint[1]], [turned[0], turned[3]]))
    }

    /// How far a held or free object has moved from where it was put; `None` without one, or for a fixed one.
    #[must_use]
    pub fn object_m(&self) -> Option<[f64; 2]> {
        let first = self.joints.len() + self.levers.len() + self.couplers.len();
        match self.data.qpos().get(first..)? {
            [x, y, ..] => Some([*x, *y]),
            _ => None,
        }
    }

    fn deepest_overlap_m(data: &MjData<Box<MjModel>>) -> f64 {
        data.contact()
            .iter()
            .map(|contact| -contact.dist)
            .fold(0.0, f64::max)
    }
}

fn compile(
    description: &Description,
    stiffness: Stiffness,
    body: &Body,
    stopped: bool,
    calm: bool,
) -> Result<MjModel, Error> {
    let text = description.xml(body, stopped, calm)?;
    let mut model = MjModel::from_xml_string(&text)
        .map_err(|error| Error::Engine(format!("MuJoCo: {error}")))?;
    stiffness.set(&mut model);
    Ok(model)
}

impl Mechanics for MujocoFinger {
    fn state(&self) -> &FingerState {
        &self.state
    }

    fn place(&mut self, grasp: &Grasp) -> Result<(), Error> {
        let body = placed(&self.parameters, grasp)?;
        let data = self.rebuilt(&body, self.stopped, false)?;
        let depth = Self::deepest_overlap_m(&data);
        if depth > ROUNDING_M {
            return Err(Error::overlap(depth));
        }
        self.data = data;
        self.body = body;
        self.state.contacts.clear();
        Ok(())
    }

    fn mount(&mut self, object: &Object) -> Result<(), Error> {
        self.description.hold(&self.parameters, object);
        Ok(())
    }

    fn shift(&mut self, by_m: [f64; 2]) -> Result<(), Error> {
        let body = self.body.shifted(by_m);
        self.data = self.rebuilt(&body, self.stopped, false)?;
        self.body = body;
        Ok(())
    }

    fn break_stops(&mut self, missing: bool) {
        if self.stopped != missing {
            return;
        }
        // The model without its stops is the one that was compiled before but for two flags.
        if let Ok(data) = self.rebuilt(&self.body, !missing, false) {
            self.data = data;
            self.stopped = !missing;
        }
    }

    fn weaken_springs(&mut self, left: f64) {
        let before = std::mem::replace(&mut self.description.springs_left, left);
        if before == left {
            return;
        }
        match self.rebuilt(&self.body, self.stopped, false) {
            Ok(data) => self.data = data,
            Err(_) => self.description.springs_left = before,
        }
    }

    fn step(&mut self, end: &CableEnd, dt_s: f64) {
        let speed = self
            .last_end
            .map_or(0.0, |last| (end.low_rad - last.low_rad) / dt_s);
        // A cable that stiffens moves its end with its torque: taken at once, that would feed the torque's noise back.
        self.end_speed += (speed - self.end_speed) * (dt_s / END_SPEED_S).min(1.0);
        let speed = self.end_speed;
        self.last_end = Some(*end);
        self.owed_s += dt_s;
        let step_s = self.description.step_s;
        let due = self.owed_s > step_s * (1.0 - 1e-9);
        while self.owed_s > step_s * (1.0 - 1e-9) {
            self.owed_s -= step_s;
            self.advance(self.cable_nm(end, speed));
        }
        let torque = self.cable_nm(end, speed);
        if due {
            self.read(torque);
        } else {
            self.state.torque_nm = torque;
        }
    }

    fn settle(&mut self, end: &CableEnd) {
        let Ok(calm) = self.rebuilt(&self.body, self.stopped, true) else {
            return;
        };
        let lively = std::mem::replace(&mut self.data, calm);
        for _ in 0..SETTLING_STEPS {
            let torque = self.cable_nm(end, 0.0);
            self.advance(torque.clamp(-SETTLING_NM, SETTLING_NM));
            let fastest = self
                .data
                .qvel()
                .iter()
                .fold(0.0, |most: f64, v| most.max(v.abs()));
            if fastest < REST_RAD_PER_S {
                break;
            }
        }
        let posture = self.data.qpos().to_vec();
        self.read(self.cable_nm(end, 0.0));
        self.data = lively;
        self.data.qpos_mut().copy_from_slice(&posture);
        self.data.qvel_mut().fill(0.0);
        self.data.forward();
    }

    fn energy_j(&self) -> f64 {
        self.data.energy().iter().sum()
    }

    fn boxed_clone(&self) -> Box<dyn Mechanics> {
        Box::new(self.clone())
    }
}
