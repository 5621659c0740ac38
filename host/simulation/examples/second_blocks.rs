//! Blocks of closings on which a second contact is looked for, next to the truth, as a table.
//! `second_blocks SCENE WORLD [FINGERS] [FIRST SEED]`: lines `grasp`, `event` and `block`, for whoever wants to know why one was
//! not told. With WHOLE in the environment nothing is told, and every closing goes on to its end.

use std::cell::RefCell;
use std::fmt::Debug;

use palpate::finger::HoldsTwice;
use palpate::joint_sensor::JointSensor;
use palpate::scene::Scene;
use palpate::sensing::block::{BlockAverager, BlockUpdate};
use palpate::sensing::{
    AfterContact, Directive, Drive, Event, Follow, Followed, Sample, Sensor, SeriesElement,
};
use palpate_plant::World;
use palpate_simulation::second_contacts::{self, With};
use palpate_simulation::{Error, Simulated};

/// Motor position, measured angle, torque above the record, of the free finger, deviation, calibration, time.
type Row = (i32, [f64; 9], bool);

thread_local! {
    static BLOCKS: RefCell<Vec<Row>> = const { RefCell::new(Vec::new()) };
}

#[derive(Clone, Debug)]
struct Recorder<A> {
    inner: A,
    averager: BlockAverager,
    touched: bool,
    over: bool,
}

impl<A: Default> Default for Recorder<A> {
    fn default() -> Self {
        Self {
            inner: A::default(),
            averager: BlockAverager::default(),
            touched: false,
            over: false,
        }
    }
}

impl<F: HoldsTwice + Clone + Debug> AfterContact<F> for Recorder<Follow<F>> {
    const FOLLOWS: bool = true;

    fn direct(&mut self, directive: Directive) {
        self.inner.direct(directive);
        if directive != Directive::Rest {
            (self.touched, self.over) = (false, false);
        }
    }

    fn sample<H: JointSensor, X: SeriesElement>(
        &mut self,
        sensor: &mut Sensor<F, H, X>,
        sample: &Sample<H::Reading>,
        told: Option<&Event>,
    ) -> Option<Followed> {
        let whole = std::env::var_os("WHOLE").is_some();
        self.touched |= matches!(told, Some(Event::Touch { .. }));
        let step = (self.averager).push(sample, sensor.drivetrain(), sensor.settings());
        if let BlockUpdate::Block(block) = step
            && block.drive == Drive::Closing
            && let Some(residual) = sensor.residual(&block)
        {
            let angle = sensor.drivetrain().closing_rad(block.counts);
            let free = sensor.free_at(angle).map_or(0.0, |free| free.torque_nm);
            let calibration = sensor.calibration();
            let efficiency = sensor.drivetrain().efficiency;
            let row = [
                angle,
                efficiency * residual.torque_nm,
                free,
                efficiency * residual.variance_nm2.sqrt(),
                calibration.torque_factor,
                calibration.cable_rad_per_nm,
                calibration.cable_sigma_rad_per_nm,
                calibration.torque_factor_sigma,
                block.time_us as f32 * 1e-6,
            ];
            let way = sensor.drivetrain().rotation_rad(0, block.counts);
            let ends = row[1] >= sensor.settings().enough_nm()
                || way >= sensor.settings().travel_rad
                || sensor.is_at_stop(angle, row[1]);
            BLOCKS.with_borrow_mut(|blocks| {
                blocks.push((block.counts, row.map(f64::from), ends));
            });
            if whole && self.touched && ends && !self.over {
                self.over = true;
                sensor.conclude();
                return Some(Followed::Grasp {
                    grip: palpate::sensing::Grip::Single,
                    torque_nm: row[1],
                    forces: palpate::finger::HeldForces::UNKNOWN,
                });
            }
        }
        if whole {
            return None;
        }
        self.inner.sample(sensor, sample, told)
    }
}

type Recorded<S> = With<S, Recorder<Follow<<S as Scene>::Finger>>>;

fn run<S: Simulated<Finger: HoldsTwice>>(
    world: &str,
    fingers: u64,
    first: u64,
) -> Result<(), Error> {
    let world = World::named(world).expect("a world");
    for seed in first..first + fingers {
        let mut index = 0;
        second_contacts::finger_of::<Recorded<S>>(
            &world,
            seed,
            20,
            true,
            |outcome, second, turns| {
                let first = outcome.first_contact.expect("a contact");
                let c = first.contact;
                println!(
                    "grasp {seed} {index} {} {:.5} {:.5} {:.5}  {turns:.2} {}",
                    c.phalanx,
                    c.k_m,
                    first.theta_a_rad,
                    first.torque_nm,
                    outcome
                        .truth
                        .contacts
                        .iter()
                        .map(|c| format!("{}:{:.5}:{:.3}", c.phalanx, c.k_m, c.force_n))
                        .collect::<Vec<_>>()
                        .join(",")
                );
                if let Some(second) = second {
                    println!("second {} {:.5}", second.phalanx, second.k_m);
                }
                if let Some(fault) = outcome.fault {
                    println!("event fault {fault:?}");
                }
                for (time, event) in &outcome.events {
                    println!("event {time} {event:?}");
                }
                for (time, event) in &outcome.followed {
                    println!("event {time} {event:?}");
                }
                let blocks = BLOCKS.with_borrow_mut(std::mem::take);
                for (counts, row, ends) in blocks {
                    let Some(at) = outcome
                        .trace
                        .iter()
                        .find(|r| f64::abs(r.time_s - row[8]) < 6e-4)
                    else {
                        continue;
                    };
                    print!("block {counts}");
                    for value in row {
                        print!(" {value:.6}");
                    }
                    println!(
                        " {:.5} {:.5} {} {:.4} {:.4} {:.4} {} {:.5} {:.3} {}",
                        at.true_theta_a_rad,
                        at.true_torque_nm,
                        at.true_pressing,
                        at.true_joint_rad[0],
                        at.true_joint_rad[1],
                        at.true_joint_rad[2],
                        at.true_phalanx,
                        at.true_k_m,
                        at.true_force_n,
                        u8::from(ends)
                    );
                }
                index += 1;
            },
        )?;
    }
    Ok(())
}

fn main() {
    let options: Vec<String> = std::env::args().skip(1).collect();
    let [scene, world, rest @ ..] = options.as_slice() else {
        eprintln!("second_blocks SCENE WORLD [FINGERS] [FIRST SEED]");
        return;
    };
    let number = |index: usize, default: u64| {
        rest.get(index)
            .and_then(|n| n.parse().ok())
            .unwrap_or(default)
    };
    let (fingers, first) = (number(0, 10), number(1, 5001));
    let result = match scene.as_str() {
        "p70" => run::<palpate_scenes::P70>(world, fingers, first),
        "linkage3" => run::<palpate_scenes::Linkage3>(world, fingers, first),
        _ => run::<palpate_scenes::Tendon3>(world, fingers, first),
    };
    if let Err(error) = result {
        eprintln!("{error}");
    }
}
