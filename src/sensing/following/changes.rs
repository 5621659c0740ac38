//! Watches what becomes of a contact: where it has come to, and when it slips, is lost or is pushed from outside
//! (docs/SECOND_CONTACTS.md#held-contacts).

use super::fade::Fade;
use super::jump::Jumps;
use super::level::{Above, Level};
use super::rolled::{Placed, Rolled, Turned};
use super::stand::Stand;
use super::turn::TurnMeter;
use super::watched::{Watched, fallen_to};
use super::{AfterContact, Change, Followed, Grip};
use crate::finger::{Contact, Mechanics};
use crate::joint_sensor::JointSensor;
use crate::numeric::sqrt;
use crate::sensing::block::{Block, BlockAverager, BlockUpdate};
use crate::sensing::location::SeriesElement;
use crate::sensing::{Directive, Drive, Event, Sample, Sensor};
use heapless::Deque;

/// A finger that was let go or pushed swings so long, microseconds: what it does then is no change of its own.
const SETTLING_US: u64 = 100_000;
/// Standard deviation of the angle at which a contact began, radian (chosen).
const ONSET_SIGMA_RAD: f32 = 0.02;

/// Watches what becomes of a contact, beside what `A` looks for.
#[derive(Clone, Debug)]
pub struct Changes<A> {
    inner: A,
    averager: BlockAverager,
    watches: bool,
    turns: TurnMeter,
    level: Level,
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
            turns: TurnMeter::default(),
            level: Level::default(),
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
            self.turns.restart();
            self.level = Level::default();
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
            match step {
                BlockUpdate::Block(block) if block.drive == Drive::Closing => {
                    self.on_block(sensor, &block);
                }
                // A finger that opens holds nothing.
                BlockUpdate::Block(_) => (self.watched, self.rolled) = (None, None),
                _ => {}
            }
            self.on_sample(sensor, sample);
        }
        if let Some(event) = told {
            self.on_event(sensor, sample.time_us, event);
        }
        let followed = self.inner.sample(sensor, sample, told);
        self.place(sensor, told, followed.as_ref());
        if let Some(followed) = followed {
            self.emit(followed);
        }
        self.due.pop_front()
    }
}

impl<A> Changes<A> {
    fn emit(&mut self, followed: Followed) {
        // At most two in a sample, and a sample takes one: there is room.
        let _ = self.due.push_back(followed);
    }

    fn emit_change(&mut self, now_us: u64, change: Change, from_nm: f32, to_nm: f32) {
        self.emit(Followed::Changed {
            change,
            from_nm,
            to_nm,
        });
        // Where the contact was before says nothing any more.
        self.rolled = None;
        if change == Change::Lost {
            self.watched = None;
        } else if let Some(watched) = &mut self.watched {
            watched.has_changed = true;
            watched.since_us = now_us + SETTLING_US;
            watched.fade = Fade::after(to_nm);
            watched.jumps.pause(now_us as u32);
        }
    }

    /// A block of a closing.
    fn on_block<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        block: &Block,
    ) {
        let Some(above) = Above::of(sensor, block) else {
            return;
        };
        self.level.push(above.torque_nm);
        let Some(watched) = &mut self.watched else {
            return;
        };
        let excess_nm = above.torque_nm - watched.level_nm;
        watched.last = [sensor.drivetrain().closing_rad(block.counts), excess_nm];
        watched.note_noise(above.sigma_nm);
        let began_us = (block.time_us).saturating_sub((1e6 * block.duration_s) as u64);
        if began_us < watched.since_us {
            return;
        }
        // The drive turns the motor again: the current that held it while it stood no longer counts.
        watched.stand = Stand::default();
        let (noise_nm, nothing_nm) = (watched.noise_nm, watched.nothing_nm(sensor));
        if let Some(from_nm) = watched.fade.push(excess_nm, noise_nm, nothing_nm) {
            let change = fallen_to(excess_nm, nothing_nm);
            self.emit_change(block.time_us, change, from_nm, excess_nm);
        }
    }

    /// A sample: a jump of the torque, a motor that turned without load, or that stood and started by itself.
    fn on_sample<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
    ) {
        let drivetrain = sensor.drivetrain();
        let speed_rad_per_s = sensor.settings().speed_rad_per_s;
        let turn = (self.turns).push(sample, drivetrain, speed_rad_per_s);
        let Some(watched) = &mut self.watched else {
            return;
        };
        let gave_way = watched.stand.push(sample, drivetrain);
        if watched.stand.is_still() {
            self.turns.restart();
        }
        let held = watched.stand.held(drivetrain);
        let now_us = sample.time_us;
        if let Some(turn) = &turn {
            let seen = match &held {
                Some(held) => watched.freed(sensor, held, turn),
                None => watched.jumped(sensor, turn),
            };
            if let Some((change, from_nm, to_nm)) = seen {
                self.emit_change(now_us, change, from_nm, to_nm);
                return;
            }
        }
        if gave_way {
            let held = held.and_then(|held| watched.excess(sensor, &held));
            let held_nm = held.unwrap_or(f32::NAN);
            self.emit_change(now_us, Change::Slipped, f32::NAN, held_nm);
        }
    }

    /// What the sensor tells of the contact.
    fn on_event<F: Mechanics, H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &Sensor<F, H, X>,
        now_us: u64,
        event: &Event,
    ) {
        match *event {
            Event::Touch {
                theta_a_rad,
                torque_nm,
                ..
            } if self.watches => {
                self.rolled = None;
                self.watched = Some(Watched {
                    onset_rad: theta_a_rad,
                    level_nm: self.level.at_touch(torque_nm),
                    last: [theta_a_rad, torque_nm],
                    noise_nm: 0.0,
                    since_us: now_us,
                    fade: Fade::default(),
                    jumps: Jumps::default(),
                    stand: Stand::default(),
                    placed: None,
                    is_over: false,
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
                    watched.onset_rad = sensor.onset_rad();
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

    /// Begins to say where the contact is when the closing is over, with the last word on the grasp where there is one, else with that on
    /// the contact, and the motor stands: after that word it runs on, or closes on for the force that is wanted.
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
        watched.is_over |= match (followed, told) {
            (
                Some(Followed::SecondContact {
                    phalanx,
                    torque_nm,
                    theta_a_rad,
                    ..
                }),
                _,
            ) => {
                // The first one is on another phalanx then than was told, and has no place.
                watched.placed =
                    (watched.placed).filter(|placed| placed.contact.phalanx != *phalanx);
                watched.second = Some([*theta_a_rad, *torque_nm]);
                false
            }
            (Some(Followed::Grasp { grip, .. }), _) => *grip != Grip::Lost,
            (None, Some(Event::Located { settled: true, .. })) => !A::FOLLOWS,
            _ => false,
        };
        if watched.is_over
            && watched.placed.is_some()
            && !watched.has_changed
            && (watched.stand.is_still() || !self.watches)
        {
            let drivetrain = sensor.drivetrain();
            // Take angle and torque of the last block, or of the stand where the motor has closed on since to hold more.
            if let Some(held) = watched.stand.held(drivetrain)
                && let Some(held_nm) = watched.excess(sensor, &held)
                && held_nm > watched.last[1]
            {
                watched.last = [drivetrain.closing_rad(held.counts), held_nm];
            }
            // With a second contact the first does not move any more.
            let [angle_rad, excess_nm] = watched.second.unwrap_or(watched.last);
            let calibration = sensor.calibration();
            let springs_nm = |rad| sensor.free_at(rad).map_or(0.0, |free| free.torque_nm);
            let free_nm = springs_nm(watched.onset_rad);
            let end_nm = calibration.torque_factor * excess_nm + springs_nm(angle_rad);
            let torque_nm = end_nm - free_nm;
            let (mut rotation_rad, mut sigma_rad) =
                (angle_rad - watched.onset_rad, ONSET_SIGMA_RAD);
            if X::FLEXIBLE {
                let [rise_nm, nominal_nm] =
                    [torque_nm, end_nm].map(|nm| nm / calibration.torque_factor);
                let [twist_rad, twist_sigma_rad] = calibration.twist_rad(rise_nm, nominal_nm);
                rotation_rad -= twist_rad;
                sigma_rad = sqrt(sigma_rad * sigma_rad + twist_sigma_rad * twist_sigma_rad);
            }
            let settings = sensor.settings();
            let nominal_m = settings.pin_contact_radius_m();
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
                self.emit(moved);
            }
        }
    }
}
