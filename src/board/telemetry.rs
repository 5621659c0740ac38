//! Everything that the firmware says in its log: one line a record, `name key=value key=value`, units in the keys, lengths
//! in millimetre and torques in millinewton metre. A value that is not known is `NaN`. Programs may read these
//! lines; docs/MANUAL.md#log-lines describes them.

use defmt::{Str, error, info, intern, warn};

use palpate::app::hint::Hint;
use palpate::drive::config::OutOfRange;
use palpate::drive::fault::Fault;
use palpate::drive::sequence::{MotionResult, State};
use palpate::drive::{LimitsReached, Status};
use palpate::sensing::{Calibration, Event, NotLocated, Refusal, Side};

use super::crash::Crash;
use super::reset::Reset;
use super::watchdog::Missing;

/// Metre to millimetre, newton metre to millinewton metre, radian to milliradian, ampere to milliampere.
const MILLI: f32 = 1e3;

/// `boot`: the first line.
pub fn boot(scene: &str) {
    info!(
        "boot version={=str} scene={=str}",
        env!("CARGO_PKG_VERSION"),
        scene
    );
}

/// `reset`: why the chip started.
pub fn reset(reset: Reset) {
    info!("reset cause={=istr}", reset.name());
}

/// `watchdog`: who had not reported when it bit.
pub fn watchdog(missing: Missing) {
    error!(
        "watchdog control_missing={=bool} sensing_missing={=bool} sequence_missing={=bool}",
        missing.control, missing.sensing, missing.sequence
    );
}

/// `crash`: what the last run left before it reset itself; of a panic `line` and, as `text`, the file.
pub fn crash(crash: &Crash) {
    error!(
        "crash cause={=istr} pc={=u32:#x} lr={=u32:#x} status={=u32:#x} address={=u32:#x} line={=u32} text={=str}",
        crash.cause().name(),
        crash.pc,
        crash.lr,
        crash.status,
        crash.address,
        crash.line,
        crash.file()
    );
}

/// `log`: records lost since boot, because no one read them in time.
pub fn dropped(dropped: u32) {
    warn!("log dropped={=u32}", dropped);
}

/// `state`: the motion sequence went on.
pub fn state(from: State, to: State) {
    info!("state name={=str} from={=str}", to.name(), from.name());
}

/// `sequence done`: how a motion ended.
pub fn done(outcome: MotionResult) {
    let verdict = match outcome {
        MotionResult::Contact => intern!("contact"),
        MotionResult::NoContact => intern!("no-contact"),
        MotionResult::NotRecorded => intern!("not-recorded"),
        MotionResult::Complete => intern!("complete"),
        MotionResult::Stopped => intern!("stopped"),
    };
    info!("sequence done verdict={=istr}", verdict);
}

/// `fault`: the bridge is off until `clear`. Causes and remedies are in docs/MANUAL.md#faults, not in flash.
pub fn fault(fault: Fault) {
    error!(
        "fault number={=u8} name={=str}",
        fault.number(),
        fault.name()
    );
}

/// `limit`: demands that were clamped, when that changes.
pub fn limited(limited: LimitsReached) {
    warn!(
        "limit current={=bool} duty={=bool} speed={=bool} position={=bool}",
        limited.current, limited.duty, limited.speed, limited.position
    );
}

/// `offset`: the current sense's offset, measured at every start of a motion.
pub fn offset(offset_a: f32) {
    info!("offset current_ma={=f32}", offset_a * MILLI);
}

/// `status`: asked for by the command.
pub fn status(state: State, fault: Option<Fault>, status: &Status) {
    info!(
        "status state={=str} position_counts={=i32} homed={=bool} current_ma={=f32} supply_v={=f32} winding_c={=f32} fault={=u8}",
        state.name(),
        status.position_counts,
        status.homed,
        status.current_a * MILLI,
        status.supply_v,
        status.winding_c,
        fault.map_or(0, Fault::number)
    );
}

fn why_not(why: NotLocated) -> Str {
    match why {
        NotLocated::Proximal => intern!("proximal"),
        NotLocated::TooSoft => intern!("too-soft"),
        NotLocated::Gap => intern!("gap"),
        NotLocated::TooStiff => intern!("too-stiff"),
        NotLocated::TooFewSamples => intern!("too-few-samples"),
        NotLocated::Unexplained => intern!("unexplained"),
    }
}

fn why_refused(why: Refusal) -> Str {
    match why {
        Refusal::NoContact => intern!("no-contact"),
        Refusal::TooFewSamples => intern!("too-few-samples"),
        Refusal::NoSuchPlace => intern!("no-such-place"),
        Refusal::Misfit => intern!("misfit"),
        Refusal::Implausible => intern!("implausible"),
        Refusal::Uninformative => intern!("uninformative"),
    }
}

/// What sensing has to say.
pub fn event(event: &Event) {
    match *event {
        Event::FrictionRecorded {
            closing_nm,
            opening_nm,
            residual_nm,
            coverage,
        } => info!(
            "friction-recorded closing_mnm={=f32} opening_mnm={=f32} residual_mnm={=f32} coverage={=f32}",
            closing_nm * MILLI,
            opening_nm * MILLI,
            residual_nm * MILLI,
            coverage
        ),
        Event::FrictionNotRecorded { coverage } => {
            warn!("friction-not-recorded coverage={=f32}", coverage)
        }
        Event::FrictionStale { misfit_nm } => {
            warn!("friction-stale misfit_mnm={=f32}", misfit_nm * MILLI)
        }
        Event::Unusual {
            k_a_nm_per_rad,
            k_a_free_nm_per_rad,
        } => warn!(
            "unusual k_a_nm_per_rad={=f32} k_a_free_nm_per_rad={=f32}",
            k_a_nm_per_rad, k_a_free_nm_per_rad
        ),
        Event::Touch {
            time_us,
            theta_a_rad,
            torque_nm,
        } => info!(
            "touch time_us={=u64} theta_a_mrad={=f32} torque_mnm={=f32}",
            time_us,
            theta_a_rad * MILLI,
            torque_nm * MILLI
        ),
        Event::Located {
            phalanx,
            k_m,
            sigma_m,
            k_c_nm_per_rad,
            force_n,
            radius_m,
            radius_sigma_m,
            settled,
        } => info!(
            "located phalanx={=u8} k_mm={=f32} sigma_mm={=f32} k_c_nm_per_rad={=f32} force_n={=f32} radius_mm={=f32} radius_sigma_mm={=f32} settled={=bool}",
            phalanx,
            k_m * MILLI,
            sigma_m * MILLI,
            k_c_nm_per_rad,
            force_n,
            radius_m * MILLI,
            radius_sigma_m * MILLI,
            settled
        ),
        Event::Ambiguous {
            phalanx,
            k_m,
            sigma_m,
            settled,
        } => info!(
            "ambiguous phalanx={=u8} k_mm={=f32} sigma_mm={=f32} other_phalanx={=u8} other_k_mm={=f32} other_sigma_mm={=f32} settled={=bool}",
            phalanx[0],
            k_m[0] * MILLI,
            sigma_m[0] * MILLI,
            phalanx[1],
            k_m[1] * MILLI,
            sigma_m[1] * MILLI,
            settled
        ),
        Event::NotLocated { why, torque_nm } => info!(
            "not-located why={=istr} torque_mnm={=f32}",
            why_not(why),
            torque_nm * MILLI
        ),
        Event::Calibrated { calibration } => self::calibration(&calibration),
        Event::CalibrationRefused { why } => {
            warn!("calibration-refused why={=istr}", why_refused(why))
        }
    }
}

/// `joint`: the sensor of joint 2 reads what the joint cannot have (a wire, a magnet), or is well again. Contacts are judged
/// without it meanwhile.
// A symbol of its own: its absence shows that a scene without the sensor does not carry this.
#[inline(never)]
pub fn joint(reads: bool) {
    if reads {
        info!("joint reading=true");
    } else {
        warn!("joint reading=false");
    }
}

/// `branch`: by how much joint 2 has turned since contact, and the side of e_2 that this speaks for; told with every place.
#[inline(never)]
pub fn branch(change_rad: Option<f32>, side: Option<Side>) {
    let side = match side {
        Some(Side::Below) => intern!("below"),
        Some(Side::Beyond) => intern!("beyond"),
        Some(Side::Unclear) => intern!("unclear"),
        None => intern!("no-reading"),
    };
    info!(
        "branch change_mrad={=f32} side={=istr}",
        change_rad.unwrap_or(f32::NAN) * MILLI,
        side
    );
}

/// `calibrated`: what is known of efficiency over spring stiffness, and of the cable.
pub fn calibration(calibration: &Calibration) {
    info!(
        "calibrated torque_factor={=f32} torque_factor_sigma={=f32} cable_mrad_per_nm={=f32} cable_sigma_mrad_per_nm={=f32} correlation={=f32} contacts={=u8} presses={=u8}",
        calibration.torque_factor,
        calibration.torque_factor_sigma,
        calibration.cable_rad_per_nm * MILLI,
        calibration.cable_sigma_rad_per_nm * MILLI,
        calibration.correlation,
        calibration.contacts,
        calibration.presses
    );
}

/// `record`: what was found in flash at start, and how many words in it were beyond repair.
pub fn record(state: Str, bad_words: u32) {
    info!("record state={=istr} bad_words={=u32}", state, bad_words);
}

/// `commands`: lines ignored since boot, because too many waited.
pub fn ignored(ignored: u32) {
    warn!("commands ignored={=u32}", ignored);
}

/// `bad-configuration`: a parameter of the drive that is out of its range.
pub fn bad_configuration(wrong: &OutOfRange) {
    error!(
        "bad-configuration name={=str} value={=f32} min={=f32} max={=f32}",
        wrong.name, wrong.value, wrong.min, wrong.max
    );
}

/// `hint`: what to do next in the guided calibration, as text.
pub fn hint(hint: Hint) {
    match hint {
        Hint::Press => info!("hint leave the finger free and enter: calibrate cable"),
        Hint::Pin { k_mm } => info!(
            "hint put a pin at {=u16} mm from the last joint and enter: calibrate {=u16}",
            k_mm, k_mm
        ),
        Hint::Save => info!("hint calibrated; remove the pin and enter: save"),
        Hint::RecordFriction => info!("hint leave the finger free and enter: record-friction"),
        Hint::Again(Refusal::NoContact) => {
            info!("hint nothing was felt: put the pin into the finger's way and repeat")
        }
        Hint::Again(Refusal::TooFewSamples) => {
            info!("hint the press was too short: is the current limit high enough? repeat")
        }
        Hint::Again(Refusal::NoSuchPlace) => {
            info!("hint no such place on the last phalanx: give the pin's distance")
        }
        Hint::Again(Refusal::Misfit) => {
            info!("hint that was no single fixed pin: fix it, let nothing else touch, and repeat")
        }
        Hint::Again(Refusal::Implausible) => info!(
            "hint too far from what was known: check the place and repeat, or enter: calibrate forget"
        ),
        Hint::Again(Refusal::Uninformative) => {
            info!("hint nothing new was learned: choose another place")
        }
    }
}

/// `answer`: the answer to a command line, as text.
pub fn answer(text: &str) {
    info!("answer {=str}", text);
}
