//! The finger and posture of a row.

use super::table::{FileError, Row, Table};
use palpate::finger::{
    Assembly, Configuration, Finger, Levers, Linkage, Mechanics, Parameters, Tendon, Transmission,
};

/// Number of phalanges and kind of transmission, as the header tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Two phalanges, tendon.
    Tendon2,
    /// Two phalanges, linkage.
    Linkage2,
    /// Three phalanges, tendon.
    Tendon3,
    /// Three phalanges, linkage.
    Linkage3,
    /// Four phalanges, linkage.
    Linkage4,
    /// Five phalanges, tendon.
    Tendon5,
    /// Six phalanges, tendon.
    Tendon6,
    /// Six phalanges, linkage.
    Linkage6,
}

impl Kind {
    /// From the header.
    pub fn of(table: &Table) -> Result<Self, FileError> {
        if table.has(&["l6", "r10"]) {
            Ok(Self::Tendon6)
        } else if table.has(&["l6", "a5", "mode5"]) {
            Ok(Self::Linkage6)
        } else if table.has(&["l5", "r8"]) {
            Ok(Self::Tendon5)
        } else if table.has(&["l4", "a3", "mode3"]) {
            Ok(Self::Linkage4)
        } else if table.has(&["l3", "r4"]) {
            Ok(Self::Tendon3)
        } else if table.has(&["l3", "a2", "mode2"]) {
            Ok(Self::Linkage3)
        } else if table.has(&["l2", "r2"]) {
            Ok(Self::Tendon2)
        } else if table.has(&["l2", "a1", "mode1"]) {
            Ok(Self::Linkage2)
        } else {
            Err(table.error(
                "no finger in the header: neither pulleys (r1..) nor levers (a1..)".to_owned(),
            ))
        }
    }
}

/// A transmission that a row can describe.
pub trait FromRow<const N: usize>: Transmission<N> {
    /// Its design.
    fn design(row: &Row<'_>) -> Result<Self::Design, FileError>;
}

macro_rules! from_row {
    ($($phalanges:literal: $radii:literal $([$($stage:literal)*])?;)*) => { $(
        impl FromRow<$phalanges> for Tendon<$phalanges> {
            fn design(row: &Row<'_>) -> Result<[f32; $radii], FileError> {
                numbered(row, "r", "")
            }
        }
        $(impl FromRow<$phalanges> for Linkage<{ $phalanges - 1 }> {
            fn design(row: &Row<'_>) -> Result<[Levers; $phalanges - 1], FileError> {
                Ok([$(levers(row, $stage)?),*])
            }
        })?
    )* };
}

from_row! {
    2: 2 [1];
    3: 4 [1 2];
    4: 6 [1 2 3];
    5: 8;
    6: 10 [1 2 3 4 5];
}

fn levers(row: &Row<'_>, stage: u8) -> Result<Levers, FileError> {
    let column = |name: &str| row.f32(&format!("{name}{stage}"));
    Ok(Levers {
        driving_m: column("a")?,
        coupler_m: column("b")?,
        driven_m: column("c")?,
        offset_rad: column("psi")?,
        assembly: assembly(row, &format!("mode{stage}"))?,
    })
}

/// A `mode` column.
pub fn assembly(row: &Row<'_>, column: &str) -> Result<Assembly, FileError> {
    match row.f32(column)? {
        -1.0 => Ok(Assembly::Clockwise),
        1.0 => Ok(Assembly::Counterclockwise),
        other => Err(row.error(format!("{column} is {other}, neither -1 nor 1"))),
    }
}

/// Columns of a name with a number behind it.
pub fn numbered<const N: usize>(
    row: &Row<'_>,
    before: &str,
    after: &str,
) -> Result<[f32; N], FileError> {
    let mut values = [0.0; N];
    for (value, number) in values.iter_mut().zip(1..) {
        *value = row.f32(&format!("{before}{number}{after}"))?;
    }
    Ok(values)
}

/// The row's finger; its joints' stops are as near as the row's postures allow.
pub fn finger<const N: usize, T: FromRow<N>>(row: &Row<'_>) -> Result<Finger<N, T>, FileError> {
    let rest_rad = numbered::<N>(row, "th", "0")?;
    let mut range_rad = rest_rad.map(|a| [a, a]);
    for after in ["", "_after"] {
        let Ok(angles) = numbered::<N>(row, "th", after) else {
            continue;
        };
        for (range, angle) in range_rad.iter_mut().zip(angles) {
            *range = [range[0].min(angle - 1e-3), range[1].max(angle + 1e-3)];
        }
    }
    let parameters = Parameters {
        lengths_m: numbered(row, "l", "")?,
        stiffness_nm_per_rad: numbered(row, "K", "")?,
        rest_rad,
        range_rad,
    };
    Finger::new(parameters, T::design(row)?).map_err(|error| row.error(error.to_string()))
}

/// The posture at the torque of `column`, solved by the library from a sample nearby: the row's angles.
pub fn posture<const N: usize, T>(
    row: &Row<'_>,
    finger: &Finger<N, T>,
    column: &str,
) -> Result<Option<(Configuration<N>, f32)>, FileError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let torque = row.f32(column)?;
    let near = finger
        .configuration(numbered(row, "th", "")?)
        .map_err(|error| row.error(error.to_string()))?;
    Ok(finger.free_at_torque(torque, &near).map(|at| (at, torque)))
}
