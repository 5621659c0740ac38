//! Tables of a world, one per part of the machine, with the range of every number.

use super::within;
use crate::Error;
use serde::Deserialize;

/// Defines a table of numbers: the struct, and for each field its permitted range.
macro_rules! section {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident in $min:expr, $max:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: f64,)*
        }

        impl $name {
            pub(super) fn validate(&self, section: &str) -> Result<(), Error> {
                $(within(&format!("{section}.{}", stringify!($field)), self.$field, $min, $max)?;)*
                Ok(())
            }
        }
    };
}

section! {
    /// Brushed motor.
    Motor {
        /// Torque per ampere at 25 degrees Celsius, newton metre per ampere.
        torque_constant_nm_per_a in 1e-4, 1.0;
        /// Terminal resistance at 25 degrees Celsius, ohm.
        resistance_ohm in 0.05, 1e3;
        /// L/R, second.
        electrical_time_constant_s in 1e-6, 1e-2;
        /// Rotor inertia, kilogram square metre.
        rotor_inertia_kg_m2 in 1e-10, 1e-3;
        /// Bearing and brush friction, newton metre.
        coulomb_nm in 0.0, 1e-2;
        /// Viscous friction, newton metre second per radian.
        viscous_nm_s_per_rad in 0.0, 1e-4;
        /// Ripple of the torque constant, peak to peak, relative.
        commutation_ripple in 0.0, 0.5;
        /// Ripple periods a turn.
        commutation_per_rev in 1.0, 100.0;
        /// Change of resistance, relative per kelvin.
        copper_temperature_coefficient_per_k in 0.0, 0.01;
        /// Winding to housing, kelvin per watt.
        winding_thermal_resistance_k_per_w in 0.01, 1e3;
        /// Housing to air, kelvin per watt.
        housing_thermal_resistance_k_per_w in 0.01, 1e3;
        /// Winding, second.
        winding_thermal_time_constant_s in 0.1, 1e4;
        /// Housing, second.
        housing_thermal_time_constant_s in 1.0, 1e5;
        /// Air, degree Celsius.
        ambient_c in -40.0, 80.0;
        /// Change of the torque constant with the housing's temperature, relative per kelvin.
        magnet_temperature_coefficient_per_k in -0.01, 0.0;
    }
}

section! {
    /// Planetary gearhead.
    Gearhead {
        /// Turns of the motor for one at its output.
        ratio in 1.0, 1e4;
        /// Efficiency of what it transmits, without the drag.
        efficiency in 0.1, 1.0;
        /// Drag without load, seen at the motor, newton metre.
        drag_nm in 0.0, 1e-2;
        /// Backlash, encoder counts.
        backlash_counts in 0.0, 1e5;
    }
}

section! {
    /// Worm and wheel.
    Worm {
        /// Turns of the worm for one of the wheel.
        ratio in 1.0, 1e3;
        /// Lead angle, degree.
        lead_angle_deg in 0.5, 45.0;
        /// Pitch radius of the worm: sets the sliding speed, metre.
        pitch_radius_m in 5e-4, 0.1;
        /// Friction coefficient at rest.
        friction_static in 0.0, 1.0;
        /// Friction coefficient, running, at vanishing speed.
        friction_running in 0.0, 1.0;
        /// Factor in `exp(-factor v^exponent)`, v in metre per second.
        friction_speed_factor in 0.0, 100.0;
        /// Exponent in `exp(-factor v^exponent)`.
        friction_speed_exponent in 0.1, 2.0;
        /// Sliding speed over which static friction gives way to running friction, metre per second.
        stribeck_speed_m_per_s in 1e-6, 1.0;
        /// Backlash, encoder counts.
        backlash_counts in 0.0, 1e5;
        /// Drag that varies once a turn of the worm, amplitude at the motor, newton metre.
        eccentric_drag_nm in 0.0, 1e-2;
        /// Where that drag peaks, degree.
        eccentric_phase_deg in -360.0, 360.0;
        /// Drag that varies once a turn of the wheel, amplitude at the motor, newton metre.
        wheel_eccentric_drag_nm in 0.0, 1e-2;
        /// Where that drag peaks, degree.
        wheel_eccentric_phase_deg in -360.0, 360.0;
        /// Ripple of the friction coefficient once a turn of the worm, amplitude, relative: it goes with the load.
        friction_ripple in 0.0, 0.5;
        /// Where that peaks, degree.
        friction_ripple_phase_deg in -360.0, 360.0;
    }
}

section! {
    /// Cable from the wheel to the input link.
    Cable {
        /// Elastic stiffness, newton per metre.
        stiffness_n_per_m in 10.0, 1e10;
        /// Radius of both pulleys, metre.
        pulley_radius_m in 1e-3, 1.0;
        /// Final creep strain, relative to the elastic strain.
        creep_fraction in 0.0, 1.0;
        /// Time constant of creep, second.
        creep_time_s in 0.01, 1e4;
        /// Additional, slower creep strain, relative to the elastic strain.
        slow_creep_fraction in 0.0, 1.0;
        /// Its time constant, second.
        slow_creep_time_s in 0.01, 1e5;
        /// Growth of the stiffness with the torque at the input link, relative per newton metre.
        stiffening_per_nm in 0.0, 10.0;
    }
}

section! {
    /// Incremental encoder on the motor shaft.
    Encoder {
        /// Edges of both phases a turn.
        counts_per_rev in 4.0, 1e6;
        /// Periodic error, once a turn, amplitude, counts.
        periodic_error_counts in 0.0, 100.0;
        /// Its phase, degree.
        periodic_phase_deg in -360.0, 360.0;
        /// Non-periodic error, rms, counts.
        random_error_counts in 0.0, 100.0;
        /// Its correlation distance, motor turns.
        random_error_revs in 1e-3, 100.0;
    }
}

section! {
    /// Current sense of the bridge.
    Sense {
        /// Resistor from the sense output to ground, ohm.
        resistor_ohm in 10.0, 1e6;
        /// Mirrored current, ampere per ampere.
        mirror_a_per_a in 1e-6, 0.1;
        /// White noise, one independent value a plant step, ampere at the motor.
        noise_rms_a in 0.0, 0.1;
        /// Volt per ampere of an amplifier on a shunt in the motor's lead, which takes the mirror's place; 0: the mirror.
        shunt_v_per_a in 0.0, 1000.0;
        /// Its output at no current, volt.
        shunt_zero_v in 0.0, 5.0;
        /// Relative error of the mirror and the resistor.
        gain_error in -0.5, 0.5;
        /// Offset at power-on, ampere at the motor.
        offset_a in -0.1, 0.1;
        /// Further offset that builds up while running, ampere at the motor.
        offset_drift_a in -0.1, 0.1;
        /// Time constant of the drift, second.
        offset_drift_time_s in 0.1, 1e5;
        /// Voltage at which the converter saturates.
        full_scale_v in 0.5, 10.0;
        /// Change of the mirror's gain from no current to full scale, relative.
        nonlinearity in -0.2, 0.2;
        /// Delay of the mirror after an edge of the PWM, second: a time constant; without edges, the part of every on-time that
        /// is not measured.
        settling_s in 0.0, 5e-6;
        /// Capacitor at the converter's pin, farad.
        pin_f in 0.0, 1e-6;
        /// Between the shunt's amplifier and the pin, ohm.
        shunt_pin_ohm in 0.0, 1e5;
        /// Share of a current against the drive that is measured without edges: it flows through the sense in the off part of the
        /// PWM.
        opposing_share in 0.0, 1.0;
    }
}

impl Sense {
    /// Whether a shunt in the motor's lead senses the current, with its sign, instead of the bridge's mirror.
    #[must_use]
    pub fn is_shunt(&self) -> bool {
        self.shunt_v_per_a > 0.0
    }

    /// Nominal sense voltage per ampere of motor current, volt per ampere.
    #[must_use]
    pub fn volt_per_a(&self) -> f64 {
        if self.is_shunt() {
            self.shunt_v_per_a
        } else {
            self.mirror_a_per_a * self.resistor_ohm
        }
    }

    /// Nominal sense voltage at zero current, volt.
    #[must_use]
    pub fn zero_v(&self) -> f64 {
        if self.is_shunt() {
            self.shunt_zero_v
        } else {
            0.0
        }
    }

    /// Impedance that drives the converter's pin, ohm.
    #[must_use]
    pub fn pin_ohm(&self) -> f64 {
        if self.is_shunt() {
            self.shunt_pin_ohm
        } else {
            self.resistor_ohm
        }
    }

    /// Motor current at which the mirror's voltage reaches the converter's full scale, ampere.
    #[must_use]
    pub fn full_scale_a(&self) -> f64 {
        self.full_scale_v / (self.resistor_ohm * self.mirror_a_per_a)
    }
}

section! {
    /// H-bridge.
    Bridge {
        /// Where its own chopping limits the current, ampere.
        chop_current_a in 0.01, 100.0;
        /// Both switches in the path, ohm.
        on_resistance_ohm in 0.0, 100.0;
        /// From nSLEEP high to a driven output, second.
        wake_s in 0.0, 0.1;
        /// Supply voltage below which it switches off, volt.
        undervoltage_v in 0.0, 60.0;
        /// Dead time at every edge, second: voltage that the current's own direction takes.
        dead_time_s in 0.0, 2e-6;
        /// Frequency of the PWM, hertz.
        pwm_hz in 1e3, 5e5;
        /// 1: the current follows every edge of the PWM; 0: it follows the mean voltage.
        edges in 0.0, 1.0;
        /// Drop of a switch's body diode, volt; with edges.
        diode_v in 0.0, 2.0;
        /// What the bridge itself takes while awake, ampere.
        quiescent_a in 0.0, 0.1;
    }
}

section! {
    /// Coil in series with the motor, which smooths the current that the PWM makes.
    Choke {
        /// Inductance, henry; 0: none fitted.
        inductance_h in 0.0, 0.1;
        /// Of its wire, ohm.
        resistance_ohm in 0.0, 100.0;
    }
}

section! {
    /// Motor supply.
    Supply {
        /// Open-circuit voltage.
        voltage_v in 0.0, 60.0;
        /// Internal resistance, ohm.
        internal_resistance_ohm in 0.0, 100.0;
        /// Divider to the converter, volt per volt.
        divider in 1e-3, 1.0;
        /// Noise at the supply, volt.
        noise_rms_v in 0.0, 5.0;
        /// Capacitor beside the bridge, which stores what braking returns, farad; 0: the supply takes it back.
        bulk_f in 0.0, 0.1;
        /// Impedance of the divider, ohm.
        pin_ohm in 0.0, 1e6;
        /// Capacitor at the converter's pin, farad.
        pin_f in 0.0, 1e-6;
    }
}

section! {
    /// Input of the chip's converters.
    Converter {
        /// Capacitor that holds a sample, and the last channel's voltage before, farad; 0: ideal.
        hold_f in 0.0, 1e-9;
        /// Its switch, ohm.
        switch_ohm in 0.0, 1e5;
    }
}

section! {
    /// Optional angle sensor at joint 2.
    Hall {
        /// Output at theta_2 = 0, volt.
        zero_v in -20.0, 20.0;
        /// Output per radian, volt.
        sensitivity_v_per_rad in -10.0, 10.0;
        /// Noise, volt.
        noise_rms_v in 0.0, 1.0;
    }
}

section! {
    /// Object against phalanx.
    Contact {
        /// Stiffness of a contact point, newton per metre.
        stiffness_n_per_m in 1e3, 1e9;
        /// Coulomb friction coefficient.
        friction in 0.0, 2.0;
        /// What the finger's builder sets as `contact-friction`, because it is known about the skin; 0 leaves it to the scene.
        stated_friction in 0.0, 1.5;
        /// Sliding speed below which a contact counts as sticking, metre per second.
        creep_speed_m_per_s in 1e-8, 1e-2;
    }
}

section! {
    /// Parameters common to all fingers.
    Mechanism {
        /// Viscous damping of each joint, newton metre second per radian.
        damping_nm_s_per_rad in 1e-6, 1.0;
        /// Relative error of all springs against the finger's table.
        spring_error in -0.9, 10.0;
        /// Mechanical stops, newton metre per radian.
        stop_stiffness_nm_per_rad in 1.0, 1e6;
        /// Half the thickness of a phalanx: the object touches its surface, metre.
        phalanx_half_thickness_m in 1e-3, 0.1;
        /// Where the input link stands at power-on, above its opening stop, radian.
        start_above_stop_rad in 0.0, 3.0;
        /// How far beyond its lower stop the spring of a joint that rests there is preloaded, degree; joints from 2.
        preload_deg in 0.0, 45.0;
        /// Coulomb friction of each joint, newton metre.
        joint_friction_nm in 0.0, 0.1;
        /// Friction of a tendon on the pulley of joints from 2, as a share of the torque that it passes there.
        capstan_share in 0.0, 0.9;
        /// Gravity in the plane of motion, metre per square second.
        gravity_m_per_s2 in 0.0, 10.0;
        /// Direction of gravity from the x axis (phalanx 1 where theta_1 is zero), counterclockwise, degree.
        mounting_deg in -360.0, 360.0;
        /// Tolerance of the lengths of a randomly drawn finger, metre.
        geometry_m in 0.0, 1e-3;
        /// Mass of a phalanx, even over its length, kilogram per metre.
        linear_density_kg_per_m in 0.0, 10.0;
    }
}

section! {
    /// Changes of the friction of motor, gearhead and worm during operation.
    Friction {
        /// Wander, an Ornstein-Uhlenbeck process, rms, as a share of the friction.
        wander_share in 0.0, 0.5;
        /// Its time constant, second.
        wander_time_s in 0.01, 1e4;
        /// Final change by warm-up, as a share of the friction.
        warm_up_share in -0.9, 1.0;
        /// Its time constant, second.
        warm_up_time_s in 0.1, 1e5;
    }
}

section! {
    /// Angle errors between worm and wheel, and hysteresis by the cable's friction.
    Transmission {
        /// Error once a turn of the worm, amplitude, radian of the wheel.
        worm_error_rad in 0.0, 0.1;
        /// What the finger's builder states of it as `sensing.worm_error_rad`, because it was measured; 0 leaves it to the scene. The
        /// simulation heeds it; an emulated image has its own scene.
        stated_worm_error_rad in 0.0, 0.02;
        /// Where it peaks, degree.
        worm_error_phase_deg in -360.0, 360.0;
        /// Error once a turn of the wheel, amplitude, radian of the wheel.
        wheel_error_rad in 0.0, 0.1;
        /// Where it peaks, degree.
        wheel_error_phase_deg in -360.0, 360.0;
        /// Error of the gearhead, amplitude, radian of the wheel.
        gear_error_rad in 0.0, 0.1;
        /// Periods of it in a turn of the worm; not a whole number.
        gear_error_per_worm_rev in 0.1, 1000.0;
        /// Error that never repeats, an Ornstein-Uhlenbeck process over the way, rms, radian of the wheel.
        random_error_rad in 0.0, 0.1;
        /// Its correlation distance, turns of the worm.
        random_error_worm_revs in 1e-3, 1e3;
        /// Hysteresis as a share of the load, against the motion.
        hysteresis_share in 0.0, 0.5;
        /// Distance after a reversal over which it changes sign, radian of the wheel.
        hysteresis_rad in 1e-5, 1.0;
    }
}
