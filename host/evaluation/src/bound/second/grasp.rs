//! Grasps in which two phalanges touch a cylinder, and the torque curve that one shows for any values of what is not known.

use palpate_simulation::places::PIN_RAD;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::bound::information::{LEAD, TOP_SHARE};
pub(super) use crate::bound::known::{BEND, CABLE, FACTOR, JOINT, LOSS};
use crate::bound::known::{Known, OFFSET_M, TURNS};
use crate::reference::{Drive, HeldTwice, Rubs, Touching};

/// Unknowns that the finger takes from one contact to the next, beside the first five of [`Known`]: what each stage of the transmission is
/// off by.
pub(super) const LEVERS: [usize; 2] = [5, 6];
/// Unknown of a material: the pins', or the object's.
pub(super) const FRICTION: usize = 7;
/// Unknowns of the first contact: place, logarithm of the object's radius plus [`OFFSET_M`], measured angle of the onset.
pub(super) const K: usize = 8;
pub(super) const RADIUS: usize = 9;
pub(super) const ONSET: usize = 10;
/// Unknowns of the second: place as it begins, the measured angle there, and the radius as that of the first.
pub(super) const SECOND: usize = 11;
pub(super) const CORNER: usize = 12;
pub(super) const RADIUS_THERE: usize = 13;
pub(super) const UNKNOWNS: usize = 14;
/// Values of all of them.
pub(super) type Values = [f64; UNKNOWNS];

/// Turns of the motor with two contacts at least, and the second's force at the end, newton, as in the experiments.
const LEAST_TURNS: f64 = 4.0;
const LEAST_N: f64 = 0.2;
/// From so much of a point's width after the onset on there are points.
const BEGINS: f64 = 0.3;
/// Halvings of a step within which the second contact begins.
const HALVINGS: u8 = 40;

/// What is known of a finger before it grasps, with the mean and deviation that depend on the world.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    pub(super) known: Known,
    /// Contact friction, as its user states it.
    pub(super) friction: [f64; 2],
}

/// A grasp, with the measured angles of its curve's points.
#[derive(Clone, Debug)]
pub(super) struct Grasp {
    /// The first phalanx in contact, from 1, and the second.
    pub(super) phalanges: [Option<usize>; 2],
    pub(super) values: Values,
    /// Measured angles, radian: without contact, with the first one, with both.
    pub(super) angles: Vec<f64>,
    /// How many of them are before the second contact.
    pub(super) before: usize,
}

/// What a grasp shows.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    /// Nominal torque above that of the free finger at every angle, newton metre; ends where no posture is found.
    pub(super) excess_nm: Vec<f64>,
    /// Logarithms of what is 1 where a cylinder touches phalanges side by side: their places' distances from the joint between them, and
    /// each radius over the one that follows from the first.
    pub(super) shape: Option<[f64; 3]>,
    /// All that touches presses, within its phalanx, and no joint is at its stop.
    pub(super) stays: bool,
}

/// A grasp being closed, with the torque above the free finger's.
struct Closing<'a> {
    held: HeldTwice<'a>,
    factor: f64,
}

impl Closing<'_> {
    fn excess_nm(&mut self) -> Option<f64> {
        let now = *self.held.now();
        let free_nm = self.held.free_nm(now.angle_rad)?;
        Some((now.torque_nm - free_nm) / self.factor)
    }
}

/// Whether the place of a second contact changes the stiffness (docs/SECOND_CONTACTS.md#place-of-the-second-contact).
fn tells_place(first: usize, second: usize) -> bool {
    matches!((first, second), (1 | 2, 3) | (3, 2))
}

impl Asked {
    /// Width of a point, radian.
    fn width_rad(&self) -> f64 {
        TURNS * self.known.turn_rad
    }

    fn half_m(&self) -> f64 {
        self.known.settings.half_thickness_m.into()
    }

    /// The unknowns' means; those of a contact are 0.
    pub(super) fn means(&self) -> Values {
        let sheet = &self.known.sheet;
        let mut means = [0.0; UNKNOWNS];
        means[FACTOR] = sheet.torque_factor.into();
        means[CABLE] = sheet.cable_rad_per_nm.into();
        means[BEND] = sheet.stiffening_per_nm.into();
        means[JOINT] = self.known.settings.joint_friction_nm[0].into();
        [means[LOSS], _] = self.known.joint_loss;
        means[FRICTION] = self.friction[0];
        means
    }

    fn touching(&self, phalanx: usize, k_m: f64, radius: f64) -> Touching {
        Touching {
            phalanx,
            k_m,
            radius_m: radius.exp() - OFFSET_M + self.half_m(),
        }
    }

    /// The finger at the onset, in contact.
    fn at_onset(&self, phalanx: usize, values: &Values) -> Option<Closing<'_>> {
        let rubs = Rubs {
            friction: values[FRICTION],
            joint_nm: values[JOINT],
            loss: values[LOSS],
            uneven: LEVERS.map(|lever| values[lever]),
        };
        let drive = Drive {
            factor: values[FACTOR],
            cable_rad_per_nm: values[CABLE],
            stiffening_per_nm: values[BEND],
        };
        let opened = &self.known.opened;
        let mut held = HeldTwice::new(opened, rubs, self.half_m(), drive, values[ONSET])?;
        held.touch(&self.touching(phalanx, values[K], values[RADIUS]));
        let factor = drive.factor;
        Some(Closing { held, factor })
    }

    /// The curve of a grasp with other values of what is not known.
    pub(super) fn shown(&self, grasp: &Grasp, values: &Values) -> Option<Shown> {
        let mut closing = self.at_onset(grasp.phalanges[0]?, values)?;
        let mut shown = Shown {
            excess_nm: Vec::with_capacity(grasp.angles.len()),
            shape: None,
            stays: true,
        };
        let mut awaited = grasp.phalanges[1];
        for &angle_rad in &grasp.angles {
            if angle_rad <= values[ONSET] {
                shown.excess_nm.push(0.0);
                continue;
            }
            if let Some(second) = awaited.filter(|_| angle_rad > values[CORNER]) {
                if !closing.held.close_to(values[CORNER]) {
                    break;
                }
                shown.shape = self.shape(grasp, &closing.held, values);
                let there = self.touching(second, values[SECOND], values[RADIUS_THERE]);
                closing.held.touch(&there);
                awaited = None;
            }
            if !closing.held.close_to(angle_rad) {
                break;
            }
            shown.stays &= closing.held.stays();
            shown.excess_nm.push(closing.excess_nm()?);
        }
        Some(shown)
    }

    /// See [`Shown`]; at the instant of the second contact.
    fn shape(&self, grasp: &Grasp, held: &HeldTwice, values: &Values) -> Option<[f64; 3]> {
        let [first, second] = [grasp.phalanges[0]?, grasp.phalanges[1]?];
        if first.abs_diff(second) != 1 {
            return None;
        }
        let joint = first.max(second) - 1;
        let near_m = |phalanx: usize, k_m: f64| {
            if phalanx > joint {
                k_m
            } else {
                self.known.lengths_m[phalanx - 1] - k_m
            }
        };
        let near_first_m = near_m(first, held.along_m(0)?);
        let radius_m = near_first_m / (0.5 * held.now().theta[joint]).tan();
        let over = |radius: f64| (self.touching(1, 0.0, radius).radius_m / radius_m).ln();
        let apart = (near_m(second, values[SECOND]) / near_first_m).ln();
        let shape = [apart, over(values[RADIUS]), over(values[RADIUS_THERE])];
        shape.iter().all(|x| x.is_finite()).then_some(shape)
    }

    /// Measured angle at which a curve ends: that of the probing, or of the closing stop.
    fn end_rad(&self, onset_rad: f64) -> f64 {
        let known = &self.known;
        (onset_rad + known.probing_rad).min(known.closed_rad)
    }

    fn is_over(&self, closing: &mut Closing) -> bool {
        let top_nm = TOP_SHARE * f64::from(self.known.settings.torque_limit_nm);
        !closing.held.stays() || closing.excess_nm().is_none_or(|excess| excess > top_nm)
    }

    /// A pin, at a share of the last phalanx.
    pub(super) fn pin(&self, share: f64) -> Option<Grasp> {
        let phalanx = self.known.lengths_m.len();
        let mut values = self.means();
        values[K] = share * self.known.lengths_m[phalanx - 1];
        values[RADIUS] = (f64::from(self.known.settings.pin_radius_m) + OFFSET_M).ln();
        values[ONSET] = self.known.onset_rad(PIN_RAD)?;
        let mut closing = self.at_onset(phalanx, &values)?;
        let width_rad = self.width_rad();
        let at = |point: usize| values[ONSET] + width_rad * (point as f64 + 0.5 - LEAD as f64);
        let mut angles: Vec<f64> = (0..LEAD).map(at).collect();
        while at(angles.len()) < self.end_rad(values[ONSET])
            && closing.held.close_to(at(angles.len()))
            && !self.is_over(&mut closing)
        {
            angles.push(at(angles.len()));
        }
        Some(Grasp {
            phalanges: [Some(phalanx), None],
            values,
            before: angles.len(),
            angles,
        })
    }

    /// A grasp as in the experiments with second contacts, on a finger with these values. `None` where the object does not fit, no second
    /// phalanx comes to press, or its place changes nothing.
    pub(super) fn drawn(&self, shared: Values, random: &mut Pcg64Mcg) -> Option<Grasp> {
        let lengths_m = &self.known.lengths_m;
        let is_large = random.random_bool(0.6);
        let first = random.random_range(1..=lengths_m.len() - usize::from(is_large));
        let (share, diameter_m) = if is_large {
            (0.5..0.95, 0.04..0.10)
        } else {
            (0.2..0.9, 0.006..0.03)
        };
        let radius_m = 0.5 * random.random_range(diameter_m);
        let mut values = shared;
        values[K] = random.random_range(share) * lengths_m[first - 1];
        values[RADIUS] = (radius_m + OFFSET_M).ln();
        values[RADIUS_THERE] = values[RADIUS];
        values[ONSET] = self.known.onset_rad(random.random_range(0.55..1.0))?;

        let mut closing = self.at_onset(first, &values)?;
        if !self.fits(&closing.held) || !self.fits(&closing.held.opened_fully()) {
            return None;
        }
        let second = self.until_second(first, &mut closing)?;
        values[CORNER] = closing.held.now().angle_rad;
        values[SECOND] = closing.held.gap_m(second)?[1];
        let third = 6 - first - second;
        let width_rad = self.width_rad();
        // The second contact begins between two points, and never in one.
        let at = |point: i32| values[CORNER] + width_rad * (f64::from(point) + 0.5);
        let first_point = ((values[ONSET] - values[CORNER]) / width_rad - 0.5 + BEGINS).ceil();
        let begins = (first_point as i32).min(0);
        let lead = LEAD as i32;
        // The point within which the first contact begins is left out.
        let free = (begins - 1 - lead)..(begins - 1);
        let mut angles: Vec<f64> = free.chain(begins..0).map(at).collect();
        let before = angles.len();
        let there = self.touching(second, values[SECOND], values[RADIUS_THERE]);
        closing.held.touch(&there);
        let mut force_n = 0.0;
        for point in 0.. {
            if at(point) > self.end_rad(values[ONSET])
                || !closing.held.close_to(at(point))
                || self.is_over(&mut closing)
                || self.reaches(&closing.held, third)
            {
                break;
            }
            angles.push(at(point));
            force_n = closing.held.now().forces_n[1];
        }
        let turns = TURNS * (angles.len() - before) as f64;
        let is_power = turns >= LEAST_TURNS && force_n >= LEAST_N && tells_place(first, second);
        is_power.then_some(Grasp {
            phalanges: [Some(first), Some(second)],
            values,
            angles,
            before,
        })
    }

    /// Whether the object is clear of all phalanges but for those that touch it.
    fn fits(&self, held: &HeldTwice) -> bool {
        let phalanges = self.known.lengths_m.len();
        let clear = (1..=phalanges).all(|phalanx| {
            (held.gap_m(phalanx)).is_some_and(|[gap_m, along_m]| {
                let is_beside = !(0.0..=self.known.lengths_m[phalanx - 1]).contains(&along_m);
                gap_m > -1e-9 || is_beside
            })
        });
        let joints = (0..=phalanges).all(|joint| held.clear_of_m(joint).is_some_and(|m| m > 0.0));
        clear && joints
    }

    /// Whether a phalanx has come to the object.
    fn reaches(&self, held: &HeldTwice, phalanx: usize) -> bool {
        let length_m = self.known.lengths_m[phalanx - 1];
        (held.gap_m(phalanx))
            .is_some_and(|[gap_m, along_m]| gap_m <= 0.0 && along_m > 0.0 && along_m < length_m)
    }

    /// Closes on until another phalanx touches: which one.
    fn until_second(&self, first: usize, closing: &mut Closing) -> Option<usize> {
        let onset_rad = closing.held.now().angle_rad;
        let width_rad = self.width_rad();
        let others = (1..=self.known.lengths_m.len()).filter(|other| *other != first);
        let others: Vec<usize> = others.collect();
        loop {
            let before = closing.held.clone();
            let from_rad = before.now().angle_rad;
            let next_rad = from_rad + width_rad;
            if next_rad > self.end_rad(onset_rad)
                || !closing.held.close_to(next_rad)
                || self.is_over(closing)
            {
                return None;
            }
            let reached = |held: &HeldTwice| {
                let there = others.iter().find(|other| self.reaches(held, **other));
                there.copied()
            };
            let Some(second) = reached(&closing.held) else {
                continue;
            };
            let (mut low, mut high) = (0.0, width_rad);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                let mut held = before.clone();
                if !held.close_to(from_rad + middle) {
                    return None;
                }
                if self.reaches(&held, second) {
                    high = middle;
                    closing.held = held;
                } else {
                    low = middle;
                }
            }
            // A phalanx that the object comes onto from the end touches with its end first.
            let [gap_m, _] = closing.held.gap_m(second)?;
            return (gap_m > -1e-6).then_some(second);
        }
    }
}
