//! Watches what becomes of a contact: where it has come to, and when it slips, is lost or is pushed from outside
//! (docs/MECHANICS.md#held-contacts).

use super::rise::{Rise, RiseBlock};
use super::rolled::{Placed, Rolled, Turned};
use super::stand::{Stand, Standing};
use super::{AfterContact, Change, Followed, Grip};
use crate::finger::{Contact, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::numeric::{Bounded, sqrt};
use crate::sensing::block::{Block, BlockAverager, BlockUpdate};
use crate::sensing::location::SeriesElement;
use crate::sensing::{Directive, Drive, Event, Sample, Sensor};
use heapless::Deque;

/// Deviations of a block that count as noise.
const SIGMAS: f32 = 8.0;
/// Share of the torque limit below which nothing is held (chosen): twice as far as friction wanders.
const NOTHING_SHARE: f32 = 0.03;
/// Of the torque before, or of what the holding current holds, the share below which a turn of the motor has no load.
const FREE_SHARE: f32 = 0.3;
/// Standard deviation of the angle at which a contact began, radian (chosen).
const ONSET_SIGMA_RAD: f32 = 0.01;
/// How much stiffer than its mean compliance says a cable may be that stiffens with its load.
const STIFFENED: f32 = 1.25;
/// A cable may be so much stiffer than its nominal value at most, whatever its deviation.
const LEAST_CABLE_SHARE: f32 = 0.2;

/// A closing in contact.
#[derive(Clone, Debug)]
struct Watched {
    /// Angle of the input link at the onset, radian.
    onset_rad: f32,
    /// What the record's level was off by at the onset, newton metre at the input link.
    level_nm: f32,
    /// Angle of the input link, the cable's twist included, and torque above friction at the last block.
    last: [f32; 2],
    rise: Rise,
    stand: Stand,
    placed: Option<Placed>,
    /// The contact has changed: its place is not known any more.
    has_changed: bool,
    /// The same at a second contact.
    second: Option<[f32; 2]>,
}

/// Watches what becomes of a contact, beside what `A` looks for.
#[derive(Clone, Debug)]
pub struct Changes<A> {
    inner: A,
    averager: BlockAverager,
    watches: bool,
    /// Torque above the record in the last two blocks, newton metre at the input link.
    before_nm: [f32; 2],
    watched: Option<Watched>,
    /// Where the contact has come to, being worked out.
    rolled: Option<Rolled>,
    due: Deque<Followed, 4>,
}

impl<A: Default> Default for Changes<A> {
    fn default() -> Self {
        Self {
            inner: A::default(),
            averager: BlockAverager::default(),
            watches: false,
            before_nm: [f32::NAN; 2],
            watched: None,
            rolled: None,
            due: Deque::new(),
        }
    }
}

impl<F: Mechanics, A: AfterContact<F>> AfterContact<F> for Changes<A> {
    const FOLLOWS: bool = A::FOLLOWS;

    fn direct(&mut self, directive: Directive) {
        self.inner.direct(directive);
        self.watches = matches!(directive, Directive::Watch);
        // At rest the last word on the contact is still due.
        if !matches!(directive, Directive::Rest) {
            self.before_nm = [f32::NAN; 2];
            self.watched = None;
            self.rolled = None;
        }
    }

    #[inline(never)]
    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &mut Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
        told: Option<&Event>,
    ) -> Option<Followed> {
        let step = (self.averager).push(sample, sensor.drivetrain(), sensor.settings());
        if self.watches {
            if let BlockUpdate::Block(block) = step
                && block.drive == Drive::Closing
            {
                self.take(sensor, &block);
            }
            self.stand(sensor, sample);
        }
        if let Some(event) = told {
            self.hear(event);
        }
        let followed = self.inner.sample(sensor, sample, told);
        self.place(sensor, told, followed.as_ref());
        if let Some(followed) = followed {
            self.tell(followed);
        }
        self.due.pop_front()
    }
}

impl<A> Changes<A> {
    fn tell(&mut self, followed: Followed) {
        // At most two in a sample, and a sample takes one: there is room.
        let _ = self.due.push_back(followed);
    }

    fn tell_change(&mut self, change: Change, from_nm: f32, to_nm: f32) {
        self.tell(Followed::Changed {
            change,
            from_nm,
            to_nm,
        });
        if change == Change::Lost {
            self.watched = None;
        } else if let Some(watched) = &mut self.watched {
            watched.has_changed = true;
        }
    }

    /// A block of a closing.
    fn take<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        block: &Block,
    ) {
        let Some(residual) = sensor.residual(block) else {
            return;
        };
        let efficiency = sensor.drivetrain().efficiency;
        let above_nm = efficiency * residual.torque_nm;
        let [_, last_nm] = self.before_nm;
        self.before_nm = [last_nm, above_nm];
        let Some(watched) = &mut self.watched else {
            return;
        };
        let excess_nm = above_nm - watched.level_nm;
        let angle_rad = sensor.drivetrain().closing_rad(block.counts);
        watched.last = [angle_rad, excess_nm];
        let noise_nm = SIGMAS * efficiency * sqrt(residual.variance_nm2);
        let jump = watched.rise.push(&RiseBlock {
            angle_rad,
            torque_nm: excess_nm,
            noise_nm,
            steepest_nm_per_rad: steepest(sensor),
            nothing_nm: noise_nm.at_least(NOTHING_SHARE * sensor.settings().torque_limit_nm),
        });
        if let Some((change, from_nm, to_nm)) = jump {
            self.tell_change(change, from_nm, to_nm);
        }
    }

    /// A sample: a motor that turned without load, or that stood and started by itself.
    fn stand<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
    ) {
        let Some(watched) = &mut self.watched else {
            return;
        };
        let (drivetrain, settings) = (sensor.drivetrain(), sensor.settings());
        let seen = (watched.stand).push(sample, drivetrain, settings.speed_rad_per_s);
        if seen == Standing::Nothing {
            return;
        }
        let level_nm = watched.level_nm;
        let excess = |block: &Block| {
            let residual = sensor.residual(block)?;
            Some(drivetrain.efficiency * residual.torque_nm - level_nm)
        };
        let held_nm = watched.stand.held(drivetrain).as_ref().and_then(excess);
        match seen {
            Standing::Nothing => {}
            Standing::GaveWay => {
                self.tell_change(Change::Slipped, f32::NAN, held_nm.unwrap_or(f32::NAN));
            }
            Standing::Turned(block) => {
                let before_nm = held_nm.unwrap_or(watched.rise.top_nm());
                if let Some(left_nm) = excess(&block)
                    && before_nm > 2.0 * NOTHING_SHARE * settings.torque_limit_nm
                    && left_nm < FREE_SHARE * before_nm
                {
                    self.tell_change(Change::Lost, before_nm, left_nm);
                }
            }
        }
    }

    /// What the sensor tells of the contact.
    fn hear(&mut self, event: &Event) {
        match *event {
            Event::Touch {
                theta_a_rad,
                torque_nm,
                ..
            } if self.watches => {
                // The sensor tells the torque of the block before the last.
                let [before_nm, _] = self.before_nm;
                self.watched = Some(Watched {
                    onset_rad: theta_a_rad,
                    level_nm: before_nm - torque_nm,
                    last: [theta_a_rad, torque_nm],
                    rise: Rise::default(),
                    stand: Stand::default(),
                    placed: None,
                    has_changed: false,
                    second: None,
                });
            }
            Event::Located {
                phalanx,
                k_m,
                sigma_m,
                radius_m,
                radius_sigma_m,
                settled: true,
                ..
            } => {
                if let Some(watched) = &mut self.watched {
                    watched.placed = Some(Placed {
                        contact: Contact {
                            phalanx,
                            k_m,
                            radius_m,
                        },
                        sigma_m,
                        radius_sigma_m,
                    });
                }
            }
            _ => {}
        }
    }

    /// Begins to say where the contact is when the closing is over: with the last word on the grasp where there is one, else with
    /// that on the contact.
    fn place<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        told: Option<&Event>,
        followed: Option<&Followed>,
    ) where
        A: AfterContact<F>,
    {
        let Some(watched) = &mut self.watched else {
            return;
        };
        let is_over = match (followed, told) {
            (
                Some(Followed::SecondContact {
                    torque_nm,
                    theta_a_rad,
                    ..
                }),
                _,
            ) => {
                watched.second = Some([*theta_a_rad, *torque_nm]);
                false
            }
            (Some(Followed::Grasp { grip, .. }), _) => *grip != Grip::Lost,
            (None, Some(Event::Located { settled: true, .. })) => !A::FOLLOWS,
            _ => false,
        };
        if is_over && !watched.has_changed {
            // With a second contact the first does not move any more.
            let [angle_rad, excess_nm] = watched.second.unwrap_or(watched.last);
            let calibration = sensor.calibration();
            let torque_nm = calibration.torque_factor * excess_nm;
            let (mut rotation_rad, mut sigma_rad) =
                (angle_rad - watched.onset_rad, ONSET_SIGMA_RAD);
            if X::FLEXIBLE {
                let [twist_rad, twist_sigma_rad] = calibration.twist_rad(excess_nm);
                rotation_rad -= twist_rad;
                sigma_rad = sqrt(sigma_rad * sigma_rad + twist_sigma_rad * twist_sigma_rad);
            }
            let settings = sensor.settings();
            let nominal_m = settings.half_thickness_m + settings.pin_radius_m;
            self.rolled = watched.placed.take().map(|placed| {
                Rolled::new(
                    placed,
                    nominal_m,
                    Turned {
                        onset_rad: watched.onset_rad,
                        rotation_rad,
                        sigma_rad,
                        torque_nm,
                        excess_nm,
                    },
                )
            });
        }
        if let Some(rolled) = &mut self.rolled
            && let Some(moved) = rolled.step(sensor)
        {
            self.rolled = None;
            if let Some(moved) = moved {
                self.tell(moved);
            }
        }
    }
}

/// The steepest rise of nominal torque over angle that the cable allows, newton metre per radian; infinite without one.
fn steepest<F: Mechanics, H: JointSensor, X: SeriesElement>(sensor: &Sensor<F, H, X>) -> f32 {
    if !X::FLEXIBLE {
        return f32::INFINITY;
    }
    let calibration = sensor.calibration();
    let cable = calibration.cable_rad_per_nm;
    let least = cable - 2.0 * calibration.cable_sigma_rad_per_nm;
    STIFFENED / least.at_least(LEAST_CABLE_SHARE * cable)
}
