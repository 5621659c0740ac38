//! On the chip: runs every candidate over the same inputs and prints what each call costs, by the core's cycle counter. With the
//! feature `target-tests` it is another program, which tests the chip: see `target.rs`.
//!
//! On a board these are cycles. The emulated core counts them as instructions, exactly; `cargo xtask report` says which.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("this program times the chip: `cargo xtask report` runs it on the emulated one");
    std::process::ExitCode::FAILURE
}

#[cfg(target_os = "none")]
#[path = "../../src/board/clock.rs"]
#[cfg_attr(
    not(feature = "target-tests"),
    allow(dead_code, reason = "the firmware's; the measurements use a part")
)]
mod clock;

#[cfg(all(target_os = "none", feature = "target-tests"))]
#[path = "../../src/board/bridge.rs"]
#[allow(dead_code, reason = "the firmware's; the tests use a part")]
mod bridge;

#[cfg(all(target_os = "none", feature = "target-tests"))]
#[path = "../../src/board/reset.rs"]
#[allow(dead_code, reason = "the firmware's; the tests use a part")]
mod reset;

#[cfg(all(target_os = "none", feature = "target-tests"))]
#[path = "../../src/board/ccm.rs"]
mod ccm;

#[cfg(all(target_os = "none", feature = "target-tests"))]
mod target;

#[cfg(all(target_os = "none", not(feature = "target-tests")))]
mod chip {
    use core::hint::black_box;

    use cortex_m::peripheral::DWT;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, exit};
    use defmt::info;
    use defmt_rtt as _;
    use palpate_bench::task::{self, Bits, Task, Visitor};

    struct Stopwatch;

    /// Counter difference around one call. Both reads and the call itself are in it: see `overhead`.
    #[inline(never)]
    fn time<I, O>(run: fn(&I) -> O, input: &I) -> (u32, O) {
        let run = black_box(run);
        let input = black_box(input);
        cortex_m::interrupt::free(|_| {
            let before = DWT::cycle_count();
            let output = black_box(run(input));
            (DWT::cycle_count().wrapping_sub(before), output)
        })
    }

    impl Visitor for Stopwatch {
        fn task<I, O: Bits>(&mut self, task: &Task<'_, I, O>) {
            // What remains of a call when the function does nothing: the least of several, the first has cold caches.
            let overhead = task
                .timed
                .iter()
                .take(8)
                .map(|input| time(task.nothing, input).0)
                .min()
                .unwrap_or(0);
            for candidate in task.candidates {
                let (mut total, mut max, mut checksum) = (0_u64, 0, 0);
                for input in task.timed {
                    let (counts, output) = time(candidate.run, input);
                    let counts = counts.saturating_sub(overhead);
                    total += u64::from(counts);
                    max = counts.max(max);
                    checksum = output.mix(checksum);
                }
                info!(
                    "bench task={=str} name={=str} calls={=usize} total={=u64} max={=u32} overhead={=u32} checksum={=u32} address={=usize} nothing={=usize}",
                    task.name,
                    candidate.name,
                    task.timed.len(),
                    total,
                    max,
                    overhead,
                    checksum,
                    candidate.run as usize,
                    task.nothing as usize
                );
            }
        }
    }

    #[entry]
    fn main() -> ! {
        let _chip = super::clock::start();
        if let Some(mut peripherals) = cortex_m::Peripherals::take() {
            peripherals.DCB.enable_trace();
            peripherals.DWT.enable_cycle_counter();
        }
        palpate_bench::function::cordic::start();
        task::visit(&mut Stopwatch);
        info!("bench done");
        leave(true)
    }

    /// Ends the run under a debug probe or in the emulator.
    fn leave(good: bool) -> ! {
        exit(if good { EXIT_SUCCESS } else { EXIT_FAILURE });
        loop {
            cortex_m::asm::wfi();
            // The errata ask for it: src/board/mod.rs.
            cortex_m::asm::isb();
        }
    }

    /// A candidate that panics ends the run; the report says which results are missing.
    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        defmt::error!(
            "bench panicked line={=u32}",
            info.location().map_or(0, |at| at.line())
        );
        leave(false)
    }
}
