//! The fuzz targets on their seeds, without a fuzzer: what must hold is asserted in the targets.

#[allow(missing_docs)]
#[path = "../../fuzz/src/lib.rs"]
mod fuzz;

/// Runs a target on each of its seeds, whole and cut short at every length; says how many seeds there are.
fn replay(target: &str, run: fn(&[u8])) -> usize {
    let folder = format!("{}/fuzz/seeds/{target}", env!("CARGO_MANIFEST_DIR"));
    let seeds = std::fs::read_dir(&folder).expect("a folder of seeds");
    let mut count = 0;
    for seed in seeds {
        let path = seed.expect("a readable folder").path();
        let bytes = std::fs::read(&path).expect("a readable seed");
        println!("{}", path.display());
        for end in 0..=bytes.len().min(100) {
            run(&bytes[..end]);
        }
        run(&bytes);
        count += 1;
    }
    count
}

#[test]
fn the_inverse_holds_on_its_seeds() {
    assert!(replay("inverse", fuzz::inverse) >= 10);
}

#[test]
fn the_contact_path_holds_on_its_seeds() {
    assert!(replay("step", fuzz::step) >= 9);
}
