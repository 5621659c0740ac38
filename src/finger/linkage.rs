//! Four-bar linkage, one stage a driven phalanx.

use super::error::try_const;
use super::fourbar::{Advance, FourBar, Levers};
use super::{ConfigError, Configuration, JointStep, Parameters, Transmission, TransmissionFactors};
use crate::numeric::Rotation;

/// Points of joint 3's range at which its stage is asked how far it turns the first stage.
pub(super) const RANGE_SAMPLES: u8 = 64;

/// Four-bars in a row: one stage for two phalanges, two for three and so on, at most five. Its design is the levers of each
/// stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage<const STAGES: usize> {
    pub(super) stage: [FourBar; STAGES],
}

impl<const STAGES: usize> Linkage<STAGES> {
    /// The stages, the one that drives phalanx 2 first.
    pub fn stages(&self) -> &[FourBar; STAGES] {
        &self.stage
    }
}

impl Linkage<1> {
    pub(crate) const fn of(
        [levers]: [Levers; 1],
        finger: &Parameters<2>,
    ) -> Result<Self, ConfigError> {
        let [ground, _] = finger.lengths_m;
        let [_, range] = finger.range_rad;
        Ok(Self {
            stage: [try_const!(FourBar::build(1, ground, levers, range))],
        })
    }
}

impl Linkage<2> {
    pub(crate) const fn of(
        [near, far]: [Levers; 2],
        finger: &Parameters<3>,
    ) -> Result<Self, ConfigError> {
        let [ground_1, ground_2, _] = finger.lengths_m;
        let [_, [low_2, high_2], [low_3, high_3]] = finger.range_rad;
        let second = try_const!(FourBar::build(2, ground_2, far, [low_3, high_3]));
        // The first stage sees u = theta_2 + F3(theta_3): the joints' ranges do not give u's, the stage itself does.
        let (mut least, mut most, mut sample) = (0.0f32, 0.0f32, 0);
        while sample <= RANGE_SAMPLES {
            let share = sample as f32 / RANGE_SAMPLES as f32;
            let theta_3 = Rotation::by(low_3 + share * (high_3 - low_3));
            let turned = second.constant_lever(theta_3).rad();
            (least, most) = (least.min(turned), most.max(turned));
            sample += 1;
        }
        let range = [low_2 + least, high_2 + most];
        let first = try_const!(FourBar::build(1, ground_1, near, range));
        Ok(Self {
            stage: [first, second],
        })
    }

    /// What a step does at the outer and the inner stage's driving levers.
    fn advances(&self, from: &Configuration<3>, step: &JointStep<3>) -> Option<(Advance, Advance)> {
        let ([first, second], [_, theta_2, theta_3]) = (&self.stage, from.turn());
        let inner = second.advance(theta_3, step.half[2])?;
        let u = theta_2.then(second.lever(theta_3));
        Some((first.advance(u, step.half[1].then(inner.half))?, inner))
    }
}

impl Transmission<2> for Linkage<1> {
    type Design = [Levers; 1];

    const UNEVEN: bool = false;

    fn build(design: Self::Design, finger: &Parameters<2>) -> Result<Self, ConfigError> {
        Self::of(design, finger)
    }

    fn factors(&self, at: &Configuration<2>) -> Option<TransmissionFactors<2>> {
        let ([first], [_, theta_2]) = (&self.stage, at.turn());
        let ratio = first.ratio(theta_2)?;
        Some(TransmissionFactors {
            x: [1.0, ratio.first],
            w: [[0.0, 0.0], [0.0, ratio.second]],
        })
    }

    fn rotation_rad(&self, at: &Configuration<2>) -> f32 {
        let ([first], [theta_1, _], [_, theta_2]) = (&self.stage, at.rad(), at.turn());
        theta_1 + first.lever(theta_2).rad()
    }

    fn turned_rad(&self, from: &Configuration<2>, step: &JointStep<2>) -> Option<f32> {
        let ([first], [_, theta_2]) = (&self.stage, from.turn());
        Some(step.rad[0] + 2.0 * first.advance(theta_2, step.half[1])?.half.rad())
    }

    fn x_change(&self, from: &Configuration<2>, step: &JointStep<2>) -> Option<[f32; 2]> {
        let ([first], [_, theta_2]) = (&self.stage, from.turn());
        Some([0.0, first.advance(theta_2, step.half[1])?.first_change])
    }

    fn changes(&self, from: &Configuration<2>, step: &JointStep<2>) -> Option<(f32, [f32; 2])> {
        let ([first], [_, theta_2]) = (&self.stage, from.turn());
        let advance = first.advance(theta_2, step.half[1])?;
        let turned_rad = step.rad[0] + 2.0 * advance.half.rad();
        Some((turned_rad, [0.0, advance.first_change]))
    }
}

impl Transmission<3> for Linkage<2> {
    type Design = [Levers; 2];

    fn build(design: Self::Design, finger: &Parameters<3>) -> Result<Self, ConfigError> {
        Self::of(design, finger)
    }

    fn factors(&self, at: &Configuration<3>) -> Option<TransmissionFactors<3>> {
        let ([first, second], [_, theta_2, theta_3]) = (&self.stage, at.turn());
        let inner = second.ratio(theta_3)?;
        let outer = first.ratio(theta_2.then(second.lever(theta_3)))?;
        let w_23 = outer.second * inner.first;
        let w_33 = w_23 * inner.first + outer.first * inner.second;
        Some(TransmissionFactors {
            x: [1.0, outer.first, outer.first * inner.first],
            w: [[0.0; 3], [0.0, outer.second, w_23], [0.0, w_23, w_33]],
        })
    }

    fn rotation_rad(&self, at: &Configuration<3>) -> f32 {
        let ([first, second], [theta_1, ..], [_, theta_2, theta_3]) =
            (&self.stage, at.rad(), at.turn());
        theta_1 + first.lever(theta_2.then(second.lever(theta_3))).rad()
    }

    fn turned_rad(&self, from: &Configuration<3>, step: &JointStep<3>) -> Option<f32> {
        let (outer, _) = self.advances(from, step)?;
        Some(step.rad[0] + 2.0 * outer.half.rad())
    }

    fn x_change(&self, from: &Configuration<3>, step: &JointStep<3>) -> Option<[f32; 3]> {
        let (outer, inner) = self.advances(from, step)?;
        let ([_, second], [.., theta_3]) = (&self.stage, from.turn());
        let [_, x2, _] = self.factors(from)?.x;
        let inner_now = second.ratio(theta_3)?.first + inner.first_change;
        Some([
            0.0,
            outer.first_change,
            outer.first_change * inner_now + x2 * inner.first_change,
        ])
    }
}
