//! The motor's temperatures in RAM that survives a reset, so that a reset does not take the winding's protection away.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use palpate::drive::config::Config;
use palpate::drive::thermal::Temperatures;

use super::reset::Reset;

/// Winding, housing, and a check of both.
#[unsafe(link_section = ".uninit.temperatures")]
static STORED: MaybeUninit<[AtomicU32; 3]> = MaybeUninit::uninit();

/// Distinguishes what this program wrote from what RAM holds after power-up.
const MARK: u32 = 0x7E3A_C0DE;

fn stored() -> &'static [AtomicU32; 3] {
    // SAFETY: any bits are a value of this type.
    unsafe { STORED.assume_init_ref() }
}

fn check(winding: u32, housing: u32) -> u32 {
    winding.rotate_left(7) ^ housing.wrapping_mul(0x9E37_79B1) ^ MARK
}

/// Keeps the temperatures for the time after a reset. A reset between the stores leaves a check that does not fit.
pub fn keep(temperatures: Temperatures) {
    let [winding, housing, sum] = stored();
    let bits = [temperatures.winding_c, temperatures.housing_c].map(f32::to_bits);
    winding.store(bits[0], Ordering::Relaxed);
    housing.store(bits[1], Ordering::Relaxed);
    sum.store(check(bits[0], bits[1]), Ordering::Relaxed);
}

/// The temperatures to start with: those of before the reset; after a power cut nobody knows how long it lasted, and where
/// nothing was kept neither: then warm ones, until the model has seen them cool down.
pub fn initial(reset: Reset, config: &Config) -> Temperatures {
    let [winding, housing, sum] = stored();
    let bits = [winding, housing].map(|word| word.load(Ordering::Relaxed));
    let kept = Temperatures {
        winding_c: f32::from_bits(bits[0]),
        housing_c: f32::from_bits(bits[1]),
    };
    let is_kept = sum.load(Ordering::Relaxed) == check(bits[0], bits[1]) && kept.is_plausible();
    let warm = Temperatures::after_continuous(&config.motor, config.limits.current_a);
    match (is_kept, reset) {
        (true, Reset::Power) => kept.warmest(warm),
        (true, _) => kept,
        (false, _) => warm,
    }
}
