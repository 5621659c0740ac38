//! Configuration of motor, gears, board and limits: immutable, checked once.

use super::convert::Scale;
pub use crate::range::{OutOfRange, check};

/// The motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Torque constant, newton metre per ampere; equal to the back-EMF constant in volt second per radian.
    pub torque_constant_nm_per_a: f32,
    /// Resistance of the winding when cold, ohm.
    pub resistance_ohm: f32,
    /// Resistance of the choke in its lead, ohm; 0 without one.
    pub choke_ohm: f32,
    /// Rotor inertia, kilogram square metre.
    pub rotor_inertia_kg_m2: f32,
    /// Heating of the winding.
    pub thermal: Thermal,
}

/// Two-body thermal model of the motor: winding in housing in ambient air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Highest permitted winding temperature, degree Celsius.
    pub limit_c: f32,
    /// Assumed ambient temperature, degree Celsius.
    pub ambient_c: f32,
    /// Thermal resistance winding to housing, kelvin per watt.
    pub winding_k_per_w: f32,
    /// Thermal resistance housing to ambient, kelvin per watt.
    pub housing_k_per_w: f32,
    /// Time constant of the winding, second.
    pub winding_s: f32,
    /// Time constant of the housing, second.
    pub housing_s: f32,
}

/// Encoder and gears between motor and input link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gearing {
    /// Encoder counts (x4 edges) a motor revolution.
    pub counts_per_motor_rev: f32,
    /// Motor revolutions a revolution of the input link.
    pub reduction: f32,
}

/// Scaling of the board's analogue inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalogInputs {
    /// ADC reference, volt.
    pub reference_v: f32,
    /// Current sense, volt per ampere.
    pub volt_per_a: f32,
    /// Voltage of the current sense at no current, volt: 0 for a bridge's mirror, half the reference for an amplifier.
    pub zero_v: f32,
    /// The current sense is an amplifier on a shunt in the motor's lead: its reading has the sign of the current, closing
    /// positive. A bridge's mirror reads a magnitude.
    pub signed: bool,
    /// Supply voltage over voltage at the pin.
    pub supply_divider: f32,
}

/// Limits (clamped, reported) and trips (bridge off).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest current the loops may ask for, ampere. Limit.
    pub current_a: f32,
    /// Current that switches the bridge off at once, ampere. Trip.
    pub current_trip_a: f32,
    /// Largest duty, 0 to 1. Limit.
    pub duty: f32,
    /// Largest speed of the input link, radian per second. Limit.
    pub speed_rad_per_s: f32,
    /// Acceleration of the speed reference, radian per second squared at the input link. Limit.
    pub acceleration_rad_per_s2: f32,
    /// Angle of the input link from the opening stop beyond which opening is suppressed once homed, radian; negative, since
    /// the cable winds up against the stop. Limit.
    pub position_min_rad: f32,
    /// Angle beyond which closing is suppressed once homed, radian. Limit.
    pub position_max_rad: f32,
    /// How far beyond these angles the finger may be found, radian. Trip.
    pub overtravel_rad: f32,
    /// Lowest supply, volt. Trip.
    pub supply_min_v: f32,
    /// Highest supply, volt. Trip.
    pub supply_max_v: f32,
}

/// Everything the controller is built from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The motor.
    pub motor: Motor,
    /// Encoder and gears.
    pub drivetrain: Gearing,
    /// Analogue inputs.
    pub sense: AnalogInputs,
    /// Limits and trips.
    pub limits: Limits,
}

impl Limits {
    /// Checks the limits that a user may set: current against its trip, lowest against highest supply, both within the
    /// board's inputs.
    const fn check_set(&self, sense: &AnalogInputs) -> Result<(), OutOfRange> {
        check(&[
            (
                "current_a",
                self.current_a,
                0.001,
                // Above the limit by what a motor 20 % off its resistance overshoots.
                0.8 * self.current_trip_a,
            ),
            ("supply_min_v", self.supply_min_v, 3.0, 40.0),
            (
                "supply_max_v",
                self.supply_max_v,
                self.supply_min_v,
                sense.reference_v * sense.supply_divider,
            ),
        ])
    }
}

impl Motor {
    /// Resistance between the bridge's outputs, winding and choke, ohm.
    pub const fn circuit_ohm(&self) -> f32 {
        self.resistance_ohm + self.choke_ohm
    }

    /// Checks what may be measured.
    const fn check(&self) -> Result<(), OutOfRange> {
        check(&[
            (
                "torque_constant_nm_per_a",
                self.torque_constant_nm_per_a,
                1e-4,
                1.0,
            ),
            ("resistance_ohm", self.resistance_ohm, 0.1, 500.0),
            ("choke_ohm", self.choke_ohm, 0.0, 100.0),
            ("rotor_inertia_kg_m2", self.rotor_inertia_kg_m2, 1e-10, 1e-3),
        ])
    }
}

impl Config {
    /// Checks every value against what the drive's arithmetic and this board can do.
    const fn check(&self) -> Result<(), OutOfRange> {
        let Self {
            motor,
            drivetrain,
            sense,
            limits,
        } = self;
        let thermal = &motor.thermal;
        let full_scale_a = (sense.reference_v - sense.zero_v) / sense.volt_per_a;
        let counts_per_rad =
            drivetrain.counts_per_motor_rev * drivetrain.reduction / core::f32::consts::TAU;
        // Jumps are distinguished from motion by a count of up to 16 a control period: see the encoder.
        let fastest_rad_per_s = 16.0 * 20_000.0 / counts_per_rad;
        // Positions are wrapping 32-bit counts: a quarter of their range leaves room for every difference.
        let reach_rad = 5e8 / counts_per_rad;
        let checked = check(&[
            ("limit_c", thermal.limit_c, 40.0, 155.0),
            (
                "ambient_c",
                thermal.ambient_c,
                -20.0,
                thermal.limit_c - 10.0,
            ),
            ("winding_k_per_w", thermal.winding_k_per_w, 0.1, 200.0),
            ("housing_k_per_w", thermal.housing_k_per_w, 0.1, 200.0),
            ("winding_s", thermal.winding_s, 0.1, 1000.0),
            ("housing_s", thermal.housing_s, 1.0, 10_000.0),
            (
                "counts_per_motor_rev",
                drivetrain.counts_per_motor_rev,
                4.0,
                65_536.0,
            ),
            ("reduction", drivetrain.reduction, 1.0, 10_000.0),
            ("reference_v", sense.reference_v, 1.0, 3.6),
            ("volt_per_a", sense.volt_per_a, 0.01, 1000.0),
            ("zero_v", sense.zero_v, 0.0, 0.6 * sense.reference_v),
            ("supply_divider", sense.supply_divider, 1.0, 100.0),
            (
                "current_trip_a",
                limits.current_trip_a,
                0.001,
                // Saturation hides the value.
                0.95 * full_scale_a,
            ),
            ("duty", limits.duty, 0.05, 1.0),
            (
                "speed_rad_per_s",
                limits.speed_rad_per_s,
                1e-3,
                fastest_rad_per_s,
            ),
            (
                "acceleration_rad_per_s2",
                limits.acceleration_rad_per_s2,
                1e-3,
                1e4,
            ),
            ("position_min_rad", limits.position_min_rad, -reach_rad, 0.0),
            ("position_max_rad", limits.position_max_rad, 0.0, reach_rad),
            ("overtravel_rad", limits.overtravel_rad, 1e-3, reach_rad),
        ]);
        match (checked, motor.check()) {
            (Ok(()), Ok(())) => limits.check_set(sense),
            (Ok(()), wrong) | (wrong, _) => wrong,
        }
    }
}

/// A checked configuration with the scales that follow from it. A scene's is a constant: an inconsistent one does not
/// compile, and the firmware carries neither the check nor the names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedConfig {
    config: Config,
    scale: Scale,
}

impl CheckedConfig {
    /// Checks every value against what the drive's arithmetic and this board can do.
    ///
    /// # Errors
    /// The first value out of range.
    pub const fn new(config: Config) -> Result<Self, OutOfRange> {
        match config.check() {
            Ok(()) => Ok(Self {
                scale: Scale::of(&config),
                config,
            }),
            Err(wrong) => Err(wrong),
        }
    }

    /// The same with other values of what a user may set: largest current, ampere, lowest and highest supply, volt.
    ///
    /// # Errors
    /// The first of them that is out of range.
    pub fn with_limits(
        mut self,
        current_a: f32,
        supply_min_v: f32,
        supply_max_v: f32,
    ) -> Result<Self, OutOfRange> {
        let limits = &mut self.config.limits;
        limits.current_a = current_a;
        limits.supply_min_v = supply_min_v;
        limits.supply_max_v = supply_max_v;
        limits.check_set(&self.config.sense)?;
        Ok(self)
    }

    /// The same with another motor.
    ///
    /// # Errors
    /// The first of its values that is out of range.
    pub fn with_motor(mut self, motor: Motor) -> Result<Self, OutOfRange> {
        self.config.motor = motor;
        self.config.motor.check()?;
        self.scale = Scale::of(&self.config);
        Ok(self)
    }

    /// The configuration.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Its scales.
    pub const fn scale(&self) -> &Scale {
        &self.scale
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::scene::{P70, Scene};

    /// The drive of the default scene.
    pub(crate) const fn p70() -> Config {
        <P70 as Scene>::DRIVE
    }

    #[test]
    fn the_prototype_is_valid() {
        assert_eq!(
            CheckedConfig::new(p70()).map(|checked| *checked.config()),
            Ok(p70())
        );
    }

    #[test]
    fn every_value_out_of_range_is_named() {
        type Spoil = fn(&mut Config, f32);
        let spoils: &[(&str, Spoil)] = &[
            ("torque_constant_nm_per_a", |c, v| {
                c.motor.torque_constant_nm_per_a = v
            }),
            ("resistance_ohm", |c, v| c.motor.resistance_ohm = v),
            ("choke_ohm", |c, v| c.motor.choke_ohm = v),
            ("rotor_inertia_kg_m2", |c, v| {
                c.motor.rotor_inertia_kg_m2 = v
            }),
            ("limit_c", |c, v| c.motor.thermal.limit_c = v),
            ("ambient_c", |c, v| c.motor.thermal.ambient_c = v),
            ("winding_k_per_w", |c, v| {
                c.motor.thermal.winding_k_per_w = v
            }),
            ("housing_k_per_w", |c, v| {
                c.motor.thermal.housing_k_per_w = v
            }),
            ("winding_s", |c, v| c.motor.thermal.winding_s = v),
            ("housing_s", |c, v| c.motor.thermal.housing_s = v),
            ("counts_per_motor_rev", |c, v| {
                c.drivetrain.counts_per_motor_rev = v
            }),
            ("reduction", |c, v| c.drivetrain.reduction = v),
            ("reference_v", |c, v| c.sense.reference_v = v),
            ("volt_per_a", |c, v| c.sense.volt_per_a = v),
            ("zero_v", |c, v| c.sense.zero_v = v),
            ("supply_divider", |c, v| c.sense.supply_divider = v),
            ("current_a", |c, v| c.limits.current_a = v),
            ("current_trip_a", |c, v| c.limits.current_trip_a = v),
            ("duty", |c, v| c.limits.duty = v),
            ("speed_rad_per_s", |c, v| c.limits.speed_rad_per_s = v),
            ("acceleration_rad_per_s2", |c, v| {
                c.limits.acceleration_rad_per_s2 = v
            }),
            ("position_min_rad", |c, v| c.limits.position_min_rad = v),
            ("position_max_rad", |c, v| c.limits.position_max_rad = v),
            ("overtravel_rad", |c, v| c.limits.overtravel_rad = v),
            ("supply_min_v", |c, v| c.limits.supply_min_v = v),
            ("supply_max_v", |c, v| c.limits.supply_max_v = v),
        ];
        for &(name, spoil) in spoils {
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
                let mut config = p70();
                spoil(&mut config, value);
                let error = CheckedConfig::new(config).expect_err(name);
                assert_eq!(error.name, name);
                assert!(error.value.to_bits() == value.to_bits());
            }
        }
    }
}
