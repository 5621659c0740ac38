//! What a user may set at run time: names, units, ranges, in one table.
//!
//! The defaults come from the scene; a value that was set and saved overrides them after the next start. Values are
//! kept in SI units; the user speaks the unit of the table.

/// One thing that can be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Setting {
    /// Speed of the input link while closing, recording friction and probing, radian per second.
    ClosingSpeed,
    /// Largest motor current, ampere.
    CurrentLimit,
    /// Torque at the input link, above friction, at which probing ends, newton metre.
    ProbeTorque,
    /// Standard deviation of the contact location at which probing may end early, metre.
    WantedDeviation,
    /// Contact force to hold after probing, newton.
    HoldForce,
    /// How long to hold it, second.
    HoldTime,
    /// Efficiency of the drivetrain under load, used until a calibration replaces it, 0 to 1.
    Efficiency,
    /// Supply voltage below which the bridge is switched off, volt.
    SupplyMin,
    /// Supply voltage above which the bridge is switched off, volt.
    SupplyMax,
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// Which setting.
    pub setting: Setting,
    /// What a user types.
    pub name: &'static str,
    /// The user's unit, empty for a number without one.
    pub unit: &'static str,
    /// One of the user's units in SI units.
    pub unit_si: f32,
    /// Smallest allowed value, in the user's unit.
    pub min: f32,
    /// Largest allowed value, in the user's unit.
    pub max: f32,
}

const fn row(
    setting: Setting,
    name: &'static str,
    unit: &'static str,
    unit_si: f32,
    min: f32,
    max: f32,
) -> Description {
    Description {
        setting,
        name,
        unit,
        unit_si,
        min,
        max,
    }
}

impl Setting {
    /// Number of settings.
    pub const COUNT: usize = 9;

    /// Every setting, in the order of the enum.
    pub const TABLE: [Description; Self::COUNT] = [
        // Below 0.05 rad/s the worm creeps by stick-slip; above 0.8 the motor has no voltage left for load.
        row(
            Setting::ClosingSpeed,
            "closing-speed",
            "rad/s",
            1.0,
            0.05,
            0.8,
        ),
        // 183 mA is the motor's nominal current; below 30 mA friction alone may stop it.
        row(
            Setting::CurrentLimit,
            "current-limit",
            "mA",
            1e-3,
            30.0,
            183.0,
        ),
        row(
            Setting::ProbeTorque,
            "probe-torque",
            "mNm",
            1e-3,
            5.0,
            500.0,
        ),
        row(
            Setting::WantedDeviation,
            "wanted-deviation",
            "mm",
            1e-3,
            0.1,
            20.0,
        ),
        row(Setting::HoldForce, "hold-force", "N", 1.0, 0.1, 20.0),
        row(Setting::HoldTime, "hold-time", "s", 1.0, 0.0, 60.0),
        row(Setting::Efficiency, "efficiency", "%", 1e-2, 5.0, 95.0),
        // The bridge runs from 4.5 V; the winding is made for 12 V.
        row(Setting::SupplyMin, "supply-min", "V", 1.0, 4.5, 12.0),
        row(Setting::SupplyMax, "supply-max", "V", 1.0, 12.0, 16.0),
    ];

    /// Name, unit and range.
    pub const fn describe(self) -> &'static Description {
        // The discriminant is below COUNT, the table's length: the index cannot fail.
        &Self::TABLE[self as usize]
    }

    /// The setting that a user names.
    pub fn by_name(name: &str) -> Option<Self> {
        let row = Self::TABLE
            .iter()
            .find(|row| row.name.eq_ignore_ascii_case(name))?;
        Some(row.setting)
    }
}

impl Description {
    /// The value in SI units, or `None` where the user's value is not finite or out of range.
    pub fn to_si(&self, value: f32) -> Option<f32> {
        // A NaN is in no range.
        (self.min..=self.max)
            .contains(&value)
            .then_some(value * self.unit_si)
    }

    /// A value in SI units as the user reads it.
    pub fn to_user(&self, value_si: f32) -> f32 {
        value_si / self.unit_si
    }
}

/// The values that a user has set; what is not set keeps the scene's default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overrides {
    /// In the order of [`Setting::TABLE`].
    pub(super) values_si: [Option<f32>; Setting::COUNT],
}

impl Overrides {
    /// The value in SI units where one was set.
    pub fn get(&self, setting: Setting) -> Option<f32> {
        self.values_si.get(setting as usize).copied().flatten()
    }

    /// Sets a value in SI units.
    ///
    /// # Errors
    /// The allowed range, where the value is outside or not finite; nothing is changed then.
    pub fn set(&mut self, setting: Setting, value_si: f32) -> Result<(), &'static Description> {
        let row = setting.describe();
        // The range is the user's; allow for the rounding of the unit's factor at its ends.
        let user = row.to_user(value_si);
        let slack = 1e-6 * row.max;
        if !(row.min - slack..=row.max + slack).contains(&user) {
            return Err(row);
        }
        if let Some(value) = self.values_si.get_mut(setting as usize) {
            *value = Some(value_si);
        }
        Ok(())
    }

    /// Whether every value lies in its range, as it must after it was read from a memory.
    pub fn is_valid(&self) -> bool {
        let mut copy = Self::default();
        Setting::TABLE.iter().all(|row| {
            self.get(row.setting)
                .is_none_or(|value| copy.set(row.setting, value).is_ok())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enum_and_every_name_leads_back() {
        for (index, row) in Setting::TABLE.iter().enumerate() {
            assert_eq!(row.setting as usize, index, "{}", row.name);
            assert_eq!(Setting::by_name(row.name), Some(row.setting));
            assert!(row.min < row.max && row.unit_si > 0.0, "{}", row.name);
        }
        assert_eq!(
            Setting::by_name("CLOSING-speed"),
            Some(Setting::ClosingSpeed)
        );
        assert_eq!(Setting::by_name("speed"), None);
    }

    #[test]
    fn the_ends_of_every_range_are_accepted_and_what_lies_beyond_is_not() {
        for row in &Setting::TABLE {
            let mut overrides = Overrides::default();
            for value in [row.min, row.max] {
                let si = row.to_si(value).expect(row.name);
                assert!(
                    overrides.set(row.setting, si).is_ok(),
                    "{} {value}",
                    row.name
                );
                assert!((row.to_user(si) - value).abs() <= 1e-5 * row.max);
                assert!(overrides.is_valid());
            }
            for value in [row.min * 0.9 - 0.1, row.max * 1.1, f32::NAN, f32::INFINITY] {
                assert_eq!(row.to_si(value), None, "{} {value}", row.name);
                assert!(overrides.set(row.setting, value * row.unit_si).is_err());
            }
        }
    }

    #[test]
    fn a_value_from_a_damaged_memory_is_noticed() {
        let mut overrides = Overrides::default();
        assert!(overrides.is_valid());
        overrides.values_si[Setting::Efficiency as usize] = Some(f32::NAN);
        assert!(!overrides.is_valid());
    }
}
