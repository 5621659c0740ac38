//! The grammar of the log: every line that the firmware writes, once, with its keys, units and types.
//!
//! A line is `name key=value key=value`, units in the keys. A value that is not known is `NaN`. The firmware writes the lines
//! with defmt, a replay of a recording as text or JSON, and programs read them with [`parse`]: all from [`log_lines!`](crate::log_lines).
//! docs/MANUAL.md#log-lines says what each means.

mod events;
mod fields;
mod limits;

pub use events::{calibrated, event, followed, object, object_with, status};
pub use fields::{Fields, Value};
pub use limits::LimitReport;

/// Hands the table of lines to a macro: name of the function, level, format as defmt has it, and the values with their types.
/// The names of the values are the keys, in the order of the format.
#[macro_export]
macro_rules! log_lines {
    ($generate:ident) => {
        $generate! {
            /// The first line.
            boot info "boot version={=str} scene={=str}" (version: &str, scene: &str);
            /// Why the chip started.
            reset info "reset cause={=str}" (cause: &str);
            /// The crystal did not start: the internal oscillator runs the chip, within 1 % of the nominal frequency.
            clock warn "clock source={=str}" (source: &str);
            /// The watchdog bit: who had not reported.
            watchdog error "watchdog control_missing={=bool} sensing_missing={=bool} sequence_missing={=bool}"
                (control_missing: bool, sensing_missing: bool, sequence_missing: bool);
            /// What the last run left before it reset itself; of a panic `line` and, as `text`, the file.
            crash error "crash cause={=str} pc={=u32:#x} lr={=u32:#x} status={=u32:#x} address={=u32:#x} line={=u32} text={=str}"
                (cause: &str, pc: u32, lr: u32, status: u32, address: u32, line: u32, text: &str);
            /// Records lost since boot, because no one read them in time.
            dropped warn "log dropped={=u32}" (dropped: u32);
            /// Command lines ignored since boot, because too many waited or a stop came behind them.
            ignored warn "commands ignored={=u32}" (ignored: u32);
            /// What was found in flash at start, and how many words in it were beyond repair.
            record info "record state={=str} bad_words={=u32}" (state: &str, bad_words: u32);
            /// A parameter of the drive that is out of its range.
            bad_configuration error "bad-configuration name={=str} value={=f32} min={=f32} max={=f32}"
                (name: &str, value: f32, min: f32, max: f32);
            /// The motion sequence changed its state.
            state info "state name={=str} from={=str}" (name: &str, from: &str);
            /// How a motion ended.
            done info "sequence done verdict={=str}" (verdict: &str);
            /// The bridge is off until `clear`.
            fault error "fault number={=u8} name={=str}" (number: u8, name: &str);
            /// Demands that are clamped for so long that something is wrong: the supply, the friction, a limit set too low.
            limit warn "limit current={=bool} duty={=bool} speed={=bool} position={=bool}"
                (current: bool, duty: bool, speed: bool, position: bool);
            /// The current sense's offset, measured at every start of a motion.
            offset info "offset current_ma={=f32}" (current_ma: f32);
            /// Asked for by the command.
            status info "status state={=str} position_counts={=i32} homed={=bool} current_ma={=f32} supply_v={=f32} winding_c={=f32} fault={=u8}"
                (state: &str, position_counts: i32, homed: bool, current_ma: f32, supply_v: f32, winding_c: f32, fault: u8);
            /// A step of the self-test: what was measured, what it must be, and what to look at where it is not.
            selftest info "selftest step={=str} result={=str} value={=f32} want={=str} remedy={=str}"
                (step: &str, result: &str, value: f32, want: &str, remedy: &str);
            /// The next closing calibrates: on a pin at this distance from the joint of the distal phalanx, or NaN on the stop.
            calibrating info "calibrating pin_m={=f32}" (pin_m: f32);
            /// A quantity of the motor: measured, with its deviation, and what the scene says.
            identify info "identify quantity={=str} value={=f32} sigma={=f32} datasheet={=f32} unit={=str} deviation_percent={=f32} result={=str}"
                (quantity: &str, value: f32, sigma: f32, datasheet: f32, unit: &str, deviation_percent: f32, result: &str);
            /// A free motion was recorded.
            friction_recorded info "friction-recorded closing_mnm={=f32} opening_mnm={=f32} residual_mnm={=f32} coverage={=f32} wander_mnm={=f32} wander_s={=f32}"
                (closing_mnm: f32, opening_mnm: f32, residual_mnm: f32, coverage: f32, wander_mnm: f32, wander_s: f32);
            /// A free motion left too little of it to record.
            friction_not_recorded warn "friction-not-recorded coverage={=f32}" (coverage: f32);
            /// The friction record no longer fits.
            friction_stale warn "friction-stale misfit_mnm={=f32}" (misfit_mnm: f32);
            /// Softer than expected without contact.
            unusual warn "unusual k_a_nm_per_rad={=f32} k_a_sigma_nm_per_rad={=f32} k_a_free_nm_per_rad={=f32}"
                (k_a_nm_per_rad: f32, k_a_sigma_nm_per_rad: f32, k_a_free_nm_per_rad: f32);
            /// A closing is over: global stiffness K_a (7), measured and expected without contact.
            stiffness info "stiffness k_a_nm_per_rad={=f32} k_a_sigma_nm_per_rad={=f32} k_a_free_nm_per_rad={=f32}"
                (k_a_nm_per_rad: f32, k_a_sigma_nm_per_rad: f32, k_a_free_nm_per_rad: f32);
            /// Contact begins.
            touch info "touch time_us={=u64} theta_a_mrad={=f32} torque_mnm={=f32}"
                (time_us: u64, theta_a_mrad: f32, torque_mnm: f32);
            /// A contact is located; repeated as it is refined.
            located info "located phalanx={=u8} k_mm={=f32} sigma_mm={=f32} k_c_nm_per_rad={=f32} force_n={=f32} radius_mm={=f32} radius_sigma_mm={=f32} settled={=bool} p_phalanx={=f32} force_sigma_n={=f32}"
                (phalanx: u8, k_mm: f32, sigma_mm: f32, k_c_nm_per_rad: f32, force_n: f32, radius_mm: f32, radius_sigma_mm: f32, settled: bool, p_phalanx: f32, force_sigma_n: f32);
            /// How stiff the object is, with the last word on a place. In scenes with that option.
            object info "object relative={=str} stiffness_n_per_mm={=f32} least_n_per_mm={=f32} compliance_mm_per_n={=f32} compliance_sigma_mm_per_n={=f32} share={=f32} share_sigma={=f32}"
                (relative: &str, stiffness_n_per_mm: f32, least_n_per_mm: f32, compliance_mm_per_n: f32, compliance_sigma_mm_per_n: f32, share: f32, share_sigma: f32);
            /// Two places explain the same contact.
            ambiguous info "ambiguous phalanx={=u8} k_mm={=f32} sigma_mm={=f32} other_phalanx={=u8} other_k_mm={=f32} other_sigma_mm={=f32} settled={=bool} p_phalanx={=f32} other_p_phalanx={=f32}"
                (phalanx: u8, k_mm: f32, sigma_mm: f32, other_phalanx: u8, other_k_mm: f32, other_sigma_mm: f32, settled: bool, p_phalanx: f32, other_p_phalanx: f32);
            /// A contact without a location.
            not_located info "not-located why={=str} torque_mnm={=f32}" (why: &str, torque_mnm: f32);
            /// Something else touches, too: the torque rises more steeply. In scenes with the option.
            second_contact info "second-contact phalanx={=u8} k_mm={=f32} sigma_mm={=f32} theta_a_mrad={=f32} torque_mnm={=f32} stiffness_nm_per_rad={=f32} stiffness_sigma_nm_per_rad={=f32}"
                (phalanx: u8, k_mm: f32, sigma_mm: f32, theta_a_mrad: f32, torque_mnm: f32, stiffness_nm_per_rad: f32, stiffness_sigma_nm_per_rad: f32);
            /// How the object is held when the closing is over, with the moments of two contacts that statics determines. In
            /// scenes with that option.
            grasp info "grasp grip={=str} torque_mnm={=f32} distal_moment_mnm={=f32} distal_force_n={=f32} proximal_moment_mnm={=f32}"
                (grip: &str, torque_mnm: f32, distal_moment_mnm: f32, distal_force_n: f32, proximal_moment_mnm: f32);
            /// Where the first contact is when the closing is over. In scenes with that option.
            moved info "moved phalanx={=u8} k_mm={=f32} sigma_mm={=f32} torque_mnm={=f32}"
                (phalanx: u8, k_mm: f32, sigma_mm: f32, torque_mnm: f32);
            /// The contact slipped, was lost, or was pushed from outside. In scenes with that option.
            contact_change warn "contact-change what={=str} from_mnm={=f32} to_mnm={=f32}"
                (what: &str, from_mnm: f32, to_mnm: f32);
            /// Torque factor and cable, as known now.
            calibrated info "calibrated torque_factor={=f32} torque_factor_sigma={=f32} cable_mrad_per_nm={=f32} cable_sigma_mrad_per_nm={=f32} correlation={=f32} stiffening_per_nm={=f32} stiffening_sigma_per_nm={=f32} contacts={=u16} presses={=u16}"
                (torque_factor: f32, torque_factor_sigma: f32, cable_mrad_per_nm: f32, cable_sigma_mrad_per_nm: f32, correlation: f32, stiffening_per_nm: f32, stiffening_sigma_per_nm: f32, contacts: u16, presses: u16);
            /// A calibration was refused; the one before stands.
            calibration_refused warn "calibration-refused why={=str}" (why: &str);
            /// The sensor of joint 2 gives values outside the joint's range (a wire, a magnet), or works again. Contacts are
            /// judged without it meanwhile.
            joint warn "joint reading={=bool}" (reading: bool);
            /// By how much joint 2 has turned since contact, and the side of e_2 that this indicates; with every place.
            branch info "branch change_mrad={=f32} side={=str}" (change_mrad: f32, side: &str);
            /// A sample of the drivetrain, streamed while `trace` is on; `drive` is 1 closing, -1 opening, 0 idle.
            /// While a contact is searched: what friction leaves, and the evidence of a contact with what it must exceed.
            sample info "sample time_us={=u64} counts={=i32} current_a={=f32} emf_v={=f32} drive={=i8} joint_rad={=f32} residual_mnm={=f32} evidence={=f32} threshold={=f32}"
                (time_us: u64, counts: i32, current_a: f32, emf_v: f32, drive: i8, joint_rad: f32, residual_mnm: f32, evidence: f32, threshold: f32);
            /// What to do next in the guided calibration.
            hint info "hint {=str}" (text: &str);
            /// The answer to a command line.
            answer info "answer {=str}" (text: &str);
        }
    };
}

/// How serious a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(non_camel_case_types, reason = "named as in the table and by defmt")]
pub enum Level {
    /// Part of normal operation.
    info,
    /// Something to look after.
    warn,
    /// Something that does not work.
    error,
}

/// A line of the grammar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// How serious it is.
    pub level: Level,
    /// Format as defmt has it.
    pub format: &'static str,
    /// Keys, in the order of the format; one without a key in the format is text up to the line's end.
    pub keys: &'static [&'static str],
}

impl Line {
    /// The words before the first value.
    pub fn name(&self) -> &'static str {
        parse(self.format).name
    }
}

macro_rules! declare {
    ($($(#[$doc:meta])* $function:ident $level:ident $format:literal ($($key:ident: $type:ty),*);)*) => {
        /// A log, with a function for each line.
        #[expect(clippy::too_many_arguments, reason = "a line has as many values as it has")]
        pub trait Log {
            $($(#[$doc])* fn $function(&mut self, $($key: $type),*);)*
        }

        /// Every line.
        pub const LINES: &[Line] = &[$(Line {
            level: Level::$level,
            format: $format,
            keys: &[$(stringify!($key)),*],
        }),*];
    };
}
log_lines!(declare);

/// Between two lines that a recording has before the same sample.
pub const BETWEEN_LINES: &str = " | ";

/// A line taken apart: leading words are the name, the rest fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parsed<'a> {
    /// Words before the first field.
    pub name: &'a str,
    fields: &'a str,
}

/// Takes a line apart. A value reaches to the next ` key=`, so it may contain blanks.
pub fn parse(line: &str) -> Parsed<'_> {
    let start = key_start(line, 0).unwrap_or(line.len());
    let (name, fields) = line.split_at(start);
    Parsed {
        name: name.trim_end(),
        fields,
    }
}

/// Where the next `key=` begins, from `from` on.
fn key_start(line: &str, from: usize) -> Option<usize> {
    let mut at = from;
    while let Some(equals) = line.get(at..)?.find('=').map(|found| at + found) {
        let start = line
            .get(from..equals)?
            .rfind(' ')
            .map_or(from, |blank| from + blank + 1);
        let key = line.get(start..equals)?;
        let named = key.starts_with(|c: char| c.is_ascii_alphabetic())
            && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if named {
            return Some(start);
        }
        at = equals + 1;
    }
    None
}

impl<'a> Parsed<'a> {
    /// Keys and values in the order of the line.
    pub fn fields(&self) -> impl Iterator<Item = (&'a str, &'a str)> {
        let mut rest = self.fields;
        core::iter::from_fn(move || {
            let (key, behind) = rest.split_once('=')?;
            let end = key_start(behind, 0).unwrap_or(behind.len());
            let (value, next) = behind.split_at_checked(end)?;
            rest = next;
            Some((key, value.trim_end()))
        })
    }

    /// A field's text.
    pub fn field(&self, key: &str) -> Option<&'a str> {
        self.fields()
            .find(|field| field.0 == key)
            .map(|field| field.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_reads_back_with_its_keys() {
        for line in LINES {
            let parsed = parse(line.format);
            assert!(!parsed.name.is_empty(), "{line:?}");
            let keys: Vec<&str> = parsed.fields().map(|field| field.0).collect();
            match line.name().strip_suffix(" {=str}") {
                // Text up to the end of the line.
                Some(_) => assert_eq!(line.keys, ["text"]),
                None => assert_eq!(keys, line.keys),
            }
            let others = LINES.iter().filter(|other| other.name() == line.name());
            assert_eq!(others.count(), 1, "{line:?}");
        }
    }

    #[test]
    fn events_are_read() {
        let line = parse("located phalanx=2 k_mm=30.1 sigma_mm=0.6 settled=true");
        assert_eq!(line.name, "located");
        assert_eq!(line.field("k_mm"), Some("30.1"));
        assert_eq!(line.field("settled"), Some("true"));
        assert_eq!(line.field("missing"), None);
    }

    #[test]
    fn a_value_may_have_blanks_and_a_line_no_fields() {
        let line = parse("not-located why=no stable root on any phalanx k_mm=-1");
        assert_eq!(line.field("why"), Some("no stable root on any phalanx"));
        assert_eq!(line.field("k_mm"), Some("-1"));
        let line = parse("sequence done");
        assert_eq!((line.name, line.fields().count()), ("sequence done", 0));
        assert_eq!(parse("a == b").fields().count(), 0);
    }
}
