//! Two pins and a contact with an error of the worm's angle, judged together or one after the other.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::Part;

/// Amplitude by which pins are doubted, radian, as the firmware does where nobody states one.
const DOUBTED_RAD: f64 = 1.5e-3;
/// Phases over which the errors of an amplitude are averaged.
const PHASES: usize = 16;

/// All curves of a finger, the contact's last: derivatives by everything that is not known, of which the prior is 1, and by the waves; where
/// each curve ends; which of the unknowns the contact shares with the pins, and which is its place.
pub(super) struct Joined {
    pub(super) part: Part,
    pub(super) ends: Vec<usize>,
    pub(super) shared: Vec<bool>,
    pub(super) place: usize,
}

/// How an error of the place, in units of its prior, follows from what is there.
pub(super) struct Judged {
    /// Deviation without the waves.
    sigma: f64,
    /// Deviation that is claimed.
    claimed: f64,
    /// Amplitude of the error by waves of 1 rad.
    by_waves: f64,
}

impl Joined {
    /// Variances of the place, in its prior's: what is claimed without the error, what an error of this amplitude adds to that, and that of
    /// whoever knows the amplitude.
    pub(super) fn variances(&self, amplitude_rad: f64) -> Option<[f64; 3]> {
        let Part { slopes, waves } = &self.part;
        let unknowns = slopes.ncols();
        let waves = waves * (amplitude_rad / 2f64.sqrt());
        let information = slopes.tr_mul(slopes) + DMatrix::identity(unknowns, unknowns);
        let covariance = information.try_inverse()?;
        let moved = (&covariance * slopes.tr_mul(&waves))
            .row(self.place)
            .norm_squared();
        let mut both = DMatrix::zeros(slopes.nrows(), unknowns + 2);
        both.columns_mut(0, unknowns).copy_from(slopes);
        both.columns_mut(unknowns, 2).copy_from(&waves);
        let information = both.tr_mul(&both) + DMatrix::identity(unknowns + 2, unknowns + 2);
        let knowing = information.try_inverse()?;
        let at = (self.place, self.place);
        Some([covariance[at], moved, knowing[at]])
    }

    /// Who judges the pins with waves of [`DOUBTED_RAD`], and then the contact without any: `keeps` what they have shown of the waves, the
    /// same for all of them, and takes it off the contact.
    pub(super) fn judged(&self, keeps: bool) -> Option<Judged> {
        let Part { slopes, waves } = &self.part;
        let (unknowns, points) = (slopes.ncols(), slopes.nrows());
        let pins = self.ends[self.ends.len() - 2];
        let sizes = waves * (DOUBTED_RAD / 2f64.sqrt());
        // All pins share one pair of waves, or each has its own.
        let own = if keeps { 1 } else { self.ends.len() - 1 };
        let mut all = DMatrix::zeros(pins, unknowns + 2 * own);
        all.columns_mut(0, unknowns)
            .copy_from(&slopes.rows(0, pins));
        let mut from = 0;
        for (pin, &end) in self.ends[..self.ends.len() - 1].iter().enumerate() {
            let column = unknowns + if keeps { 0 } else { 2 * pin };
            let rows = end - from;
            all.view_mut((from, column), (rows, 2))
                .copy_from(&sizes.rows(from, rows));
            from = end;
        }
        let information = all.tr_mul(&all) + DMatrix::identity(all.ncols(), all.ncols());
        let covariance = information.try_inverse()?;
        let told = &covariance * all.transpose();
        // What the contact shares with the pins is known by them, the rest by its prior.
        let mut known = DMatrix::identity(unknowns, unknowns);
        let mut means = DMatrix::zeros(unknowns, pins);
        for one in (0..unknowns).filter(|&one| self.shared[one]) {
            means.set_row(one, &told.row(one));
            for other in (0..unknowns).filter(|&other| self.shared[other]) {
                known[(one, other)] = covariance[(one, other)];
            }
        }
        let contact = slopes.rows(pins, points - pins);
        let mut expected = contact * &means;
        if keeps {
            expected += sizes.rows(pins, points - pins) * told.rows(unknowns, 2);
        }
        let seen = contact * &known * contact.transpose()
            + DMatrix::identity(points - pins, points - pins);
        let gain = &known * contact.transpose() * seen.try_inverse()?;
        let left = &known - &gain * contact * &known;
        // What each point adds to the place.
        let gain = gain.row(self.place);
        let mut by_points = DMatrix::zeros(1, points);
        by_points
            .columns_mut(0, pins)
            .copy_from(&(means.row(self.place) - gain * expected));
        by_points.columns_mut(pins, points - pins).copy_from(&gain);
        let mut by_unknowns = &by_points * slopes;
        by_unknowns[self.place] -= 1.0;
        Some(Judged {
            sigma: by_unknowns.norm().hypot(by_points.norm()),
            claimed: left[(self.place, self.place)].max(0.0).sqrt(),
            by_waves: (&by_points * waves).norm(),
        })
    }
}

impl Judged {
    /// Mean error without sign, and the share within two claimed deviations, with an error of this amplitude.
    pub(super) fn errors(&self, amplitude_rad: f64) -> [f64; 2] {
        let [mean, within2] = biased(
            self.by_waves * amplitude_rad / self.sigma,
            2.0 * self.claimed / self.sigma,
        );
        [mean * self.sigma, within2]
    }
}

/// Normal errors of a deviation about a bias that is a wave of this amplitude with any phase: their mean without sign, in deviations, and
/// the share of them within so many deviations.
pub(super) fn biased(amplitude: f64, deviations: f64) -> [f64; 2] {
    let of_phase = |phase: usize| {
        let bias = amplitude * (TAU * (phase as f64 + 0.5) / PHASES as f64).cos();
        let mean = (2.0 / std::f64::consts::PI).sqrt() * (-0.5 * bias * bias).exp()
            + bias * libm::erf(bias / 2f64.sqrt());
        let below = |x: f64| 0.5 * (1.0 + libm::erf((x - bias) / 2f64.sqrt()));
        [mean, below(deviations) - below(-deviations)]
    };
    let sum = (0..PHASES)
        .map(of_phase)
        .fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    sum.map(|sum| sum / PHASES as f64)
}
