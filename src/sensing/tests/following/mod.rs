//! What follows a first contact, over whole closings: a closing, a contact, what becomes of it, the hold, and the next closing.

mod changes;
mod grasps;
mod hold;
mod moments;
mod moved;

use super::sensor::friction_a;
use crate::finger::{Contact, Mechanics};
use crate::scene::{P70, Scene};
use crate::sensing::{
    AfterContact, Calibration, Change, Directive, Drive, Event, Followed, Sample, Sensor, Settings,
};

/// Of a sample a millisecond at 0.3 rad/s, radian.
const STEP_RAD: f32 = 0.3e-3;

/// The cable as it is, without stiffening.
pub(super) const CALIBRATION: Calibration = Calibration {
    torque_factor: 1.0,
    torque_factor_sigma: 0.01,
    cable_rad_per_nm: 0.8,
    cable_sigma_rad_per_nm: 0.01,
    correlation: 0.0,
    stiffening_per_nm: 0.0,
    stiffening_sigma_per_nm: 0.01,
    joint_nm: 0.0,
    joint_sigma_nm: 0.0,
    joint_correlation: 0.0,
    worm_rad: [0.0; 2],
    contacts: 2,
    presses: 1,
};

/// What was told, and when, millisecond.
#[derive(Clone, Debug, Default)]
struct Told {
    events: Vec<(u64, Event)>,
    followed: Vec<(u64, Followed)>,
}

impl Told {
    fn touches(&self) -> usize {
        let touch = |(_, event): &&(u64, Event)| matches!(event, Event::Touch { .. });
        self.events.iter().filter(touch).count()
    }

    /// When the last word on the first contact came.
    fn settled_ms(&self) -> Option<u64> {
        self.events.iter().find_map(|(ms, event)| match event {
            Event::Located { settled: true, .. }
            | Event::Ambiguous { settled: true, .. }
            | Event::NotLocated { .. } => Some(*ms),
            _ => None,
        })
    }

    fn changes(&self) -> Vec<(u64, Change, f32, f32)> {
        let change = |(ms, followed): &(u64, Followed)| match *followed {
            Followed::Changed {
                change,
                from_nm,
                to_nm,
            } => Some((*ms, change, from_nm, to_nm)),
            _ => None,
        };
        self.followed.iter().filter_map(change).collect()
    }

    fn moved(&self) -> Option<&Followed> {
        let moved = |followed: &&Followed| matches!(followed, Followed::Moved { .. });
        self.followed.iter().map(|(_, f)| f).find(moved)
    }
}

/// A finger whose friction is recorded, with what follows its first contact. A sample takes a millisecond.
struct Hand<F: Mechanics, A> {
    sensor: Sensor<F>,
    after: A,
    ms: u64,
    angle_rad: f32,
    /// Friction over that of the record, newton metre at the input link.
    level_nm: f32,
    told: Told,
}

impl<F: Mechanics, A: AfterContact<F>> Hand<F, A> {
    /// Records the friction of a finger whose free motion takes a torque of its own.
    fn new(sensor: Sensor<F>, travel_rad: f32) -> Self {
        let mut hand = Self {
            sensor,
            after: A::default(),
            ms: 0,
            angle_rad: 0.0,
            level_nm: 0.0,
            told: Told::default(),
        };
        hand.direct(Directive::RecordFriction);
        let stop_rad = hand.theta_a_rad();
        hand.close(stop_rad + travel_rad, |_| 0.0);
        hand.open();
        hand.direct(Directive::Watch);
        let told = hand.close(stop_rad + 0.05, |_| 0.0);
        hand.open();
        assert!(
            matches!(told.events[..], [(_, Event::FrictionRecorded { coverage, .. })] if coverage > 0.9),
            "{told:?}"
        );
        hand
    }

    fn direct(&mut self, directive: Directive) {
        self.sensor.direct(directive);
        self.after.direct(directive);
    }

    fn sample(&mut self, drive: Drive, current_a: f32) {
        self.ms += 1;
        let rad_per_count = f64::from(self.sensor.drivetrain().rad_per_count);
        let sample = Sample {
            emf_v: f32::NAN,
            time_us: 1000 * self.ms,
            position_counts: (f64::from(self.angle_rad) / rad_per_count) as i32,
            current_a,
            drive,
            joint: (),
        };
        let event = self.sensor.update(&sample);
        let followed = (self.after).sample(&mut self.sensor, &sample, event.as_ref());
        self.told.events.extend(event.map(|event| (self.ms, event)));
        let followed = followed.map(|followed| (self.ms, followed));
        self.told.followed.extend(followed);
    }

    /// Angle of the input link, as a closing has it.
    fn theta_a_rad(&self) -> f32 {
        self.sensor.drivetrain().closing_rad(0) + self.angle_rad
    }

    /// Current of a closing motor at a torque of the input link beyond that of the free finger.
    fn current_a(&self, beyond_nm: f32) -> f32 {
        let drivetrain = self.sensor.drivetrain();
        let free = self.sensor.free_at(self.theta_a_rad());
        let free_nm = free.map_or(0.0, |free| free.torque_nm);
        friction_a(self.angle_rad)
            + (beyond_nm + free_nm + self.level_nm)
                / (drivetrain.efficiency * drivetrain.torque_per_ampere_nm)
    }

    /// Closes at 0.3 rad/s up to an angle of the input link, with a torque beyond that of the free finger by that angle.
    fn close(&mut self, to_rad: f32, beyond_nm: impl Fn(f32) -> f32) -> Told {
        let from_rad = self.angle_rad;
        for step in 1..=((to_rad - self.theta_a_rad()) / STEP_RAD) as i32 {
            self.angle_rad = from_rad + STEP_RAD * step as f32;
            let current_a = self.current_a(beyond_nm(self.theta_a_rad()));
            self.sample(Drive::Closing, current_a);
        }
        core::mem::take(&mut self.told)
    }

    /// Moves on by an angle at every millisecond, with a current.
    fn turn(&mut self, ms: u64, current_a: f32, way_rad: impl Fn(f32) -> f32) -> Told {
        let from_rad = self.angle_rad;
        for i in 1..=ms {
            self.angle_rad = from_rad + way_rad(1e-3 * i as f32);
            self.sample(Drive::Closing, current_a);
        }
        core::mem::take(&mut self.told)
    }

    /// Stands with a constant current.
    fn stand(&mut self, ms: u64, current_a: f32) -> Told {
        for _ in 0..ms {
            self.sample(Drive::Idle, current_a);
        }
        core::mem::take(&mut self.told)
    }

    /// Opens, and stands.
    fn open(&mut self) -> Told {
        let from_rad = self.angle_rad;
        for step in 1..=(from_rad / STEP_RAD) as i32 {
            self.angle_rad = from_rad - STEP_RAD * step as f32;
            let current_a = -friction_a(self.angle_rad);
            self.sample(Drive::Opening, current_a);
        }
        self.angle_rad = 0.0;
        self.stand(400, 0.0)
    }

    /// A closing under a directive of its own.
    fn watch(&mut self, to_rad: f32, beyond_nm: impl Fn(f32) -> f32) -> Told {
        self.direct(Directive::Watch);
        self.close(to_rad, beyond_nm)
    }
}

/// A finger without springs at the base, whose free motion takes no torque.
fn p70<A: AfterContact<<P70 as Scene>::Finger>>(
    settings: Settings,
) -> Hand<<P70 as Scene>::Finger, A> {
    let finger = P70::MECHANISM;
    let mut sensor = Sensor::new(finger, P70::drivetrain(&finger), settings, CALIBRATION);
    assert!(sensor.set_calibration(CALIBRATION));
    Hand::new(sensor, 1.5)
}

/// Settings of a scene with which the last word on a contact comes when the motion ends.
fn to_the_end<S: Scene>() -> Settings {
    Settings {
        wanted_sigma_m: 0.0,
        ..S::settings()
    }
}

/// A contact's path, with friction and losses as a fit expects them: how far the input link turns, the cable's twist included, the torque,
/// and the place.
struct Way {
    onset_rad: f32,
    points: Vec<[f32; 3]>,
}

impl Way {
    /// From an onset until the torque has risen by so much.
    fn of<F: Mechanics>(
        sensor: &Sensor<F>,
        onset_rad: f32,
        contact: Contact,
        rise_nm: f32,
    ) -> Self {
        let finger = sensor.finger();
        let free = sensor.free_at(onset_rad).expect("a posture");
        let path = finger.path(&free.configuration, free.torque_nm, contact);
        let mut path = path.expect("a contact");
        finger.lose(&mut path);
        let half_m = sensor.settings().half_thickness_m;
        finger.rub(&mut path, 0.1, half_m).expect("a path");
        let mut points = vec![[0.0, 0.0, contact.k_m]];
        let steps = (1e3 * rise_nm) as usize;
        points.extend((1..=steps).map(|step| {
            let torque_nm = 1e-3 * step as f32;
            let point = finger.follow(&mut path, torque_nm).expect("a point");
            let twist_rad = CALIBRATION.cable_rad_per_nm * torque_nm;
            [point.rotation_rad + twist_rad, torque_nm, point.k_now_m]
        }));
        Self { onset_rad, points }
    }

    /// Angle of the input link at its end.
    fn end_rad(&self) -> f32 {
        self.onset_rad + self.points[self.points.len() - 1][0]
    }

    /// Torque since the onset at an angle of the input link.
    fn rise_nm(&self, theta_a_rad: f32) -> f32 {
        let past_rad = theta_a_rad - self.onset_rad;
        let after = self.points.partition_point(|[angle, ..]| *angle < past_rad);
        match (after.checked_sub(1), self.points.get(after)) {
            (None, _) => 0.0,
            (Some(before), Some([b, to, _])) => {
                let [a, from, _] = self.points[before];
                from + (to - from) * (past_rad - a) / (b - a)
            }
            (Some(before), None) => self.points[before][1],
        }
    }
}
