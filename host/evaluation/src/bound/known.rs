//! What is known of a scene's finger before a contact: its lengths as the reference has them, and every unknown with its deviation.

use nalgebra::DMatrix;
use palpate::finger::Mechanics;
use palpate::scene::Scene;
use palpate::sensing::{Calibration, SeriesElement, Settings};
use palpate_plant::{FingerParameters, Parameters};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::Objects;
use super::drawn::REFERENCE_NOISE;
pub(super) use crate::reference::OFFSET_M;
use crate::reference::{Drive, Finger, Noise, Opened, Press, ReturnCable, Sample, Stage, Weight};

/// Unknowns that the finger takes from one contact to the next: torque factor, cable, its stiffening, friction of the joints, and
/// what is lost on the way to them.
pub(super) const FACTOR: usize = 0;
pub(super) const CABLE: usize = 1;
pub(super) const BEND: usize = 2;
pub(super) const JOINT: usize = 3;
pub(super) const LOSS: usize = 4;
/// The same of a tendon's pulleys: share by which the ratio of each of two pairs is off.
pub(super) const PULLEYS: [usize; 2] = [10, 11];
/// And of a return cable's: how far the radius of each of two is off, metre; the last unknowns.
pub(super) const RETURN_PULLEYS: [usize; 2] = [12, 13];
/// Unknown of a material: the pins', or the object's.
pub(super) const FRICTION: usize = 5;
/// Unknowns of a contact: place, logarithm of the object's radius plus [`OFFSET_M`], measured angle of the onset, compliance.
pub(super) const K: usize = 6;
pub(super) const RADIUS: usize = 7;
pub(super) const ONSET: usize = 8;
pub(super) const GIVE: usize = 9;
pub(super) const UNKNOWNS: usize = 14;
/// Standard gravity, metre per second squared.
pub(super) const GRAVITY_M_PER_S2: f64 = 9.81;
/// Deviation of the radius of a pulley, metre: it is within 0.15 mm of the scene's.
const PULLEY_SIGMA_M: f64 = 2.0 * UNIFORM * 0.15e-3;
/// Radii of objects, metre: even in the logarithm of radius plus [`OFFSET_M`].
pub(super) const RADII_M: [f64; 2] = [0.001, 0.056];
/// Deviation of a detected onset from the true one, radian.
pub(super) const DETECTED_RAD: f64 = 0.01;
/// Turns of the motor in a point.
pub(super) const TURNS: f64 = 2.0;
/// White noise of one turn of the motor, newton metre.
pub(super) const WHITE_NM: f64 = 2e-4;
/// Bounce at contact, newton metre, and the angle over which it dies, radian, for a speed of 1 rad/s.
const IMPACT: [f64; 2] = [5e-3 / 0.3, 0.04];
/// Friction of a free closing behind the gears, newton metre, and by what share of it the last third of a closing may differ from the
/// first, as the firmware assumes (docs/SENSING.md#what-a-free-closing-tells).
const FREE_NM: f64 = 0.055;
const UNEVEN: f64 = 0.08;
/// Where a closing is steady, radian from the opening stop.
const STEADY_RAD: f64 = 0.08;
/// Deviation of a uniform distribution, as a share of its width.
pub(super) const UNIFORM: f64 = 0.289;

/// Whether values are those of a finger: no cable softens, and neither its joints and pulleys nor these other unknowns push.
pub(super) fn is_possible(values: &[f64], others: &[usize]) -> bool {
    values[FACTOR] > 0.0
        && values[CABLE] > 0.0
        && [BEND, JOINT, LOSS]
            .iter()
            .chain(others)
            .all(|&unknown| values[unknown] >= 0.0)
}

/// What is known of a scene before a contact.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// Links, springs and stops.
    pub(super) opened: Opened,
    /// Lengths of the phalanges, metre.
    pub(super) lengths_m: Vec<f64>,
    /// Deviation of the leverage at a place, as a share, without pins and from that at the pins.
    pub(super) leverage: [f64; 2],
    /// What the sensing is told.
    pub(super) settings: Settings,
    /// Deviation of the object's compliance, metre per newton; 0 where the scene takes objects as rigid.
    give_m_per_n: f64,
    /// Share that is lost on the way to each joint beyond the first: mean and deviation.
    pub(super) joint_loss: [f64; 2],
    /// Deviation of the ratio of each pair of pulleys, as a share.
    pulleys: [f64; 2],
    /// Torque factor and cable by the data sheets.
    pub(super) sheet: Calibration,
    /// Angle of the input link in a turn of the motor, radian, turns of the worm in it, and its duration, second.
    pub(super) turn_rad: f64,
    worm_turns: f64,
    turn_s: f64,
    /// How far probing closes on, and the closing stop, radian.
    pub(super) probing_rad: f64,
    pub(super) closed_rad: f64,
    /// The first phalanx that touches.
    pub(super) first: usize,
    /// What it touches.
    pub(super) objects: Objects,
    /// Noise of its curves, at the speed of its closing.
    pub(super) noise: Noise,
}

/// A contact that is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen {
    /// Phalanx, from 1.
    pub(super) phalanx: usize,
    /// Distance from its joint, metre.
    pub(super) k_m: f64,
    /// Radius of the object, metre.
    pub(super) object_m: f64,
    /// Measured angle at first contact, radian.
    pub(super) onset_rad: f64,
}

impl Chosen {
    /// Any, for what does not depend on it.
    pub(super) const SOME: Self = Self {
        phalanx: 1,
        k_m: 0.0,
        object_m: 0.0,
        onset_rad: 0.0,
    };
}

/// The finger of the reference from a scene's lengths, without weight.
#[must_use]
pub fn opened(of: &FingerParameters) -> Opened {
    let radians =
        |degrees: &[f64]| -> Vec<f64> { degrees.iter().map(|x| x.to_radians()).collect() };
    let rest_rad = radians(&of.rest_deg);
    let tendons = of.pulley_m.chunks_exact(2).map(|pair| Stage::Tendon {
        ratio: pair[1] / pair[0],
    });
    let linkages = (0..of.lever_m.len()).map(|i| Stage::Linkage {
        drive: of.lever_m[i],
        coupler: of.coupler_m[i],
        driven: of.driven_m[i],
        offset_rad: of.offset_deg[i].to_radians(),
        mode: of.mode[i],
    });
    // A motor at every joint: none turns another.
    let held = of
        .held_backlash_deg
        .iter()
        .map(|_| Stage::Tendon { ratio: 0.0 });
    let least_rad = radians(&of.joint_min_deg);
    let stand = rest_rad.iter().zip(&least_rad);
    Opened {
        stopped: rest_rad
            .iter()
            .zip(&least_rad)
            .skip(1)
            .all(|(rest, least)| rest <= least),
        stand_rad: stand.map(|(rest, least)| rest.max(*least)).collect(),
        most_rad: radians(&of.joint_max_deg),
        weight: None,
        back: (!of.return_pulley_m.is_empty()).then(|| ReturnCable {
            pulley_m: of.return_pulley_m.clone(),
            tension_n: of.return_tension_n,
            stiffness_n_per_m: of.return_n_per_m,
        }),
        finger: Finger {
            lengths: of.length_m.clone(),
            springs: of.spring_nm_per_rad.clone(),
            stages: tendons.chain(linkages).chain(held).collect(),
            rest_rad,
        },
    }
}

/// What a scene states of its phalanges' weight; nothing where it states none.
#[must_use]
pub fn stated_weight<S: Scene>(of: &FingerParameters) -> Option<Weight> {
    (!of.stated_mass_kg.is_empty()).then(|| Weight {
        phalanx_n: (of.stated_mass_kg.iter())
            .map(|mass_kg| GRAVITY_M_PER_S2 * mass_kg)
            .collect(),
        down_rad: S::MOUNTING_RAD.into(),
    })
}

/// Deviation of the ratio of each pair of pulleys, as a share; 0 without pulleys.
fn pulleys(of: &FingerParameters) -> [f64; 2] {
    let mut pairs = of.pulley_m.chunks_exact(2);
    std::array::from_fn(|_| {
        (pairs.next()).map_or(0.0, |pair| {
            PULLEY_SIGMA_M * (1.0 / pair[0]).hypot(1.0 / pair[1])
        })
    })
}

impl Known {
    pub(super) fn of<S: Scene>(parameters: &Parameters) -> Self {
        let drivetrain = S::drivetrain(&S::MECHANISM);
        let settings = S::settings();
        let leverage = f64::from(settings.leverage_sigma);
        let left = f64::from(<S::Finger as Mechanics>::PINS_LEAVE);
        let counts = f64::from(drivetrain.counts_per_turn);
        let turn_rad = counts * f64::from(drivetrain.rad_per_count);
        let opened_rad = f64::from(drivetrain.opening_stop_rad);
        // The back-EMF tells the torque constant.
        let mut sheet = S::UNCALIBRATED;
        let told = drivetrain.torque_constant_sigma.powi(2);
        sheet.torque_factor_sigma = (sheet.torque_factor_sigma.powi(2) - told).max(0.0).sqrt();
        Self {
            opened: Opened {
                weight: stated_weight::<S>(&parameters.finger),
                ..opened(&parameters.finger)
            },
            lengths_m: parameters.finger.length_m.clone(),
            give_m_per_n: if S::Series::OBJECT_GIVES {
                settings.object_give_m_per_n.into()
            } else {
                0.0
            },
            pulleys: pulleys(&parameters.finger),
            joint_loss: <S::Finger as Mechanics>::JOINT_LOSS.map(f64::from),
            sheet,
            turn_rad,
            worm_turns: counts / f64::from(drivetrain.counts_per_worm_turn),
            turn_s: turn_rad / f64::from(settings.speed_rad_per_s),
            probing_rad: f64::from(S::MOTION.probing_rad),
            closed_rad: opened_rad + f64::from(settings.closing_stop_rad),
            first: usize::from(parameters.finger.hidden_base) + 1,
            leverage: [leverage, left * leverage],
            objects: Objects::Usual,
            noise: Noise {
                impact: IMPACT.map(|of_speed| of_speed * f64::from(settings.speed_rad_per_s)),
                ..REFERENCE_NOISE
            },
            settings,
        }
    }

    /// Tells cable and stiffening, as a press on the stop does (src/sensing/sensor/calibrate.rs).
    pub(super) fn press_on_stop(&self, known: &mut DMatrix<f64>, deviations: &[f64]) {
        let pressed_rad = 0.02 * f64::from(self.sheet.cable_rad_per_nm) + 4e-3;
        for (unknown, deviation) in [(CABLE, pressed_rad), (BEND, 0.1)] {
            let before = known[(unknown, unknown)];
            known[(unknown, unknown)] = (deviation / deviations[unknown]).powi(2).min(before);
        }
    }

    /// Tells the torque factor of a finger with springs and a stated weight, as a free closing does: by the rise from the first third to
    /// the last.
    pub(super) fn close_freely(&self, known: &mut DMatrix<f64>, deviations: &[f64]) {
        if self.opened.weight.is_none() {
            return;
        }
        let drive = self.drive();
        let way_rad = f64::from(self.settings.closing_stop_rad) - STEADY_RAD;
        let torque_nm = |left: f64| {
            (self.opened)
                .free(self.closed_rad - left * way_rad, &drive)
                .map(|free| free.torque_nm)
        };
        let (Some(first_nm), Some(last_nm)) = (torque_nm(5.0 / 6.0), torque_nm(1.0 / 6.0)) else {
            return;
        };
        let taken_nm = (last_nm - first_nm) / drive.factor;
        let off_nm = (UNEVEN * FREE_NM).hypot(2f64.sqrt() * self.noise.wander_nm);
        if taken_nm > 0.0 {
            let variance = (drive.factor * off_nm / taken_nm / deviations[FACTOR]).powi(2);
            let before = known[(FACTOR, FACTOR)];
            known[(FACTOR, FACTOR)] = before * variance / (before + variance);
        }
    }

    /// A point of a curve, so many turns of the motor after its first one.
    pub(super) fn sample(&self, angle_rad: f64, turns: f64, excess_nm: f64) -> Sample {
        Sample {
            angle_rad,
            time_s: turns * self.turn_s,
            excess_nm,
            late_nm: 0.0,
            variance_nm2: WHITE_NM * WHITE_NM / TURNS,
            width_rad: TURNS * self.turn_rad,
            blocks: TURNS,
            worm_turns: turns * self.worm_turns,
        }
    }

    /// Turns of the worm up to a measured angle.
    pub(super) fn worm_turns(&self, angle_rad: f64) -> f64 {
        self.worm_turns * angle_rad / self.turn_rad
    }

    /// The unknowns' means.
    pub(super) fn means(&self, chosen: &Chosen) -> [f64; UNKNOWNS] {
        let mut means = [0.0; UNKNOWNS];
        means[FACTOR] = self.sheet.torque_factor.into();
        means[CABLE] = self.sheet.cable_rad_per_nm.into();
        means[BEND] = self.sheet.stiffening_per_nm.into();
        means[JOINT] = self.settings.joint_friction_nm[0].into();
        means[FRICTION] = self.settings.contact_friction[0].into();
        [means[LOSS], _] = self.joint_loss;
        means[K] = chosen.k_m;
        means[RADIUS] = (chosen.object_m + OFFSET_M).ln();
        means[ONSET] = chosen.onset_rad;
        means
    }

    /// Their deviations by the data sheets.
    pub(super) fn deviations(&self, length_m: f64) -> [f64; UNKNOWNS] {
        let (settings, sheet) = (&self.settings, &self.sheet);
        let mut deviations = [0.0; UNKNOWNS];
        deviations[FACTOR] = f64::from(sheet.torque_factor * sheet.torque_factor_sigma);
        deviations[CABLE] = sheet.cable_sigma_rad_per_nm.into();
        deviations[BEND] = sheet.stiffening_sigma_per_nm.into();
        let [joint_nm, preload_nm] = [settings.joint_friction_nm[1], settings.preload_nm[1]];
        deviations[JOINT] = f64::from(joint_nm).hypot(preload_nm.into());
        deviations[FRICTION] = settings.contact_friction[1].into();
        [_, deviations[LOSS]] = self.joint_loss;
        for (unknown, deviation) in PULLEYS.into_iter().zip(self.pulleys) {
            deviations[unknown] = deviation;
        }
        let returning = self.opened.back.iter().flat_map(|back| &back.pulley_m);
        for (unknown, _) in RETURN_PULLEYS.into_iter().zip(returning) {
            deviations[unknown] = PULLEY_SIGMA_M;
        }
        deviations[K] = UNIFORM * length_m;
        deviations[RADIUS] = self.objects.sigma();
        deviations[ONSET] = 0.03;
        deviations[GIVE] = self.give_m_per_n;
        deviations
    }

    /// The finger with its pulleys off.
    pub(super) fn with_pulleys(&self, values: &[f64; UNKNOWNS]) -> Opened {
        let mut opened = self.opened.clone();
        for (stage, unknown) in opened.finger.stages.iter_mut().zip(PULLEYS) {
            if let Stage::Tendon { ratio } = stage {
                *ratio *= 1.0 + values[unknown];
            }
        }
        let returning = opened.back.iter_mut().flat_map(|back| &mut back.pulley_m);
        for (radius_m, unknown) in returning.zip(RETURN_PULLEYS) {
            *radius_m += values[unknown];
        }
        opened
    }

    pub(super) fn press(&self, phalanx: usize, values: &[f64; UNKNOWNS]) -> (Press, Drive) {
        let half_thickness_m = f64::from(self.settings.half_thickness_m);
        let press = Press {
            phalanx,
            k_m: values[K],
            radius_m: values[RADIUS].exp() - OFFSET_M + half_thickness_m,
            half_thickness_m,
            friction: values[FRICTION],
            joint_nm: values[JOINT],
            lost: values[LOSS],
            give_m_per_n: values[GIVE],
        };
        let drive = Drive {
            factor: values[FACTOR],
            cable_rad_per_nm: values[CABLE],
            stiffening_per_nm: values[BEND],
        };
        (press, drive)
    }

    /// Gears and cable by the data sheets.
    fn drive(&self) -> Drive {
        self.press(1, &self.means(&Chosen::SOME)).1
    }

    /// Measured angle at which joint 1 of the free finger is at an angle.
    pub(super) fn onset_rad(&self, theta_1_rad: f64) -> Option<f64> {
        let drive = self.drive();
        let theta_1 = |angle_rad: f64| Some(self.opened.free(angle_rad, &drive)?.theta[0]);
        let (mut low, mut high) = (0.0, self.closed_rad);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if theta_1(middle)? < theta_1_rad {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(low)
    }

    /// A contact as in the experiments with drawn fingers, or with the effect of a large object.
    pub(super) fn drawn(&self, random: &mut Pcg64Mcg) -> Option<Chosen> {
        let phalanx = random.random_range(self.first.max(2)..=self.lengths_m.len());
        let k_m = self.lengths_m[phalanx - 1] * random.random_range(0.1..0.9);
        let small_m = 0.5 * random.random_range(0.004_f64.ln()..0.040_f64.ln()).exp();
        Some(Chosen {
            phalanx,
            k_m,
            object_m: match self.objects {
                Objects::Usual => small_m,
                Objects::Large => self.objects.drawn_m(random),
            },
            onset_rad: self.onset_rad(random.random_range(0.65..0.95))?,
        })
    }
}
