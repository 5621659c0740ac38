//! On the chip: runs every candidate over the same inputs and prints what each call costs, by the core's cycle counter.
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
mod chip {
    use core::hint::black_box;
    use cortex_m::peripheral::DWT;
    use cortex_m_rt::entry;
    use defmt as _;
    use embassy_stm32 as _;
    use palpate_bench::task::{self, Bits, Task, Visitor};
    use rtt_target::{ChannelMode, rprintln, rtt_init, set_print_channel};

    struct Stopwatch;

    /// Counter difference around one call. Both reads and the call itself are in it: see `overhead`.
    #[inline(never)]
    fn time<I, O>(run: fn(&I) -> O, input: &I) -> (u32, O) {
        let run = black_box(run);
        let input = black_box(input);
        let before = DWT::cycle_count();
        let output = black_box(run(input));
        (DWT::cycle_count().wrapping_sub(before), output)
    }

    impl Visitor for Stopwatch {
        fn task<I, O: Bits>(&mut self, task: &Task<I, O>) {
            // What remains of a call when the function does nothing: the least of several, the first has cold caches.
            let overhead = task
                .timed
                .iter()
                .take(8)
                .map(|input| time(task.nothing, input).0)
                .min()
                .unwrap_or(0);
            for candidate in task.candidates {
                let (mut sum, mut max, mut checksum) = (0_u64, 0, 0);
                for input in task.timed {
                    let (counts, output) = time(candidate.run, input);
                    let counts = counts.saturating_sub(overhead);
                    sum += u64::from(counts);
                    max = counts.max(max);
                    checksum = output.mix(checksum);
                }
                let calls = task.timed.len().max(1) as u64;
                rprintln!(
                    "bench task={} name={} calls={} total={} max={} overhead={} checksum={:08x} address={:08x}",
                    task.name,
                    candidate.name,
                    calls,
                    sum,
                    max,
                    overhead,
                    checksum,
                    candidate.run as usize
                );
            }
        }
    }

    #[entry]
    fn main() -> ! {
        let channels = rtt_init! {
            up: { 0: { size: 1024, mode: ChannelMode::BlockIfFull, name: "Terminal" } }
        };
        set_print_channel(channels.up.0);
        if let Some(mut peripherals) = cortex_m::Peripherals::take() {
            peripherals.DCB.enable_trace();
            peripherals.DWT.enable_cycle_counter();
        }
        task::visit(&mut Stopwatch);
        rprintln!("bench done");
        cortex_m::asm::bkpt();
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// A candidate that panics ends the run; the report says which results are missing.
    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        rprintln!("bench panic line={}", info.location().map_or(0, |at| at.line()));
        cortex_m::asm::bkpt();
        loop {
            cortex_m::asm::wfi();
        }
    }
}
