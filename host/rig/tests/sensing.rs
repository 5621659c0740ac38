//! Sensing against the plant, through a plain speed loop.

mod bench;

use bench::Bench;
use palpate::scene::P70;
use palpate_plant::{FingerKind, Parameters};

#[test]
fn noise() {
    let p = Parameters::default();
    let mut b = Bench::<P70>::new(&p, FingerKind::P70, 1, None);
    b.trace = Some(Vec::new());
    b.record(1);
    println!("{:?}", b.events);
    let trace = b.trace.take().unwrap();
    let mut out = String::new();
    for (s, theta, torque) in &trace { out += &format!("{},{},{},{},{},{:?}\n", s.time_us, s.position_counts, s.current_a, theta, torque, s.drive); }
    std::fs::write("/tmp/trace.csv", out).unwrap();
}
