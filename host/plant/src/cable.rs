//! The cable: it stiffens as it is pulled, and creeps with two time constants.

use crate::mechanics::CableEnd;
use crate::parameters::Parameters;

#[derive(Clone, Copy, Debug)]
struct Creep {
    /// Final creep, relative to the elastic twist.
    share: f64,
    time_s: f64,
    /// Present creep, radian.
    twist: f64,
}

/// Configuration and state.
#[derive(Clone, Debug)]
pub(crate) struct Cable {
    /// At no torque, newton metre per radian.
    stiffness: f64,
    /// Growth of the stiffness, relative per newton metre.
    stiffening: f64,
    creep: [Creep; 2],
}

impl Cable {
    pub fn new(parameters: &Parameters) -> Self {
        let cable = &parameters.cable;
        let creep = |share, time_s| Creep {
            share,
            time_s,
            twist: 0.0,
        };
        Self {
            stiffness: parameters.cable_stiffness_nm_per_rad(),
            stiffening: cable.stiffening_per_nm,
            creep: [
                creep(cable.creep_fraction, cable.creep_time_s),
                creep(cable.slow_creep_fraction, cable.slow_creep_time_s),
            ],
        }
    }

    /// Tangent stiffness at a torque, newton metre per radian.
    fn tangent(&self, torque: f64) -> f64 {
        self.stiffness * (1.0 + self.stiffening * torque.abs())
    }

    /// Elastic twist of a torque, radian.
    fn twist(&self, torque: f64) -> f64 {
        let magnitude = torque.abs();
        let share = self.stiffening * magnitude;
        // ln(1 + s T) / s, which tends to T without stiffening.
        let twist = if share > 1e-9 {
            share.ln_1p() / self.stiffening
        } else {
            magnitude
        };
        torque.signum() * twist / self.stiffness
    }

    /// Elastic energy at a torque, joule.
    pub fn energy(&self, torque: f64) -> f64 {
        let magnitude = torque.abs();
        let share = self.stiffening * magnitude;
        if share > 1e-6 {
            (magnitude - share.ln_1p() / self.stiffening) / (self.stiffening * self.stiffness)
        } else {
            0.5 * magnitude * magnitude / self.stiffness
        }
    }

    /// Advances the creep under a torque.
    pub fn creep(&mut self, torque: f64, dt: f64) {
        let elastic = self.twist(torque);
        for creep in &mut self.creep {
            creep.twist += (creep.share * elastic - creep.twist) * (dt / creep.time_s).min(1.0);
        }
    }

    /// Linearised cable around a torque, with the drivetrain's end in the `middle` of a dead band.
    pub fn end(&self, middle: f64, half_backlash: f64, torque: f64) -> CableEnd {
        let tangent = self.tangent(torque);
        let middle = middle - self.creep.iter().map(|creep| creep.twist).sum::<f64>();
        let bent = self.twist(torque) - torque / tangent;
        CableEnd {
            low_rad: middle - half_backlash - bent.max(0.0),
            high_rad: middle + half_backlash - bent.min(0.0),
            stiffness_nm_per_rad: tangent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stiffens_along_its_own_curve() {
        let mut parameters = Parameters::default();
        parameters.cable.stiffening_per_nm = 0.5;
        let cable = Cable::new(&parameters);
        let start = parameters.cable_stiffness_nm_per_rad();
        // 17.5 % at 0.35 N m.
        assert!((cable.tangent(0.35) / start - 1.175).abs() < 1e-12);
        for torque in [-0.35, -0.01, 0.02, 0.35] {
            let slope = (cable.twist(torque + 1e-6) - cable.twist(torque - 1e-6)) / 2e-6;
            assert!((slope * cable.tangent(torque) - 1.0).abs() < 1e-6);
            // The line passes through the torque at its own twist.
            let end = cable.end(0.0, 0.003, torque);
            let flank = 0.003 * torque.signum();
            let found = end.torque_nm(-flank - cable.twist(torque));
            assert!((found - torque).abs() < 1e-9, "{found} {torque}");
        }
        let energy = cable.energy(0.35);
        let sum: f64 = (0..35_000)
            .map(|i| {
                let torque = (f64::from(i) + 0.5) * 1e-5;
                torque * 1e-5 / cable.tangent(torque)
            })
            .sum();
        assert!((energy / sum - 1.0).abs() < 1e-6);
    }

    #[test]
    fn it_creeps_fast_and_slowly() {
        let mut parameters = Parameters::default();
        parameters.cable.slow_creep_fraction = 0.03;
        let mut cable = Cable::new(&parameters);
        let elastic = cable.twist(0.2);
        let crept = |cable: &Cable| -cable.end(0.0, 0.0, 0.0).low_rad / elastic;
        let mut after = Vec::new();
        for step in 1..=60_000 {
            cable.creep(0.2, 0.01);
            if [500, 60_000].contains(&step) {
                after.push(crept(&cable));
            }
        }
        // After one fast time constant, and after ten slow ones.
        let early = 0.05 * (1.0 - (-1.0f64).exp()) + 0.03 * (1.0 - (-5.0f64 / 60.0).exp());
        assert!((after[0] - early).abs() < 1e-4, "{after:?} {early}");
        assert!((after[1] - 0.08).abs() < 1e-4, "{after:?}");
    }
}
