//! What a user may set at run time: names, units, ranges, in one table.
//!
//! The defaults come from the scene; a value that was set and saved overrides them after the next start. Values are
//! kept in SI units; the user speaks the unit of the table.

use core::fmt;

use zerocopy::{FromBytes, Immutable, IntoBytes};

use super::text::{Decimal, same};
use crate::name_list::nth;

/// The values that a setting may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// One of the user's units in SI units.
    pub unit_si: f32,
    /// Smallest allowed value, in the user's unit.
    pub min: f32,
    /// Largest allowed value, in the user's unit.
    pub max: f32,
}

/// Declares the settings: those that every firmware has, and those of a finger whose weight its scene states.
macro_rules! settings {
    ({$($every:tt)*} {$($weight:tt)*}) => {
        #[cfg(weightless)]
        declare! { $($every)* }
        #[cfg(not(weightless))]
        declare! { $($every)* $($weight)* }
    };
}

/// Declares them once: the enum and its tables come from the same lines.
macro_rules! declare {
    ($($(#[$text:meta])* $setting:ident $name:literal $unit:literal $unit_si:literal, $min:literal to $max:literal;)*) => {
        /// One thing that can be set.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Setting {
            $($(#[$text])* $setting,)*
        }

        impl Setting {
            /// Every setting, in the order of the enum.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$setting),*];

            /// What a user types.
            pub fn name(self) -> &'static str {
                nth(concat!($($name, "\n",)*), self as u8)
            }

            /// The user's unit.
            pub fn unit(self) -> &'static str {
                nth(concat!($($unit, "\n",)*), self as u8)
            }
        }

        /// The units' sizes and the allowed values, in the same order.
        const RANGES: [Range; Setting::ALL.len()] = [
            $(Range { unit_si: $unit_si, min: $min, max: $max }),*
        ];
    };
}

settings! {
{
    /// Speed of the input link while closing, recording friction and probing, radian per second.
    // Below 0.05 rad/s the worm creeps by stick-slip; above 0.8 the motor has no voltage left for load.
    ClosingSpeed "closing-speed" "rad/s" 1.0, 0.05 to 0.8;
    /// Largest motor current, ampere.
    // 183 mA is the motor's nominal current; below 30 mA friction alone may stop it.
    CurrentLimit "current-limit" "mA" 1e-3, 30.0 to 183.0;
    /// Torque at the input link, above friction, at which probing ends, newton metre.
    ProbeTorque "probe-torque" "mNm" 1e-3, 5.0 to 500.0;
    /// Standard deviation of the contact location at which probing may end early, metre.
    WantedDeviation "wanted-deviation" "mm" 1e-3, 0.1 to 20.0;
    /// False contacts per thousand free closings; see docs/MANUAL.md#sensitivity for the delay that each choice costs.
    Sensitivity "sensitivity" "per1000" 1.0, 0.001 to 100.0;
    /// Contact force to hold after probing, newton.
    HoldForce "hold-force" "N" 1.0, 0.1 to 20.0;
    /// How long to hold it, second.
    HoldTime "hold-time" "s" 1.0, 0.0 to 60.0;
    /// Efficiency of the drivetrain under load, used until a calibration replaces it, 0 to 1. A change forgets the calibration, which
    /// corrects the old one.
    Efficiency "efficiency" "%" 1e-2, 5.0 to 95.0;
    /// Coefficient of friction between the phalanges' skin and objects, as a share.
    ContactFriction "contact-friction" "%" 1e-2, 0.0 to 150.0;
    /// What a scale under a contact reads over the force that is told with the scene's springs (this setting at 1).
    ForceScale "force-scale" "%" 1e-2, 50.0 to 200.0;
    /// Supply voltage below which the bridge is switched off, volt.
    // The bridge runs from 4.5 V; the winding is made for 12 V, which lies between any two limits.
    SupplyMin "supply-min" "V" 1.0, 4.5 to 11.5;
    /// Supply voltage above which the bridge is switched off, volt.
    SupplyMax "supply-max" "V" 1.0, 12.5 to 16.0;
}
{
    /// Direction of gravity in the plane of motion, counterclockwise from phalanx 1 where its joint angle is zero, radian.
    Mounting "mounting" "deg" 0.017453292, -180.0 to 180.0;
    /// What acts in that plane, over the weight that the scene states, as a share: nothing where it is level.
    Weight "weight" "%" 1e-2, 0.0 to 1000.0;
}
}

impl Setting {
    /// The values that it may have.
    pub const fn range(self) -> &'static Range {
        // The discriminant is below the table's length: the index cannot fail.
        &RANGES[self as usize]
    }

    /// The setting that a user names.
    pub fn by_name(name: &[u8]) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|setting| same(name, setting.name()))
    }
}

/// `0.05 to 0.8`, in the user's unit.
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", Decimal(self.min), Decimal(self.max))
    }
}

impl Range {
    /// The value in SI units, or `None` where the user's value is not finite or out of range.
    pub fn to_si(&self, value: f32) -> Option<f32> {
        // A NaN is in no range.
        let is_allowed = value >= self.min && value <= self.max;
        is_allowed.then_some(value * self.unit_si)
    }

    /// A value in SI units as the user reads it.
    pub fn to_user(&self, value_si: f32) -> f32 {
        value_si / self.unit_si
    }

    /// Whether a value in SI units is one of them.
    pub fn contains_si(&self, value_si: f32) -> bool {
        // The range is the user's; allow for the rounding of the unit's factor at its ends.
        let value = self.to_user(value_si);
        let slack = 1e-6 * self.max;
        value >= self.min - slack && value <= self.max + slack
    }
}

/// The values that a user has set; what is not set keeps the scene's default.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, Immutable)]
#[repr(C)]
pub struct Overrides {
    /// In the order of [`Setting::ALL`], [`UNSET`] where none was set.
    values_si: [f32; Setting::ALL.len()],
}

/// In no range.
const UNSET: f32 = f32::INFINITY;

impl Default for Overrides {
    fn default() -> Self {
        Self {
            values_si: [UNSET; Setting::ALL.len()],
        }
    }
}

impl Overrides {
    /// The value in SI units where one was set.
    pub fn get(&self, setting: Setting) -> Option<f32> {
        let value = self.values_si.get(setting as usize).copied();
        value.filter(|value| *value < UNSET)
    }

    /// Sets a value in SI units.
    ///
    /// # Errors
    /// The allowed range, where the value is outside or not finite; nothing is changed then.
    pub fn set(&mut self, setting: Setting, value_si: f32) -> Result<(), &'static Range> {
        let range = setting.range();
        if !range.contains_si(value_si) {
            return Err(range);
        }
        if let Some(value) = self.values_si.get_mut(setting as usize) {
            *value = value_si;
        }
        Ok(())
    }

    /// Whether every value lies in its range, as it must after it was read from a memory.
    pub fn is_valid(&self) -> bool {
        (RANGES.iter().zip(&self.values_si))
            .all(|(range, &value)| value == UNSET || range.contains_si(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_in_the_order_of_the_enum_and_every_name_leads_back() {
        for (index, setting) in Setting::ALL.into_iter().enumerate() {
            assert_eq!(setting as usize, index, "{setting:?}");
            let name = format!("{setting:?}").to_lowercase();
            assert_eq!(setting.name().replace('-', ""), name);
            assert_eq!(Setting::by_name(setting.name().as_bytes()), Some(setting));
            let range = setting.range();
            assert!(range.min < range.max && range.unit_si > 0.0, "{name}");
            let one = match setting.unit() {
                "mA" | "mNm" | "mm" => 1e-3,
                "%" => 1e-2,
                "deg" => core::f32::consts::PI / 180.0,
                _ => 1.0,
            };
            assert_eq!(range.unit_si, one, "{name}");
        }
        assert_eq!(
            Setting::by_name(b"CLOSING-speed"),
            Some(Setting::ClosingSpeed)
        );
        assert_eq!(Setting::by_name(b"speed"), None);
    }

    #[test]
    fn the_ends_of_every_range_are_accepted_and_what_lies_beyond_is_not() {
        for setting in Setting::ALL {
            let (name, range) = (setting.name(), setting.range());
            let mut overrides = Overrides::default();
            for value in [range.min, range.max] {
                let si = range.to_si(value).expect(name);
                assert!(overrides.set(setting, si).is_ok(), "{name} {value}");
                assert!((range.to_user(si) - value).abs() <= 1e-5 * range.max);
                assert!(overrides.is_valid());
            }
            for value in [
                range.min - 0.1 * range.min.abs() - 0.1,
                range.max * 1.1,
                f32::NAN,
                f32::INFINITY,
            ] {
                assert_eq!(range.to_si(value), None, "{name} {value}");
                assert!(overrides.set(setting, value * range.unit_si).is_err());
            }
        }
    }

    #[test]
    fn every_pair_of_supply_limits_leaves_a_volt_for_the_supply() {
        let (low, high) = (Setting::SupplyMin.range(), Setting::SupplyMax.range());
        assert!(high.min - low.max >= 1.0);
        assert!(low.max < 12.0 && 12.0 < high.min);
    }

    #[test]
    fn a_value_from_a_damaged_memory_is_noticed() {
        let mut overrides = Overrides::default();
        assert!(overrides.is_valid());
        overrides.values_si[Setting::Efficiency as usize] = f32::NAN;
        assert!(!overrides.is_valid());
    }
}
