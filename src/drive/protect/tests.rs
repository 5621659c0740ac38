//! What the detectors find, and when.

use super::*;
use crate::drive::config::tests::p70;

/// A motor that closes with 60 mA and turns at 3 counts a period, as its voltage says.
fn healthy() -> PeriodState {
    let config = p70();
    let (reading_a, speed) = (0.06, 3.0);
    let emf_v = Scale::of(&config).emf_v_per_count_per_period() * speed;
    PeriodState {
        state: BridgeState::Awake,
        applied_v: config.motor.circuit_ohm() * reading_a + emf_v,
        reference_a: reading_a,
        reading_a,
        supply_v: 12.0,
        speed,
        encoder_plausible: true,
        beyond_counts: 0,
        hot: false,
    }
}

fn protection(signed: bool) -> Protection {
    let mut config = p70();
    config.sense.signed = signed;
    Protection::new(&config, &Scale::of(&config))
}

/// What the checks of many periods say first, and after how many; the code of the sense moves as noise makes it.
fn first(
    protection: &mut Protection,
    periods: u32,
    seen: impl Fn(u32) -> (Inputs, PeriodState),
) -> Option<(u32, Fault)> {
    (0..periods).find_map(|period| {
        let fault = check(protection, period, seen(period))?;
        Some((period, fault))
    })
}

/// What the checks of one period say.
fn check(
    protection: &mut Protection,
    period: u32,
    (inputs, observed): (Inputs, PeriodState),
) -> Option<Fault> {
    let slot = period % u32::from(SLOTS);
    protection.check(&inputs, &observed, slot as u8)
}

fn noisy(period: u32) -> Inputs {
    Inputs {
        current: AdcCode(8000 + (7 * period % 11) as u16),
        ..Inputs::default()
    }
}

#[test]
fn what_endangers_an_awake_bridge_is_found_at_once_and_of_a_sleeping_one_is_none() {
    let limits = p70().limits;
    let overtravel_counts = Scale::of(&p70()).counts(limits.overtravel_rad);
    type Spoil<'a> = &'a dyn Fn(&mut Inputs, &mut PeriodState);
    let cases: [(Fault, Spoil); 4] = [
        (Fault::Overrun, &|inputs, _| inputs.overrun = true),
        (Fault::SupplyLow, &|_, seen| {
            seen.supply_v = limits.supply_min_v - 0.1
        }),
        (Fault::EncoderJump, &|_, seen| {
            seen.encoder_plausible = false
        }),
        (Fault::TravelLimit, &|_, seen| {
            seen.beyond_counts = overtravel_counts + 1
        }),
    ];
    for (fault, spoil) in cases {
        for state in [BridgeState::Awake, BridgeState::Waking, BridgeState::Asleep] {
            let (mut inputs, mut seen) = (noisy(0), healthy());
            seen.state = state;
            spoil(&mut inputs, &mut seen);
            let told = protection(false).check(&inputs, &seen, FREE_SLOT);
            let expected = (state != BridgeState::Asleep).then_some(fault);
            assert_eq!(told, expected, "{state:?}");
        }
    }
    // Just as far as it may go.
    let mut seen = healthy();
    seen.beyond_counts = overtravel_counts;
    assert_eq!(protection(false).check(&noisy(0), &seen, FREE_SLOT), None);
}

/// A sense with a sign reads a current against the voltage as negative, and has two ends.
#[test]
fn a_sense_with_a_sign_trips_either_way_and_at_either_end() {
    let trip_a = p70().limits.current_trip_a;
    for reading_a in [trip_a + 1e-3, -trip_a - 1e-3] {
        let mut seen = healthy();
        seen.reading_a = reading_a;
        let told = protection(true).check(&noisy(0), &seen, FREE_SLOT);
        assert_eq!(told, Some(Fault::OverCurrent), "{reading_a}");
    }
    for (code, signed, faults) in [
        (0, true, true),
        (0, false, false),
        (ADC_FULL, true, true),
        (ADC_FULL, false, true),
        (ADC_FULL / 2, true, false),
    ] {
        let inputs = Inputs {
            current: AdcCode(code),
            ..Inputs::default()
        };
        let told = protection(signed).check(&inputs, &healthy(), FREE_SLOT);
        let expected = faults.then_some(Fault::SenseSaturated);
        assert_eq!(told, expected, "{code} {signed}");
    }
}

/// A check without it takes one off, and does not begin anew: a wire that makes contact now and then is found too.
#[test]
fn a_contradiction_that_pauses_is_found() {
    let blind = |period: u32| {
        let mut seen = healthy();
        if !(period / u32::from(SLOTS)).is_multiple_of(4) {
            seen.speed = 0.0;
        }
        (noisy(period), seen)
    };
    let told = first(&mut protection(false), 1000, blind);
    // Three checks of four count up, one down: twice as long as without a pause.
    assert!(
        matches!(told, Some((300..500, Fault::EncoderStuck))),
        "{told:?}"
    );
    let healthy = |period| (noisy(period), healthy());
    assert_eq!(first(&mut protection(false), 1000, healthy), None);
}

/// Zero is where an unsigned sense ends: readings of it repeat themselves, and are judged for as long as those of nothing.
#[test]
fn a_reading_that_repeats_itself_is_found_sooner_than_one_of_nothing() {
    let frozen = |code, reading_a| {
        move |_| {
            let inputs = Inputs {
                current: AdcCode(code),
                ..Inputs::default()
            };
            let mut seen = healthy();
            seen.reading_a = reading_a;
            (inputs, seen)
        }
    };
    let told = first(&mut protection(false), 1000, frozen(8000, 0.06));
    assert!(
        matches!(told, Some((40..60, Fault::SenseStuck))),
        "{told:?}"
    );
    let told = first(&mut protection(false), 1000, frozen(0, 0.0));
    assert!(
        matches!(told, Some((200..220, Fault::SenseStuck))),
        "{told:?}"
    );
}

/// Who asks in any period whether it is still there is told the same, and that it is mended as soon as it is.
#[test]
fn an_offset_that_is_wrong_shows_in_every_period_until_it_is_mended() {
    let mut protection = protection(false);
    let reads = |reading_a: f32| PeriodState {
        reading_a,
        state: BridgeState::Asleep,
        applied_v: 0.0,
        speed: 0.0,
        ..healthy()
    };
    let wrong = |period: u32| (noisy(period), reads(2.0 * OFFSET_LIMIT_A));
    let (_, fault) = first(&mut protection, 10_000, wrong).expect("a fault");
    assert_eq!(fault, Fault::OffsetOutOfRange);
    for period in 0..10_000 {
        let told = check(&mut protection, period, wrong(period));
        assert_eq!(told, Some(Fault::OffsetOutOfRange), "{period}");
    }
    for period in 0..3 * u32::from(SLOTS) {
        let told = check(&mut protection, period, (noisy(period), reads(0.0)));
        assert!(
            told.is_none() || period < u32::from(SLOTS),
            "{period}: {told:?}"
        );
    }
}
