//! A four-bar stage, closed by iteration on the loop itself.

/// Ground O_(i-1)O_i, driving lever at O_(i-1), coupler, driven lever at O_i fixed to the next phalanx.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fourbar {
    pub ground: f64,
    pub lever: f64,
    pub coupler: f64,
    pub driven: f64,
    /// Angle from the phalanx back to its driven lever, positive dorsal.
    pub offset: f64,
    /// Side of the line from O_(i-1) to the driven lever's tip on which the driving lever lies: 1 counterclockwise.
    pub mode: f64,
}

impl Fourbar {
    /// Closure error of the coupler, with its derivatives by lever angle and joint angle.
    fn misfit(&self, gamma: f64, angle: f64) -> (f64, f64, f64) {
        self.misfit_at(gamma, (angle - self.offset).sin_cos())
    }

    /// The same with sine and cosine of the driven lever's angle.
    fn misfit_at(&self, gamma: f64, (sin_d, cos_d): (f64, f64)) -> (f64, f64, f64) {
        let (sin_g, cos_g) = gamma.sin_cos();
        let across_x = self.ground + self.driven * cos_d - self.lever * cos_g;
        let across_y = self.driven * sin_d - self.lever * sin_g;
        let misfit = across_x * across_x + across_y * across_y - self.coupler * self.coupler;
        let by_gamma = 2.0 * self.lever * (across_x * sin_g - across_y * cos_g);
        let by_angle = 2.0 * self.driven * (across_y * cos_d - across_x * sin_d);
        (misfit, by_gamma, by_angle)
    }

    /// Lever angle for a joint angle without a start value: on the half turn given by the mode the closure error is monotone.
    pub fn assemble(&self, angle: f64) -> Option<f64> {
        let (sin_d, cos_d) = (angle - self.offset).sin_cos();
        let line = (self.driven * sin_d).atan2(self.ground + self.driven * cos_d);
        let (mut near, mut far) = (line, line + self.mode * std::f64::consts::PI);
        if self.misfit(near, angle).0 >= 0.0 || self.misfit(far, angle).0 <= 0.0 {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if self.misfit(middle, angle).0 < 0.0 {
                near = middle;
            } else {
                far = middle;
            }
        }
        Some(0.5 * (near + far))
    }

    /// Lever angle and its derivative for a joint angle, from a nearby start value `gamma`.
    ///
    /// Near a dead point, where no lever angle closes the loop, returns the closest one.
    pub fn follow(&self, mut gamma: f64, angle: f64) -> (f64, f64) {
        let mut slope = 0.0;
        let driven = (angle - self.offset).sin_cos();
        for _ in 0..8 {
            let (misfit, by_gamma, by_angle) = self.misfit_at(gamma, driven);
            let steepness = if by_gamma.abs() > 1e-12 {
                by_gamma
            } else {
                1e-12
            };
            slope = -by_angle / steepness;
            let step = (misfit / steepness).clamp(-0.1, 0.1);
            gamma -= step;
            if step.abs() < 1e-9 {
                break;
            }
        }
        (gamma, slope)
    }
}
