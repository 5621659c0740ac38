//! Sensing against the plant, through a plain speed loop.

mod bench;

use bench::Bench;
use palpate::scene::P70;
use palpate::sensing::{Directive, Event};
use palpate_plant::{FingerKind, Grasp, Parameters, Shape};

fn env(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

struct Lcg(u64);
impl Lcg {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as f64) / f64::from(1u32 << 31)
    }
    fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }
}

#[test]
fn survey() {
    let plants = env("PLANTS", 3.0) as u64;
    let contacts = env("CONTACTS", 10.0) as u64;
    let randomised = env("RANDOM", 1.0) > 0.0;
    let verbose = env("VERBOSE", 0.0) > 0.0;
    let calibrate = env("CAL", 2.0) as u32;
    let mut errors: Vec<(f64, f64, f64)> = Vec::new();
    let mut other = std::collections::BTreeMap::<String, u32>::new();
    let mut delays = Vec::new();
    for seed in 0..plants {
        let p = if randomised { Parameters::default().randomised(seed + 1000) } else { Parameters::default() };
        let mut b = Bench::<P70>::new(&p, FingerKind::P70, seed, None);
        b.record(1);
        if calibrate > 0 {
            b.close(Directive::CalibrateCable, &Grasp::Free);
            let kt = p.cable_stiffness_nm_per_rad();
            let c = b.sensor.calibration();
            println!("plant {seed} {:?}", b.events.iter().map(|e| e.1).filter(|e| matches!(e, Event::CalibrationRefused { .. })).collect::<Vec<_>>());
            println!("  cable 1/Kt {:.4}  est {:.4} +- {:.4}", 1.0 / kt, c.cable_rad_per_nm, c.cable_sigma_rad_per_nm);
            b.back();
        }
        if calibrate > 1 {
            for k in [20e-3, 55e-3] {
                b.close(Directive::Calibrate { phalanx: 2, k_m: k as f32 }, &Grasp::touching(2, k, 0.8, Shape::Cylinder { diameter_m: 0.004 }));
                for e in b.events.iter().filter(|e| matches!(e.1, Event::CalibrationRefused { .. })) { println!("  {e:?}"); }
                let c = b.sensor.calibration();
                println!("  k {k} f {:.4} +- {:.4} cable {:.4} +- {:.4} corr {:.2}", c.torque_factor, c.torque_factor_sigma, c.cable_rad_per_nm, c.cable_sigma_rad_per_nm, c.correlation);
                b.back();
            }
        }
        let mut random = Lcg(seed * 77 + 5);
        for _ in 0..3 { random.next(); }
        for _ in 0..contacts {
            let k = random.range(0.004, 0.069);
            let theta = random.range(0.3, 1.2);
            let d = random.range(0.002, 0.040);
            b.close(Directive::Watch, &Grasp::touching(2, k, theta, Shape::Cylinder { diameter_m: d }));
            let first = b.plant.truth().first_contact;
            let Some(first) = first else { *other.entry("no contact".into()).or_default() += 1; b.back(); continue };
            let touch = b.events.iter().find(|e| matches!(e.1, Event::Touch { .. }));
            match touch {
                Some((t, _)) => delays.push(*t as f64 * 1e-3 - first.time_s * 1e3),
                None => *other.entry("missed".into()).or_default() += 1,
            }
            if first.contact.phalanx != 2 { *other.entry(format!("first on {}", first.contact.phalanx)).or_default() += 1; b.back(); continue; }
            match b.events.last() {
                Some((t, Event::Located { phalanx: 2, k_m, sigma_m, radius_m, settled, .. })) => {
                    let e = (f64::from(*k_m) - first.contact.k_m) * 1e3;
                    let s = f64::from(*sigma_m) * 1e3;
                    if verbose { println!("   k {:5.1} d {:4.1} th {theta:.2} err {e:6.2} sigma {s:5.2} R {:5.1} settled {settled} after {:.2}s T {:.3}", first.contact.k_m * 1e3, d * 1e3, radius_m * 1e3, *t as f64 * 1e-6 - first.time_s, b.plant.truth().torque_nm); }
                    errors.push((first.contact.k_m * 1e3, e, s));
                }
                Some((_, e)) => {
                    let text = format!("{e:?}");
                    if verbose { println!("   k {:5.1} d {:4.1} th {theta:.2} {text}", first.contact.k_m * 1e3, d * 1e3); }
                    *other.entry(text.split('_').next().unwrap_or_default().to_string()).or_default() += 1;
                }
                None => {}
            }
            b.back();
        }
    }
    let show = |name: &str, set: &[&(f64, f64, f64)]| {
        if set.is_empty() { return; }
        let n = set.len() as f64;
        let mean = set.iter().map(|e| e.1.abs()).sum::<f64>() / n;
        let sd = (set.iter().map(|e| (e.1.abs() - mean).powi(2)).sum::<f64>() / n).sqrt();
        let bias = set.iter().map(|e| e.1).sum::<f64>() / n;
        let within = set.iter().filter(|e| e.1.abs() <= 2.0 * e.2).count() as f64 / n * 100.0;
        let worst = set.iter().map(|e| e.1.abs()).fold(0.0, f64::max);
        let sigma = set.iter().map(|e| e.2).sum::<f64>() / n;
        println!("{name:8} n {n:4} mean {:.2} % sd {:.2} % bias {bias:.2} mm worst {worst:.2} mm mean sigma {sigma:.2} mm within2s {within:.0} %", mean / 0.7, sd / 0.7);
    };
    for lo in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0] {
        show(&format!("{lo}-"), &errors.iter().filter(|e| e.0 >= lo && e.0 < lo + 10.0).collect::<Vec<_>>());
    }
    show("all", &errors.iter().collect::<Vec<_>>());
    println!("{other:?}");
    delays.sort_by(f64::total_cmp);
    if !delays.is_empty() { println!("delay min {:.0} median {:.0} p95 {:.0} max {:.0} ms", delays[0], delays[delays.len() / 2], delays[delays.len() * 95 / 100], delays[delays.len() - 1]); }
}
