//! Checks of the library for each family of reference files.

mod contact;
mod free;
mod hard;
mod inverse;
mod parts;
mod second;
mod stiffness;

use super::fingers::Kind;
use super::measure::FileReport;
use super::table::{FileError, Table};
use contact::contact;
use free::preshape;
use hard::{hard_pair, hard_triple};
use inverse::inverse;
use palpate::finger::{Linkage, Tendon};
use parts::{four_bar, static_forces};
use second::{actuated, second};
use stiffness::stiffness;

/// Calls a generic function for the finger that the header describes.
macro_rules! by_kind {
    ($table:expr, $function:ident, $report:expr) => {
        match Kind::of($table)? {
            Kind::Tendon2 => $function::<2, Tendon<2>>($table, $report),
            Kind::Linkage2 => $function::<2, Linkage<1>>($table, $report),
            Kind::Tendon3 => $function::<3, Tendon<3>>($table, $report),
            Kind::Linkage3 => $function::<3, Linkage<2>>($table, $report),
            Kind::Linkage4 => $function::<4, Linkage<3>>($table, $report),
            Kind::Tendon5 => $function::<5, Tendon<5>>($table, $report),
            Kind::Tendon6 => $function::<6, Tendon<6>>($table, $report),
            Kind::Linkage6 => $function::<6, Linkage<5>>($table, $report),
        }
    };
}

/// Evaluates a file; its header says which family it belongs to.
pub fn evaluate(table: &Table) -> Result<FileReport, FileError> {
    let mut report = FileReport::new(&table.name);
    if table.has(&["g", "a", "b", "c", "psi", "mode", "v", "status"]) {
        four_bar(table, &mut report)?;
    } else if table.has(&["tau1", "f1", "x2"]) {
        static_forces(table, &mut report)?;
    } else if table.has(&["K2p", "k_minus", "k_plus"]) {
        hard_pair(table, &mut report)?;
    } else if table.has(&["disc_rel", "k_a", "k_b", "x3"]) {
        hard_triple(table, &mut report)?;
    } else if table.has(&["C_meas", "n_sol"]) {
        by_kind!(table, inverse, &mut report)?;
    } else if table.has(&["phal_b", "C_second"]) {
        match Kind::of(table)? {
            Kind::Tendon3 => second::<Tendon<3>>(table, &mut report)?,
            Kind::Linkage3 => second::<Linkage<2>>(table, &mut report)?,
            _ => {
                return Err(
                    table.error("a second contact of other than three phalanges".to_owned())
                );
            }
        }
    } else if table.has(&["t1", "C1", "phal"]) {
        actuated(table, &mut report)?;
    } else if table.has(&["dT", "dtheta_a", "k_after"]) {
        by_kind!(table, contact, &mut report)?;
    } else if table.has(&["T_a", "K_a", "K_tangent"]) {
        by_kind!(table, preshape, &mut report)?;
    } else if table.has(&["T_c", "phal", "C", "df_dT"]) {
        by_kind!(table, stiffness, &mut report)?;
    } else {
        return Err(
            table.error("its header is that of no known family of reference files".to_owned())
        );
    }
    Ok(report)
}

/// A value that may be absent, as a number; an absent one counts as not finite.
fn number(value: Option<f32>) -> f64 {
    value.map_or(f64::NAN, f64::from)
}

/// Error relative to the value, or to `scale` where the value is smaller.
fn relative(got: f64, want: f64, scale: f64) -> f64 {
    (got - want).abs() / want.abs().max(scale)
}

/// Limit of an error relative to the natural scale of its quantity.
const NATURAL: f64 = 1e-5;
