//! The drivetrain between encoder and input link, as far as sensing needs it.

/// Constants of the drivetrain, seen from the input link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drivetrain {
    /// Rotation of the input link per encoder count, radian, > 0.
    pub rad_per_count: f32,
    /// Encoder counts per turn of the motor, > 0: what repeats with the motor's turn is averaged over it.
    pub counts_per_turn: u32,
    /// Encoder counts per turn of the slowest shaft but the last (a worm): friction beyond what was recorded is continued
    /// with that period. 0 for none.
    pub counts_per_worm_turn: u32,
    /// Share of the cable's twist that comes late (creep), 0 to 1.
    pub creep: f32,
    /// Time constant of the creep, second, > 0.
    pub creep_s: f32,
    /// Angle theta_a of the input link at the opening stop, where the encoder counts from, radian.
    pub opening_stop_rad: f32,
    /// Torque at the input link per ampere if nothing were lost: reduction times torque constant, newton metre per
    /// ampere, > 0.
    pub torque_per_ampere_nm: f32,
    /// Standard deviation of the torque constant in it, as a share: what a back-EMF may correct before a calibration. 0 of one that was
    /// measured.
    pub torque_constant_sigma: f32,
    /// Resistance by which [`Sample::emf_v`](crate::sample::Sample::emf_v) was computed, ohm.
    pub resistance_ohm: f32,
    /// Share of a load's torque that the gears pass on, 0 to 1. Nominal: what it really is, in proportion to the
    /// spring's stiffness, a calibration determines ([`crate::sensing::Calibration`]).
    pub efficiency: f32,
    /// Inertia of the rotor seen from the input link, kg m2, >= 0: the torque that it takes to change the speed is not
    /// the load's.
    pub inertia_kg_m2: f32,
    /// Its standard deviation, as a share of it.
    pub inertia_sigma: f32,
    /// Viscous part of the friction seen from the input link, newton metre second per radian, >= 0: what it adds when the
    /// speed is not quite the one that friction was recorded at.
    pub viscous_nm_s_per_rad: f32,
    /// Change of the efficiency, as a share of it, per share of speed: a worm's friction falls with its speed.
    pub efficiency_per_speed: f32,
    /// Torque of the finger's weight over the difference between closing and opening: half of it, because a worm's friction
    /// cancels, less what the other gears lose (docs/SENSING.md#gravity).
    pub weight_share: f32,
    /// Dead band after a reversal, at the input link, radian, >= 0.
    pub backlash_rad: f32,
}

impl Drivetrain {
    /// Angle between two encoder positions, radian. The difference is taken in integers, so that it neither wraps nor
    /// loses digits.
    pub fn rotation_rad(&self, from_counts: i32, to_counts: i32) -> f32 {
        to_counts.wrapping_sub(from_counts) as f32 * self.rad_per_count
    }

    /// Angle theta_a of the input link at an encoder position while closing, radian, the cable's twist included: the dead
    /// band has been crossed since the stop.
    pub fn closing_rad(&self, counts: i32) -> f32 {
        self.opening_stop_rad - self.backlash_rad + self.rotation_rad(0, counts)
    }
}
