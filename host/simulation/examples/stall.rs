//! Scratch.
use palpate::drive::sequence::Request;
use palpate::sensing::Directive;
use palpate_plant::{Grasp, Parameters, Shape, World};
use palpate_simulation::{Outcome, Simulated, Simulation};
fn show(what: &str, o: &Outcome, csv: bool) {
    println!(
        "  {what}: fault {:?} last {:?} t={:.2} contacts {:?}",
        o.fault,
        o.events.last(),
        o.truth.time_s,
        o.truth.contacts
    );
    for e in &o.events {
        let t = format!("{e:?}");
        if t.contains("Stale") || t.contains("NotRec") {
            println!("    stale {t} at {}", e.0);
        }
    }
    let peak = o
        .trace
        .iter()
        .filter(|r| r.duty > 0.2)
        .map(|r| r.current_a)
        .fold(0.0f32, f32::max);
    let low = o.trace.iter().map(|r| r.current_a).fold(0.0f32, f32::min);
    println!("    peak {:.1} mA, least {:.1} mA", 1e3 * peak, 1e3 * low);
    if csv && o.fault.is_some() {
        println!("t,count,i,duty,theta_a,q1,q2,q3,torque");
        let n = o.trace.len();
        for (k, r) in o.trace.iter().enumerate() {
            if k % 100 == 0 || (k + 1500 > n && k % 20 == 0) {
                println!("{}", r.csv());
            }
        }
        println!("{:?}", o.truth);
    }
}
fn go<S: Simulated>(world: &World, seed: u64, nominal: bool, full: bool, csv: bool) {
    let base = world.of(S::NAME).expect("p");
    let p: Parameters = if seed > 0 && !nominal {
        base.randomised(seed)
    } else {
        base
    };
    let mut s = match Simulation::<S>::new(&p, seed) {
        Ok(s) => s,
        Err(e) => {
            println!("{} seed {seed}: {e}", S::NAME);
            return;
        }
    };
    s.traced = true;
    println!(
        "{} seed {seed} mounting {:.0} {:?} worm {:?} motor {:?} gear {:?} spring {:?}",
        S::NAME,
        p.mechanism.mounting_deg,
        p.mechanism,
        p.worm,
        p.motor,
        p.gearhead,
        p.finger.spring_nm_per_rad
    );
    let o = s.prepare().expect("prep");
    show("prepare", &o, csv);
    if o.fault.is_some() || !full {
        return;
    }
    let o = s.press().expect("press");
    show("press", &o, csv);
    if o.fault.is_some() {
        return;
    }
    let l = p.finger.length_m[p.finger.length_m.len() - 1];
    for share in [0.3, 0.75] {
        let pin = Shape::Cylinder { diameter_m: 6e-3 };
        let n = p.finger.length_m.len() as u8;
        let k = (share * l) as f32;
        let grasp = Grasp::touching(n, k.into(), 0.6, pin);
        if let Err(e) = s.plant().place(&grasp) {
            println!("{e}");
            return;
        }
        let o = s
            .motion(Request::Close, Directive::Calibrate { phalanx: n, k_m: k })
            .expect("motion");
        show("pin", &o, csv);
        if o.fault.is_some() {
            return;
        }
        let o = s.open().expect("open");
        show("open", &o, csv);
        if o.fault.is_some() {
            return;
        }
    }
    let n = p.finger.length_m.len();
    for i in 0..8 {
        let ph = 2 + i % (n - 1);
        for d in [0.006, 0.02] {
            let k = p.finger.length_m[ph - 1] * [0.2, 0.45, 0.7, 0.85][i / 2];
            let mut c = s.clone();
            let grasp = Grasp::touching(ph as u8, k, 0.8, Shape::Cylinder { diameter_m: d });
            match c.close(&grasp) {
                Ok(o) => {
                    println!(
                        "ph {ph} k {k} d {d}: {:?}",
                        o.first_contact.map(|f| f.contact)
                    );
                    show("grasp", &o, csv)
                }
                Err(e) => println!("{e}"),
            }
        }
    }
}
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let world = World::named(&a[0]).expect("world");
    let scene = a[1].clone();
    for seed in a[2].split(',') {
        let (nominal, seed) = match seed.strip_prefix('n') {
            Some(s) => (true, s),
            None => (false, seed),
        };
        let seed: u64 = seed.parse().unwrap();
        palpate_scenes::for_scene!(scene.as_str(), |S| go::<S>(
            &world,
            seed,
            nominal,
            a.len() > 3,
            a.len() > 4
        ))
        .unwrap_or(());
    }
}
