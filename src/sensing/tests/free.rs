//! Free motion drawn from a model: a friction curve, an Ornstein-Uhlenbeck process, a drift, white noise; in f64.

use super::{Noise, drivetrain};
use crate::sensing::block::Block;
use crate::sensing::friction::{Assessment, Friction, Pass};
use crate::sensing::{Drive, Drivetrain};

/// Blocks of a pass, and where they begin.
pub const FIRST: i32 = 16;
pub const BLOCKS: i32 = 290;
/// Instants whose mean is a block.
const INSTANTS: u32 = 8;

/// A drivetrain whose friction wanders, all shares of its mean friction.
#[derive(Clone, Copy, Debug)]
pub struct World {
    pub wander: f64,
    pub time_s: f64,
    pub drift: f64,
    pub speed: f64,
    pub white_nm: f64,
}

/// Those of the recordings that the sensing is judged by, and one that does not wander.
pub const WORLDS: [World; 7] = [
    world(0.003, 3.0, 0.0, 0.2),
    world(0.01, 3.0, 0.0, 0.3),
    world(0.01, 10.0, -0.03, 0.3),
    world(0.02, 3.0, -0.02, 0.2),
    world(0.03, 1.0, -0.05, 0.3),
    world(0.01, 1.0, 0.02, 0.3),
    world(0.0, 1.0, 0.0, 0.3),
];

const fn world(wander: f64, time_s: f64, drift: f64, speed: f64) -> World {
    World {
        wander,
        time_s,
        drift,
        speed,
        white_nm: if speed < 0.25 { 1.1e-3 } else { 1.4e-3 },
    }
}

pub const FRICTION_NM: f64 = 0.16;

/// The scales of the recordings: 1024 counts a turn, 1280 turns of the motor to one of the input link, 64 to one of the worm.
pub fn geared() -> Drivetrain {
    Drivetrain {
        rad_per_count: core::f32::consts::TAU / 1_310_720.0,
        counts_per_turn: 1024,
        counts_per_worm_turn: 65_536,
        ..drivetrain()
    }
}

/// Friction's mean curve.
pub fn curve(counts: f64) -> f64 {
    let worm = std::f64::consts::TAU * counts / 65_536.0;
    let link = std::f64::consts::TAU * counts / 1_310_720.0;
    let share = 0.045 * (worm + 1.0).cos() + 0.01 * (2.0 * worm).cos() + 0.03 * (link + 2.0).cos();
    FRICTION_NM * (1.0 + share)
}

/// Friction as time goes on.
#[derive(Clone)]
pub struct Life {
    world: World,
    noise: Noise,
    wander: f64,
    now_s: f64,
}

impl Life {
    pub fn new(world: World, seed: u64) -> Self {
        let mut noise = Noise(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5555);
        let wander = f64::from(noise.normal());
        Self {
            world,
            noise,
            wander,
            now_s: 0.0,
        }
    }

    pub fn block_s(&self) -> f64 {
        1024.0 * f64::from(geared().rad_per_count) / self.world.speed
    }

    /// Time passes.
    pub fn wait(&mut self, seconds: f64) {
        let phi = (-seconds / self.world.time_s).exp();
        self.wander = phi * self.wander + (1.0 - phi * phi).sqrt() * f64::from(self.noise.normal());
        self.now_s += seconds;
    }

    /// The next block, of number `index`.
    pub fn block(&mut self, drive: Drive, index: i32, load_nm: f64) -> Block {
        // A block is a mean over its time.
        let mut mean = 0.0;
        for _ in 0..INSTANTS {
            self.wait(self.block_s() / f64::from(INSTANTS));
            mean += self.wander / f64::from(INSTANTS);
        }
        let World {
            wander,
            drift,
            white_nm,
            ..
        } = self.world;
        let counts = 1024 * index + 512;
        let warm = 1.0 - (-self.now_s / 8.0).exp();
        let friction = curve(f64::from(counts))
            + FRICTION_NM * (wander * mean + drift * warm)
            + white_nm * f64::from(self.noise.normal());
        let torque = if drive == Drive::Opening {
            -friction
        } else {
            friction + load_nm
        };
        Block {
            emf_v: f32::NAN,
            time_us: (self.now_s * 1e6) as u64,
            drive,
            counts,
            width_counts: 1024,
            way_counts: i32::MAX,
            duration_s: self.block_s() as f32,
            drive_torque_nm: torque as f32,
            inertia_nm: 0.0,
            overspeed: 0.0,
        }
    }

    /// A pass over the travel, against a record.
    pub fn pass(&mut self, drive: Drive, record: &Friction) -> Pass {
        let mut pass = Pass::new(drive);
        for step in 0..BLOCKS {
            let index = if drive == Drive::Opening {
                FIRST + BLOCKS - 1 - step
            } else {
                FIRST + step
            };
            let block = self.block(drive, index, 0.0);
            let known = match drive {
                Drive::Closing => record.at(block.counts).map_or(0.0, |known| known.torque_nm),
                _ => 0.0,
            };
            pass.push(record, block.counts, &block, known);
        }
        self.wait(0.5);
        pass
    }

    /// A record from one closing and one opening.
    pub fn record(&mut self) -> Friction {
        let mut record = Friction::empty(312_890, &geared());
        for drive in [Drive::Closing, Drive::Opening] {
            let pass = self.pass(drive, &record);
            assess(pass, &mut record);
        }
        record
    }
}

/// Everything that a pass teaches, at once.
pub fn assess(pass: Pass, record: &mut Friction) {
    let mut assessment = Assessment::new(pass, record).expect("long enough");
    while !assessment.step(record) {}
    assessment.update(record);
}
