//! Draft.
fn main() {
    let path = std::env::args().nth(1).expect("elf");
    let firmware = palpate_emulator::Firmware::load(path.as_ref()).unwrap();
    let setup = palpate_emulator::Setup { watch: std::env::args().skip(2).collect(), ..Default::default() };
    let mut machine = palpate_emulator::Machine::new(&firmware, None, &setup).unwrap();
    let start = std::time::Instant::now();
    for ms in 1..=3000u64 {
        match machine.run_until(ms * palpate_emulator::time::TICKS_PER_MS) {
            Ok(palpate_emulator::Pause::Time) => {}
            Ok(other) => println!("{other:?}"),
            Err(e) => { println!("{e}"); break; }
        }
        for line in machine.take_lines() { println!("{line}"); }
    }
    println!("{} s in {:?} {:?} {:#?} {:?} stack {:?}", machine.time_s(), start.elapsed(), machine.account().total(), machine.account().exceptions(), machine.account().functions(), machine.stack_used());
}
