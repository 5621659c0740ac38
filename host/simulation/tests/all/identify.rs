//! `identify` on random motors: every quantity within its stated deviation.

use palpate::drive::demand::{Demand, Setpoint, Status};
use palpate::drive::identify::{Identification, Identified, NotIdentified, Quantity, Step};
use palpate::scene::{SampleOf, Scene};
use palpate_plant::{Grasp, Parameters, Plant, World};
use palpate_scenes::P70;
use palpate_simulation::{Board, Machine, SlowLoop};

/// Random worlds.
const PLANTS: u64 = 100;

/// The command alone: no sequence, no sensing.
struct Command {
    identification: Option<Identification>,
    ended: Option<Result<Identified, NotIdentified>>,
    /// Largest ways from the start closing and opening, counts.
    moved: i32,
    opened: i32,
    start: Option<i32>,
}

impl SlowLoop for Command {
    type Joint = <P70 as Scene>::Joint;

    fn sample(&mut self, _: &SampleOf<P70>, status: &Status) -> Demand {
        let start = *self.start.get_or_insert(status.position_counts);
        self.moved = self.moved.max(status.position_counts - start);
        self.opened = self.opened.max(start - status.position_counts);
        let closing = P70::MOTION.closing_rad_per_s;
        let identification = self
            .identification
            .get_or_insert_with(|| Identification::new(&P70::CHECKED, closing, status));
        let setpoint = match (&self.ended, status.fault) {
            (None, None) => match identification.advance(status) {
                Ok(Step::Ask(setpoint)) => setpoint,
                Ok(Step::Done(identified)) => {
                    self.ended = Some(Ok(identified));
                    Setpoint::Off
                }
                Err(why) => {
                    self.ended = Some(Err(why));
                    Setpoint::Off
                }
            },
            _ => Setpoint::Off,
        };
        setpoint.into()
    }
}

fn run(parameters: &Parameters, seed: u64, prepare: impl FnOnce(&mut Plant)) -> Machine<Command> {
    let mut plant = Plant::new(parameters, &Grasp::Free, seed).expect("a plant");
    prepare(&mut plant);
    let slow = Command {
        identification: None,
        ended: None,
        moved: 0,
        opened: 0,
        start: None,
    };
    let joint = P70::joint_sensor().expect("no sensor");
    let mut machine = Machine::new(Board::new(plant), &P70::DRIVE, joint, slow).expect("a drive");
    for _ in 0..21_000 {
        machine.until_sample();
        if machine.slow.ended.is_some() || machine.controller.status().fault.is_some() {
            break;
        }
    }
    // With the bridge off whatever still turns would go on.
    for _ in 0..500 {
        machine.until_sample();
    }
    machine
}

/// What the world has: the quantities in their order.
fn truth(p: &Parameters) -> [f64; 5] {
    let speed = f64::from(P70::MOTION.closing_rad_per_s * P70::DRIVE.drivetrain.reduction);
    let friction = p.motor.coulomb_nm + p.gearhead.drag_nm + p.motor.viscous_nm_s_per_rad * speed;
    [
        p.motor.resistance_ohm + p.choke.resistance_ohm,
        p.motor.torque_constant_nm_per_a,
        p.motor.rotor_inertia_kg_m2,
        friction,
        p.bridge.dead_time_s,
    ]
}

#[test]
fn random_motors_are_identified_within_the_stated_deviations() {
    let world = World::named("workshop").expect("a named world");
    let nominal = world.of(P70::NAME).expect("valid");
    let mut z = vec![Vec::new(); 5];
    for seed in 0..PLANTS {
        let parameters = nominal.randomised(seed);
        let machine = run(&parameters, seed, |_| {});
        let fault = machine.controller.status().fault;
        let Some(Ok(identified)) = machine.slow.ended else {
            panic!("{seed}: {:?} {fault:?}", machine.slow.ended);
        };
        // A turn of the worm, and what the last pulse and its coasting add; never back beyond the start.
        assert!(
            (68_000..120_000).contains(&machine.slow.moved),
            "{}",
            machine.slow.moved
        );
        assert!(machine.slow.opened <= 0, "{seed}: {}", machine.slow.opened);
        let truth = truth(&parameters);
        for (i, quantity) in Quantity::ALL.into_iter().enumerate() {
            let estimate = identified.of(quantity);
            let (value, sigma) = (f64::from(estimate.value), f64::from(estimate.sigma));
            z[i].push((value - truth[i]) / sigma);
            println!(
                "plant={seed} quantity={quantity:?} value={value:.4e} sigma={sigma:.1e} truth={:.4e} z={:.2}",
                truth[i],
                (value - truth[i]) / sigma
            );
        }
    }
    for (quantity, z) in Quantity::ALL.iter().zip(&z) {
        let n = z.len() as f64;
        let mean2 = z.iter().map(|z| z * z).sum::<f64>() / n;
        let mean = z.iter().sum::<f64>() / n;
        let within = z.iter().filter(|z| z.abs() <= 2.0).count();
        println!(
            "quantity={quantity:?} plants={n} mean_z={mean:.2} mean_z2={mean2:.2} within_two={within}"
        );
        // The mean of 100 squares of unit variance scatters by 14 %.
        assert!(mean2 < 1.3, "{quantity:?}: mean z^2 {mean2}");
        assert!(within as f64 >= 0.95 * n, "{quantity:?}: {within} of {n}");
    }
}

/// Homing leaves a finger 0.03 rad from its opening stop; here it stands on it. Friction is down to a third of the least that a
/// random motor has, so that a pulse and its coasting are as long as the way back.
#[test]
fn a_finger_beside_its_stop_is_never_driven_into_it() {
    let world = World::named("workshop").expect("a named world");
    let nominal = world.of(P70::NAME).expect("valid");
    let mut longest_rad = 0.0f64;
    for seed in 0..60 {
        let mut parameters = nominal.randomised(seed);
        let share = 1.0 / (1.0 + f64::from(u32::try_from(seed % 4).expect("small")));
        parameters.mechanism.start_above_stop_rad = 0.0;
        parameters.motor.coulomb_nm *= share;
        parameters.gearhead.drag_nm *= share;
        let machine = run(&parameters, seed, |_| {});
        let truth = machine.board.plant.truth();
        let left_rad = truth.theta_a_rad - truth.opening_stop_rad;
        let slow = &machine.slow;
        println!(
            "plant={seed} friction_share={share:.2} closed={} opened={} left_rad={:.3} identified={:?}",
            slow.moved,
            slow.opened,
            left_rad,
            slow.ended.as_ref().map(Result::is_ok)
        );
        assert!(slow.opened <= 0, "{seed}: {} counts", slow.opened);
        assert!(machine.controller.status().fault.is_none(), "{seed}");
        assert!(slow.moved > 0, "{seed}: it did not move");
        longest_rad = longest_rad.max(left_rad);
    }
    // What is left is room for another pulse, which would have led into the stop.
    assert!(longest_rad > 0.1, "{longest_rad}");
}

/// The drag without load lies before the gaps: their width changes what the motor feels by no more than where along the worm's
/// uneven turn it is felt.
#[test]
fn backlash_is_not_seen_from_the_motor_of_a_free_finger() {
    let world = World::named("workshop").expect("a named world");
    let nominal = world.of(P70::NAME).expect("valid");
    let identified = |width: f64| {
        let mut parameters = nominal.clone();
        parameters.gearhead.backlash_counts *= width;
        parameters.worm.backlash_counts *= width;
        let machine = run(&parameters, 1, |_| {});
        machine.slow.ended.expect("ended").expect("identified")
    };
    let reference = identified(1.0);
    for width in [0.0, 0.5, 2.0, 4.0] {
        let other = identified(width);
        for quantity in Quantity::ALL {
            let (one, other) = (reference.of(quantity), other.of(quantity));
            let apart = (other.value - one.value) / one.sigma;
            println!("width={width} quantity={quantity:?} apart={apart:.3}");
            assert!(apart.abs() < 0.5, "{width} {quantity:?}: {apart}");
        }
    }
}

#[test]
fn a_blocked_motor_ends_it_at_once() {
    let parameters = World::default().of(P70::NAME).expect("valid");
    let machine = run(&parameters, 1, |plant| plant.faults.rotor_locked = true);
    assert_eq!(machine.slow.ended, Some(Err(NotIdentified::Blocked)));
    assert!(machine.controller.status().time_us < 1_000_000);
}
