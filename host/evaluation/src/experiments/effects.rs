//! What real fingers add to the estimator's assumptions, one effect at a time (docs/SENSING.md#real-fingers): in the world `ideal` with
//! nothing but that, with a calibration in it.

use palpate_plant::{ObjectMount, Parameters, Shape};
use palpate_scenes::{P70, P70Grasp, Tendon2};
use palpate_simulation::Simulated;
use rand::RngExt;

use super::catalogue::plain_cylinder;
use super::job::{Entry, Job, Plan, Wanted, job};
use super::judge;
use super::objects::Object;
use super::result::Method;

/// The world to which effects are added.
const WORLD: &str = "ideal";
/// How the names of all rows begin.
pub const BEGINS: &str = "effect: ";
/// Fingers with each effect: errors of the worm have another phase on each.
const FINGERS: u8 = 4;
/// Contacts on each of them.
const CONTACTS: usize = 8;
/// Weight of the heavy finger, 65 g over 0.16 m, kilogram per metre.
pub const HEAVY_KG_PER_M: f64 = 0.406;

type Change = fn(&mut Parameters);

/// Effects on the default finger, whose firmware knows of none of them but what its user sets of the skin and states of the worm.
const EFFECTS: [(&str, Change); 23] = [
    ("effect: none", |_| {}),
    ("effect: cable stiffens by 17 % up to 0.35 N m", |p| {
        p.cable.stiffening_per_nm = 0.49;
    }),
    ("effect: preload of 2 deg", |p| {
        p.mechanism.preload_deg = 2.0
    }),
    ("effect: preload of 5 deg", |p| {
        p.mechanism.preload_deg = 5.0
    }),
    ("effect: contact friction 0.3, scene's 0.1 set", |p| {
        p.contact.friction = 0.3;
    }),
    ("effect: contact friction 0.3, set", |p| rub(p, 0.3)),
    ("effect: contact friction 0.6, set", |p| rub(p, 0.6)),
    ("effect: contact friction 1.0, set", |p| rub(p, 1.0)),
    ("effect: joint friction 1 mN m", |p| {
        p.mechanism.joint_friction_nm = 1e-3;
    }),
    ("effect: joint friction 3 mN m", |p| {
        p.mechanism.joint_friction_nm = 3e-3;
    }),
    ("effect: worm error 0.5 mrad", |p| {
        p.transmission.worm_error_rad = 0.5e-3;
    }),
    ("effect: worm error 1 mrad", |p| {
        p.transmission.worm_error_rad = 1e-3;
    }),
    ("effect: worm error 2 mrad", |p| {
        p.transmission.worm_error_rad = 2e-3;
    }),
    ("effect: worm error 1 mrad, stated", |p| {
        state_worm_error(p, 1e-3)
    }),
    ("effect: worm error 2 mrad, stated", |p| {
        state_worm_error(p, 2e-3)
    }),
    ("effect: 65 g that opens it, not stated", |p| {
        weigh(p, -90.0)
    }),
    ("effect: 65 g along phalanx 1, not stated", |p| {
        weigh(p, 0.0)
    }),
    ("effect: 65 g that closes it, not stated", |p| {
        weigh(p, 90.0)
    }),
    ("effect: friction wanders, 1 % in 3 s", |p| {
        wander(p, 0.01, 3.0)
    }),
    ("effect: friction wanders, 3 % in 1 s", |p| {
        wander(p, 0.03, 1.0)
    }),
    ("effect: coupler 1 mm longer", |p| {
        p.finger.coupler_m[0] += 1e-3
    }),
    ("effect: object of 500 N/m", |p| hold(p, 500.0)),
    ("effect: object of 200 N/m", |p| hold(p, 200.0)),
];

/// Effects on the same finger whose firmware takes objects to be rigid.
const TAKEN_TO_BE_RIGID: [(&str, Change); 2] = [
    ("effect: object of 500 N/m, taken to be rigid", |p| {
        hold(p, 500.0)
    }),
    ("effect: object of 200 N/m, taken to be rigid", |p| {
        hold(p, 200.0)
    }),
];

/// Effects on a finger whose scene states a weight; its user sets `weight` and `mounting`.
const ON_HEAVY: [(&str, Change); 4] = [
    ("effect: none, tendon2", |_| {}),
    ("effect: 65 g that opens it, tendon2", |p| weigh(p, -90.0)),
    ("effect: 65 g along phalanx 1, tendon2", |p| weigh(p, 0.0)),
    ("effect: 65 g that closes it, tendon2", |p| weigh(p, 90.0)),
];

fn rub(parameters: &mut Parameters, coefficient: f64) {
    parameters.contact.friction = coefficient;
    parameters.contact.stated_friction = coefficient;
}

fn state_worm_error(parameters: &mut Parameters, rad: f64) {
    parameters.transmission.worm_error_rad = rad;
    parameters.transmission.stated_worm_error_rad = rad;
}

fn weigh(parameters: &mut Parameters, mounting_deg: f64) {
    parameters.mechanism.linear_density_kg_per_m = HEAVY_KG_PER_M;
    parameters.mechanism.gravity_m_per_s2 = 9.81;
    parameters.mechanism.mounting_deg = mounting_deg;
}

fn wander(parameters: &mut Parameters, share: f64, time_s: f64) {
    parameters.friction.wander_share = share;
    parameters.friction.wander_time_s = time_s;
}

fn hold(parameters: &mut Parameters, n_per_m: f64) {
    parameters.object.mount = ObjectMount::Spring;
    parameters.object.stiffness_n_per_m = n_per_m;
}

/// Distal contacts of one finger with one effect, calibrated, by our method.
fn effect<S: Simulated + 'static>(
    plan: &Plan,
    (name, change): (&'static str, Change),
    object: &Object,
    finger: u8,
) -> Job {
    let parameters = plan.of(S::NAME).map(|mut parameters| {
        change(&mut parameters);
        let phase_deg = 360.0 * f64::from(finger) / f64::from(FINGERS);
        parameters.transmission.worm_error_phase_deg += phase_deg;
        parameters
    });
    let (object, seed) = (object.clone(), plan.seed + 7000 + u64::from(finger));
    let length_m = judge::length_m::<S>(2).unwrap_or(0.05);
    let all = job::<S>(name, parameters, seed, CONTACTS, move |index, random| {
        let share = 0.1 + 0.8 * (index as f64 + 0.5) / CONTACTS as f64;
        Wanted {
            object: object.clone(),
            phalanx: 2,
            k_m: length_m * share,
            theta_1_rad: random.random_range(0.35..1.0),
            any_first: true,
        }
    });
    let run = move |found: &mut Vec<Entry>| {
        let mut entries = Vec::new();
        let ended = (all.run)(&mut entries);
        entries.retain(|entry| entry.calibrated && entry.method == Method::Ours);
        found.append(&mut entries);
        ended
    };
    Job {
        name: name.to_owned(),
        closings: CONTACTS,
        run: Box::new(run),
    }
}

/// (h) every effect alone; none in other worlds, which have several.
#[must_use]
pub fn effects(plan: &Plan) -> Vec<Job> {
    if plan.place.world != WORLD {
        return Vec::new();
    }
    let small = plain_cylinder();
    let large = Object {
        name: "cylinder 120 mm",
        shape: Shape::Cylinder { diameter_m: 0.120 },
        flush_m: 0.0,
    };
    let of_large: (&str, Change) = ("effect: cylinder of 120 mm", |_| {});
    let of_large_rigid: (&str, Change) = ("effect: cylinder of 120 mm, taken to be rigid", |_| {});
    (0..FINGERS)
        .flat_map(|finger| {
            let on_default =
                EFFECTS.map(|effect| self::effect::<P70>(plan, effect, &small, finger));
            let on_rigid = TAKEN_TO_BE_RIGID
                .map(|effect| self::effect::<P70Grasp>(plan, effect, &small, finger));
            let on_heavy =
                ON_HEAVY.map(|effect| self::effect::<Tendon2>(plan, effect, &small, finger));
            let on_large = [
                effect::<P70>(plan, of_large, &large, finger),
                effect::<P70Grasp>(plan, of_large_rigid, &large, finger),
            ];
            (on_default.into_iter().chain(on_rigid))
                .chain(on_heavy)
                .chain(on_large)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_is_told_by_its_name_and_changes_something() {
        let base = Parameters::of("p70").expect("a scene");
        let mut names = Vec::new();
        let rigid = TAKEN_TO_BE_RIGID;
        for (name, change) in EFFECTS.into_iter().chain(rigid).chain(ON_HEAVY) {
            assert!(name.starts_with(BEGINS) && !names.contains(&name), "{name}");
            names.push(name);
            let mut changed = base.clone();
            change(&mut changed);
            let is_none = name.starts_with("effect: none");
            assert_eq!(changed == base, is_none, "{name}");
        }
    }
}
